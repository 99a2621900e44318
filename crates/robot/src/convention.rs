//! Converts the inertial parameters of a link to and from the conventions of other programs.
//!
//! In all conventions the off-diagonal entries are entries of the inertia matrix, ixy = -sum m x y. The conventions differ in the
//! reference point of the inertia (origin of a frame, or centre of mass), in the order of the entries, in the form of the centre
//! of mass (first moment m c, or c), and in whether the inertia is divided by the mass. Two differences are easily overlooked. In
//! Pinocchio, Iyy precedes Ixz. In a URDF, the inertia is about the centre of mass, in the axes of the inertial frame.
//!
//! ```text
//! I_O = I_C + m (c . c E - c c^T)
//! ```
//! I_O, I_C: inertia about the origin and about the centre of mass; m: mass; c: centre of mass; E: identity matrix. The
//! conversions are linear except for divisions by m, so conventions that contain c need m != 0. The caller chooses the frame:
//! Khalil's link frame, or [`crate::Link::file_frame`].

use crate::inertial::{Part, Pose, transform_inertial};

/// A program or file format that defines the names and the order of the ten inertial parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Convention {
    /// SYMORO: XX XY XZ YY YZ ZZ MX MY MZ M.
    Symoro,
    /// Pinocchio: m mx my mz Ixx Ixy Iyy Ixz Iyz Izz (lower triangle, row by row).
    Pinocchio,
    /// URDF: mass, centre x y z, and ixx ixy ixz iyy iyz izz about the centre of mass; rpy is zero.
    Urdf,
    /// FIGAROH: Ixx Ixy Ixz Iyy Iyz Izz mx my mz m.
    Figaroh,
    /// SymPyBotics: L_xx L_xy L_xz L_yy L_yz L_zz l_x l_y l_z m.
    SymPyBotics,
    /// MATLAB: Mass, CenterOfMass, and Inertia = Ixx Iyy Izz Iyz Ixz Ixy about the origin of the body.
    Matlab,
    /// MuJoCo: mass, pos, and fullinertia = xx yy zz xy xz yz about the centre of mass.
    Mujoco,
    /// Drake: mass, p_BoBcm, and unit inertia Gxx Gyy Gzz Gxy Gxz Gyz about the origin Bo.
    Drake,
}

/// The reference point of an inertia matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// The origin of the frame in which the inertia is given.
    Origin,
    /// The centre of mass; the axes are parallel to the axes of the frame.
    Centre,
}

/// The quantity that an entry of a convention contains. The number is the index within XX XY XZ YY YZ ZZ, or within MX MY MZ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BodyEntry {
    Inertia(usize),
    UnitInertia(usize),
    FirstMoment(usize),
    Centre(usize),
    Mass,
}

