//! What the commands of identification by spectrum analysis share: the robot, its true parameters where the
//! file has them, artefacts that belong to it.

use identification::model::parameter::BaseParameter;
use identification::model::parameter::ParameterId;
use std::path::Path;

use identification::estimate::artefact::Estimate;
use identification::model::known_load::KnownLoad;
use identification::model::reference::ModelReference;
use identification::model::regressor::Regressor;
use robot::{Inertial, Robot, RotorInertia, StandardParameter};

use crate::failure::Failure;
use crate::model::{Derived, ModelArguments, standard_map};

/// A robot with its base regressor and the name that artefacts bear.
pub struct Subject {
    pub robot: Robot,
    pub derived: Derived,
    pub regressor: Box<dyn Regressor>,
    pub reference: ModelReference,
}

impl Subject {
    pub fn read(arguments: &ModelArguments) -> Result<Subject, Failure> {
        let robot = arguments.read_with_values()?;
        let mut derived = Derived::new(&robot, &arguments.model)?;
        let regressor = derived.regressor(&robot);
        let fingerprint = format!("{:016x}", derived.base.fingerprint());
        let reference = ModelReference { name: robot.name.clone(), fingerprint };
        Ok(Subject { robot, derived, regressor, reference })
    }

    /// Base parameters from the inertials of the file; `None` where a link that matters has none.
    pub fn truth(&self) -> Option<Vec<f64>> {
        let mut known = false;
        let value = |p: StandardParameter| match p.inertial {
            Inertial::Ia => match self.robot.link(p.link).joint.rotor_inertia {
                RotorInertia::Known(x) => x,
                _ => 0.0,
            },
            inertial => {
                let place = Inertial::BODY.iter().position(|b| *b == inertial);
                let found = self.robot.link(p.link).inertial.zip(place).map(|(x, i)| x[i]);
                known |= found.is_some();
                found.unwrap_or(0.0)
            }
        };
        let standard: Vec<f64> = StandardParameter::all(&self.robot).into_iter().map(value).collect();
        known.then(|| self.derived.parameters.values(&standard))
    }

    /// Fails when an artefact was made with another robot or geometry; an empty fingerprint passes.
    pub fn check(&self, file: &Path, name: &str, fingerprint: &str) -> Result<(), Failure> {
        if fingerprint.is_empty() || fingerprint == self.reference.fingerprint {
            return Ok(());
        }
        Err(Failure::new(format_args!(
            "{}: made with `{name}` ({fingerprint}), but this model is `{}` ({}): its geometry or joints have changed; make it again",
            file.display(),
            self.reference.name,
            self.reference.fingerprint
        )))
    }

    /// The base parameters of an estimate, in the order of the regressor; what is not identifiable is zero.
    pub fn parameters(&self, estimate: &Estimate) -> Vec<f64> {
        let value = |base: &BaseParameter| estimate.value(&ParameterId::Base(base.name.clone()));
        self.regressor.parameters().iter().map(|base| value(base).unwrap_or(0.0)).collect()
    }

    /// Drive gains of an estimate, one a coordinate.
    pub fn estimated_gains(&self, estimate: &Estimate) -> Vec<Option<f64>> {
        let gain = |c: &String| estimate.value(&ParameterId::drive_gain(c));
        self.regressor.coordinates().iter().map(gain).collect()
    }

    /// A known load, and what it adds to the base parameters.
    pub fn load(&self, file: &Path) -> Result<(KnownLoad, Vec<f64>), Failure> {
        let name = file.display().to_string();
        let load = KnownLoad::from_yaml(&name, &read_text(file)?)?;
        let added = load
            .base_parameters(&self.robot, &standard_map(&self.robot, &self.derived.parameters))
            .map_err(|e| Failure::new(format_args!("{name}: {e}")))?;
        Ok((load, added))
    }

    /// Drive gains of the file, one a coordinate.
    pub fn drive_gains(&self) -> Vec<Option<f64>> {
        let gain =
            |k| self.robot.joint_of(robot::value::CoordinateId(k)).and_then(|j| self.robot.link(j).joint.drive_gain);
        (0..self.robot.n_coordinates()).map(gain).collect()
    }

    /// `q1=2.393` of the command line, as index and number.
    pub fn gain_of(&self, text: &str) -> Result<(usize, f64), Failure> {
        let coordinates = self.regressor.coordinates();
        let (name, gain) = text.split_once('=').unwrap_or((text, ""));
        let gain = gain.parse::<f64>().ok().filter(|g| g.is_finite() && *g > 0.0);
        match (coordinates.iter().position(|c| c == name), gain) {
            (Some(k), Some(gain)) => Ok((k, gain)),
            _ => Err(Failure::new(format_args!(
                "`{text}` is no gain: expected COORDINATE=NUMBER in N m/A with a coordinate of {}",
                coordinates.join(", ")
            ))),
        }
    }
}

/// The text of a file.
pub fn read_text(path: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(path).map_err(|e| Failure::new(format_args!("{}: {e}", path.display())))
}

/// Makes a directory, and those above it.
pub fn make_directory(path: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(path).map_err(|e| Failure::new(format_args!("{}: {e}", path.display())))
}
