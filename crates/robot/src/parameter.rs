//! The standard parameters of a link, and their names.

use std::fmt;

use crate::robot::{Link, LinkId, Robot, RotorInertia};

/// A standard parameter: one of the ten inertial parameters of a link, or its rotor inertia. Vectors of parameters have the order
/// of this enum.
///
/// XX .. ZZ: inertia about the origin of the link frame, in its axes, kg m^2 (XY = -sum m x y, the entry of the matrix). MX
/// MY MZ: first moments, kg m. M: mass, kg. Ia: rotor inertia as seen from the joint, kg m^2 (kg for a prismatic joint); its
/// torque is Ia ddq_j.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Inertial {
    /// XX = sum m (y^2 + z^2), kg m^2.
    Xx,
    /// XY = -sum m x y, kg m^2.
    Xy,
    /// XZ = -sum m x z, kg m^2.
    Xz,
    /// YY = sum m (x^2 + z^2), kg m^2.
    Yy,
    /// YZ = -sum m y z, kg m^2.
    Yz,
    /// ZZ = sum m (x^2 + y^2), kg m^2.
    Zz,
    /// MX = sum m x, kg m.
    Mx,
    /// MY = sum m y, kg m.
    My,
    /// MZ = sum m z, kg m.
    Mz,
    /// Mass M = sum m, kg.
    M,
    /// Rotor inertia IA as seen from the joint, kg m^2 (kg for a prismatic joint).
    Ia,
}

impl Inertial {
    /// The ten inertial parameters of a body, without the rotor inertia.
    pub const BODY: [Inertial; 10] = {
        use Inertial::*;
        [Xx, Xy, Xz, Yy, Yz, Zz, Mx, My, Mz, M]
    };

    /// The name of the parameter in SYMORO, for example `XX`, `MX` or `IA`.
    pub fn letters(self) -> &'static str {
        use Inertial::*;
        match self {
            Xx => "XX",
            Xy => "XY",
            Xz => "XZ",
            Yy => "YY",
            Yz => "YZ",
            Zz => "ZZ",
            Mx => "MX",
            My => "MY",
            Mz => "MZ",
            M => "M",
            Ia => "IA",
        }
    }

    /// Whether the parameter is a first moment: MX, MY or MZ.
    pub fn is_first_moment(self) -> bool {
        matches!(self, Inertial::Mx | Inertial::My | Inertial::Mz)
    }
}

/// One standard parameter of one link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StandardParameter {
    /// The link to which the parameter belongs. A rotor inertia belongs to the link that its joint moves.
    pub link: LinkId,
    /// Which of the eleven parameters it is.
    pub inertial: Inertial,
}

impl StandardParameter {
    /// All standard parameters of a robot, link by link: XX XY XZ YY YZ ZZ MX MY MZ M, and then IA if the joint has
    /// a rotor inertia.
    pub fn all(robot: &Robot) -> Vec<StandardParameter> {
        let of_link = |(j, link): (usize, &Link)| {
            let rotor = link.joint.rotor_inertia.is_modelled().then_some(Inertial::Ia);
            let inertials = Inertial::BODY.into_iter().chain(rotor);
            inertials.map(move |inertial| StandardParameter { link: LinkId(j), inertial })
        };
        robot.links.iter().enumerate().skip(robot.massless).flat_map(of_link).collect()
    }

    /// The nominal value of the parameter; `None` if the description gives none.
    pub fn value(self, robot: &Robot) -> Option<f64> {
        let link = robot.link(self.link);
        match (Inertial::BODY.iter().position(|i| *i == self.inertial), link.joint.rotor_inertia) {
            (Some(k), _) => link.inertial.map(|x| x[k]),
            (None, RotorInertia::Known(x)) => Some(x),
            (None, _) => None,
        }
    }

    /// The name of the parameter with the label of its link: `XX4`, or `XX_elbow` if the label is a word.
    pub fn display(self, robot: &Robot) -> impl fmt::Display {
        let label = &robot.link(self.link).label;
        let separator = if label.starts_with(|c: char| c.is_ascii_digit()) { "" } else { "_" };
        format!("{}{separator}{label}", self.inertial.letters())
    }
}
