//! A load with known mass and geometry: its file, and its contribution to the base parameters.
//!
//! phi_L are the ten parameters of the load in the frame of the link that carries it, and X = B phi maps standard to base
//! parameters. The load adds B_L phi_L to the base parameters, where B_L are the ten columns of B that belong to the link. So
//! its torque Y B_L phi_L is known.

use robot::{Error, Link, Part, Place, Pose, Robot, transform_inertial};
use serde::{Deserialize, Serialize};

use crate::pseudo_inertia::smallest_eigenvalue;
use crate::standard_map::StandardMap;
use crate::yaml;

/// A known load on a link, with the fields of its file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KnownLoad {
    /// Name of a link of the model, or of a frame that is fixed to a link: `tool0`.
    pub link: String,
    /// Mass of the load, kg.
    pub mass: f64,
    /// Centre of mass, m, in the frame of the link or in the named frame, as the file of the model defines it.
    pub centre_of_mass: [f64; 3],
    /// Inertia about the centre of mass, kg m^2, in the axes of the frame in which the centre of mass is given. Zero if the
    /// file does not give it.
    #[serde(default)]
    pub inertia: Inertia,
}

/// The entries of an inertia matrix. Products of inertia have the sign of the matrix entry: xy = - sum m x y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Inertia {
    /// Entry xx, kg m^2.
    pub xx: f64,
    /// Entry xy, kg m^2.
    pub xy: f64,
    /// Entry xz, kg m^2.
    pub xz: f64,
    /// Entry yy, kg m^2.
    pub yy: f64,
    /// Entry yz, kg m^2.
    pub yz: f64,
    /// Entry zz, kg m^2.
    pub zz: f64,
}

/// Allowed negative eigenvalue of a pseudo-inertia, relative to the largest entries of the matrix. Rounding can make a zero
/// eigenvalue negative by this amount.
const EIGENVALUE_ROUNDING: f64 = 1e-12;

impl KnownLoad {
    /// Reads a load from the text of its file. Fails at an unexpected entry, and if no body can have this mass and inertia.
    pub fn from_yaml(file: &str, text: &str) -> Result<KnownLoad, Error> {
        let error = |message: String| Error { place: Place { file: file.into(), ..Place::default() }, message };
        let load: KnownLoad = yaml::read(text).map_err(|e| error(format!("this is no load: {e}")))?;
        load.fault().map_or(Ok(load), |fault| Err(error(fault)))
    }

    /// The reason why no body can have this mass and inertia, as text. `None` if mass and inertia are possible.
    pub fn fault(&self) -> Option<String> {
        let at_centre = KnownLoad { centre_of_mass: [0.0; 3], ..self.clone() };
        let finite = self.part().parameters().iter().all(|x| x.is_finite());
        let i = self.inertia;
        // A point mass has zero moments of inertia. So zero eigenvalues are allowed, and negative ones within the rounding
        // error.
        let least = -EIGENVALUE_ROUNDING * (i.xx.abs() + i.yy.abs() + i.zz.abs() + self.mass.abs());
        let is_none = !finite || self.mass <= 0.0 || smallest_eigenvalue(&at_centre.part().parameters()) < least;
        is_none.then(|| {
            "no body has this mass and inertia: a positive mass is needed, in kg, and moments about the centre of mass of \
             which none exceeds the sum of the other two, in kg m^2"
                .into()
        })
    }

    /// The contribution B_L phi_L of the load to the base parameters (phi_L: ten parameters of the load, B_L: columns of the link
    /// in X = B phi). Fails if the robot has no such link, or if no joint moves the link.
    pub fn base_parameters(&self, robot: &Robot, map: &StandardMap) -> Result<Vec<f64>, String> {
        let (link, frame) = self.carrier(robot)?;
        let Some(&(_, first)) = map.bodies.iter().find(|(name, _)| *name == link.name) else {
            return Err(format!(
                "the load is on `{}`: no torque depends on a body there, since no joint moves it",
                self.link
            ));
        };
        let ten = transform_inertial(&self.part().parameters(), &frame);
        let columns = map.matrix.columns(first, 10);
        Ok((0..map.matrix.nrows()).map(|k| (0..10).map(|c| columns[(k, c)] * ten[c]).sum()).collect())
    }

    /// The link that carries the load, and the pose of the frame of the load in the frame of this link.
    fn carrier<'a>(&self, robot: &'a Robot) -> Result<(&'a Link, Pose), String> {
        let fixed = |link: &'a Link| {
            let frame = link.frames.iter().find(|(name, _)| *name == self.link);
            frame.map(|(_, pose)| (link, *pose))
        };
        let own = robot.links.iter().find(|link| link.name == self.link).map(|link| (link, link.file_frame));
        own.or_else(|| robot.links.iter().find_map(fixed)).ok_or_else(|| {
            let fixed =
                |link: &'a Link| link.frames.iter().map(|(name, _)| name.as_str()).filter(|name| *name != link.name);
            let names = robot.links.iter().flat_map(|link| std::iter::once(link.name.as_str()).chain(fixed(link)));
            let names: Vec<&str> = names.collect();
            format!("the load is on the link `{}`; the links that joints move are {}", self.link, names.join(", "))
        })
    }

    fn part(&self) -> Part {
        let Inertia { xx, xy, xz, yy, yz, zz } = self.inertia;
        Part {
            name: self.link.clone(),
            pose: Pose { position: self.centre_of_mass, ..Pose::IDENTITY },
            mass: self.mass,
            inertia: [xx, xy, xz, yy, yz, zz],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str =
        "link: forearm\nmass: 2\ncentre_of_mass: [0.3, 0, 0.1]\ninertia: {xx: 0.01, yy: 0.02, zz: 0.02}\n";

    #[test]
    fn a_file_is_a_body() {
        let load = KnownLoad::from_yaml("load.yaml", FILE).unwrap();
        // Parallel axis theorem: 0.01 + 2 0.1^2, 0.02 + 2 (0.3^2 + 0.1^2), 0.02 + 2 0.3^2, -2 0.3 0.1, up to rounding.
        let expected = [0.03, 0.0, -0.06, 0.22, 0.0, 0.2, 0.6, 0.0, 0.2, 2.0];
        for (x, y) in load.part().parameters().iter().zip(expected) {
            assert!((x - y).abs() < 1e-15, "{x} {y}");
        }
        let point = KnownLoad::from_yaml("load.yaml", "link: a\nmass: 1\ncentre_of_mass: [0, 0, 0.1]\n").unwrap();
        assert_eq!(point.inertia, Inertia::default());
    }

    #[test]
    fn refusals() {
        for (from, to, says) in [
            ("mass: 2", "mass: -2", "no body has"),
            ("mass: 2", "mass: .nan", "no body has"),
            ("zz: 0.02", "zz: 0.2", "no body has"),
            ("mass: 2", "weight: 2", "this is no load"),
        ] {
            let message = KnownLoad::from_yaml("load.yaml", &FILE.replace(from, to)).unwrap_err().to_string();
            assert!(message.contains(says) && message.contains("load.yaml"), "{message}");
        }
    }
}