type ConventionRow = (&'static str, BodyEntry);

/// The ten inertial parameters of one link in some convention, each with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedParameters {
    /// The convention that defines the names and their order.
    pub convention: Convention,
    /// The reference point of the inertia.
    pub about: About,
    /// Name and value of each parameter, in the order of the convention.
    pub values: [(&'static str, f64); 10],
}

impl Convention {
    /// All conventions, in the order of declaration.
    pub const ALL: [Convention; 8] = {
        use Convention::*;
        [Symoro, Pinocchio, Urdf, Figaroh, SymPyBotics, Matlab, Mujoco, Drake]
    };

    /// Name of the convention on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Convention::Symoro => "symoro",
            Convention::Pinocchio => "pinocchio",
            Convention::Urdf => "urdf",
            Convention::Figaroh => "figaroh",
            Convention::SymPyBotics => "sympybotics",
            Convention::Matlab => "matlab",
            Convention::Mujoco => "mujoco",
            Convention::Drake => "drake",
        }
    }

    /// The reference point of the inertia in this convention.
    pub fn about(self) -> About {
        match self {
            Convention::Urdf | Convention::Mujoco => About::Centre,
            _ => About::Origin,
        }
    }

    /// Names of the ten parameters, in the order of the convention.
    pub fn names(self) -> [&'static str; 10] {
        self.rows().map(|r| r.0)
    }

    fn rows(self) -> [ConventionRow; 10] {
        use BodyEntry::{Centre as C, FirstMoment as H, Inertia as I, Mass, UnitInertia as G};
        // Each name belongs to the entry at the same index of the second list. The number in I and G is an index in XX XY XZ YY
        // YZ ZZ; the number in H and C is an index in x y z.
        let (names, entries) = match self {
            Convention::Symoro => (
                ["XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M"],
                [I(0), I(1), I(2), I(3), I(4), I(5), H(0), H(1), H(2), Mass],
            ),
            Convention::Pinocchio => (
                ["m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz"],
                [Mass, H(0), H(1), H(2), I(0), I(1), I(3), I(2), I(4), I(5)],
            ),
            Convention::Urdf => (
                ["mass", "x", "y", "z", "ixx", "ixy", "ixz", "iyy", "iyz", "izz"],
                [Mass, C(0), C(1), C(2), I(0), I(1), I(2), I(3), I(4), I(5)],
            ),
            Convention::Figaroh => (
                ["Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz", "mx", "my", "mz", "m"],
                [I(0), I(1), I(2), I(3), I(4), I(5), H(0), H(1), H(2), Mass],
            ),
            Convention::SymPyBotics => (
                ["L_xx", "L_xy", "L_xz", "L_yy", "L_yz", "L_zz", "l_x", "l_y", "l_z", "m"],
                [I(0), I(1), I(2), I(3), I(4), I(5), H(0), H(1), H(2), Mass],
            ),
            Convention::Matlab => (
                [
                    "Mass",
                    "CenterOfMass_x",
                    "CenterOfMass_y",
                    "CenterOfMass_z",
                    "Ixx",
                    "Iyy",
                    "Izz",
                    "Iyz",
                    "Ixz",
                    "Ixy",
                ],
                [Mass, C(0), C(1), C(2), I(0), I(3), I(5), I(4), I(2), I(1)],
            ),
            Convention::Mujoco => (
                ["mass", "pos_x", "pos_y", "pos_z", "xx", "yy", "zz", "xy", "xz", "yz"],
                [Mass, C(0), C(1), C(2), I(0), I(3), I(5), I(1), I(2), I(4)],
            ),
            Convention::Drake => (
                ["mass", "p_BoBcm_x", "p_BoBcm_y", "p_BoBcm_z", "Gxx", "Gyy", "Gzz", "Gxy", "Gxz", "Gyz"],
                [Mass, C(0), C(1), C(2), G(0), G(3), G(5), G(1), G(2), G(4)],
            ),
        };
        std::array::from_fn(|i| (names[i], entries[i]))
    }

    /// Converts the ten parameters XX .. M, about the origin of a frame and in its axes, to this convention. `None` if the mass
    /// is zero and the convention divides by it.
    pub fn write(self, x: &[f64; 10]) -> Option<NamedParameters> {
        let m = x[9];
        let rows = self.rows();
        let divides = rows.iter().any(|r| matches!(r.1, BodyEntry::Centre(_) | BodyEntry::UnitInertia(_)));
        if divides && m == 0.0 {
            return None;
        }
        let inertia = match self.about() {
            About::Origin => *x,
            About::Centre => {
                let centre = Part::from_parameters(String::new(), x, Pose::IDENTITY.rotation)?;
                let mut about_centre = *x;
                about_centre[..6].copy_from_slice(&centre.inertia);
                about_centre
            }
        };
        let value = |entry: BodyEntry| match entry {
            BodyEntry::Inertia(k) => inertia[k],
            BodyEntry::UnitInertia(k) => inertia[k] / m,
            BodyEntry::FirstMoment(k) => x[6 + k],
            BodyEntry::Centre(k) => x[6 + k] / m,
            BodyEntry::Mass => m,
        };
        Some(NamedParameters { convention: self, about: self.about(), values: rows.map(|(n, e)| (n, value(e))) })
    }

    /// Converts values of this convention, given by name, to the ten parameters XX .. M about the origin of the frame. Fails with
    /// the first name that has no value.
    pub fn read(self, value: impl Fn(&str) -> Option<f64>) -> Result<[f64; 10], &'static str> {
        let rows = self.rows();
        let mut found = [0.0; 10];
        for (found, (name, _)) in found.iter_mut().zip(rows) {
            *found = value(name).ok_or(name)?;
        }
        let m = rows.iter().zip(found).find(|(r, _)| r.1 == BodyEntry::Mass).map_or(0.0, |(_, m)| m);
        let mut x = [0.0; 10];
        x[9] = m;
        let mut centre = [0.0; 3];
        for ((_, entry), v) in rows.into_iter().zip(found) {
            match entry {
                BodyEntry::Inertia(k) => x[k] = v,
                BodyEntry::UnitInertia(k) => x[k] = v * m,
                BodyEntry::FirstMoment(k) => x[6 + k] = v,
                BodyEntry::Centre(k) => {
                    x[6 + k] = v * m;
                    centre[k] = v;
                }
                BodyEntry::Mass => {}
            }
        }
        if self.about() == About::Centre {
            x[6..9].fill(0.0);
            x = transform_inertial(&x, &Pose { position: centre, ..Pose::IDENTITY });
        }
        Ok(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: [f64; 10] = [0.31, -0.02, 0.05, 0.42, 0.03, 0.27, 0.4, -0.3, 0.9, 2.5];

    /// Writing parameters and reading them again gives the same parameters to 1e-14.
    #[test]
    fn there_and_back() {
        for convention in Convention::ALL {
            let written = convention.write(&X).unwrap();
            let back = convention.read(|n| written.values.iter().find(|v| v.0 == n).map(|v| v.1)).unwrap();
            for (a, b) in X.iter().zip(back) {
                assert!((a - b).abs() <= 1e-14, "{}: {a} {b}", convention.name());
            }
            let mut names = convention.names().to_vec();
            names.sort_unstable();
            names.dedup();
            assert_eq!(names.len(), 10);
        }
    }

    #[test]
    fn what_the_entries_are() {
        let masses = [(1.5, [0.1, 0.2, -0.3]), (0.5, [-0.5, 0.1, 0.7])];
        let sum = |f: &dyn Fn([f64; 3]) -> f64| masses.iter().map(|(m, p)| m * f(*p)).sum::<f64>();
        let about = |c: [f64; 3], i: usize, j: usize| {
            sum(&|p| {
                let r = [0, 1, 2].map(|k| p[k] - c[k]);
                (if i == j { r.iter().map(|x| x * x).sum() } else { 0.0 }) - r[i] * r[j]
            })
        };
        let o = [0.0; 3];
        let c = [0, 1, 2].map(|k| sum(&|p| p[k]) / 2.0);
        let [xx, xy, xz, yy, yz, zz] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|(i, j)| about(o, i, j));
        let x = [xx, xy, xz, yy, yz, zz, 2.0 * c[0], 2.0 * c[1], 2.0 * c[2], 2.0];
        let value = |convention: Convention, name: &str| {
            let written = convention.write(&x).unwrap();
            written.values.iter().find(|v| v.0 == name).unwrap().1
        };
        for (found, wanted) in [
            (value(Convention::Pinocchio, "Iyy"), yy),
            (value(Convention::Pinocchio, "Ixz"), xz),
            (value(Convention::Urdf, "ixz"), about(c, 0, 2)),
            (value(Convention::Mujoco, "yz"), about(c, 1, 2)),
            (value(Convention::Matlab, "Iyz"), yz),
            (value(Convention::Drake, "Gzz"), zz / 2.0),
            (value(Convention::Drake, "p_BoBcm_z"), c[2]),
        ] {
            assert!((found - wanted).abs() < 1e-14, "{found} {wanted}");
        }
        assert!(Convention::Urdf.write(&[0.0; 10]).is_none() && Convention::Symoro.write(&[0.0; 10]).is_some());
        assert_eq!(Convention::Urdf.read(|_| None), Err("mass"));
    }
}
