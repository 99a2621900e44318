//! The SI units of parameters, for revolute and for prismatic joints.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The SI unit of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit(&'static str);

/// Pairs of units of joint parameters (IA, friction, drive gain): for a revolute joint, and for a prismatic joint.
const UNITS_BY_JOINT_KIND: [(Unit, Unit); 6] = [
    (Unit::INERTIA, Unit::MASS),
    (Unit::TORQUE, Unit("N")),
    (Unit::VISCOUS, Unit("N s/m")),
    (Unit::DRIVE_GAIN, Unit("N/A")),
    (Unit::STIFFNESS, Unit("N/m")),
    (Unit::ROOT_OF_SPEED, Unit("N (s/m)^(1/2)")),
];

impl Unit {
    /// Unit of an inertia, kg m^2.
    pub const INERTIA: Unit = Unit("kg m^2");
    /// Unit of a first moment, kg m.
    pub const FIRST_MOMENT: Unit = Unit("kg m");
    /// Unit of a mass, kg.
    pub(crate) const MASS: Unit = Unit("kg");
    /// Unit of a torque, N m.
    pub const TORQUE: Unit = Unit("N m");
    /// Unit of viscous friction, N m s/rad.
    pub const VISCOUS: Unit = Unit("N m s/rad");
    /// Unit of a stiffness, N m/rad.
    pub(crate) const STIFFNESS: Unit = Unit("N m/rad");
    /// Unit of friction per root of the speed, N m (s/rad)^(1/2).
    pub(crate) const ROOT_OF_SPEED: Unit = Unit("N m (s/rad)^(1/2)");
    /// Unit of a drive gain, N m/A.
    pub(crate) const DRIVE_GAIN: Unit = Unit("N m/A");
    /// The unit of a pure number.
    pub const ONE: Unit = Unit("1");

    /// The unit of a joint parameter. `self` is the unit of the parameter for a revolute joint. For a prismatic joint, the
    /// corresponding unit is returned.
    pub fn along(self, is_prismatic: bool) -> Unit {
        let sliding = UNITS_BY_JOINT_KIND.iter().find(|(turning, _)| is_prismatic && *turning == self);
        sliding.map_or(self, |(_, sliding)| *sliding)
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.0)
    }
}

impl FromStr for Unit {
    type Err = String;

    fn from_str(text: &str) -> Result<Unit, String> {
        let alone = [Unit::FIRST_MOMENT, Unit::ONE];
        let mut all = UNITS_BY_JOINT_KIND.into_iter().flat_map(|(turning, sliding)| [turning, sliding]).chain(alone);
        all.find(|unit| unit.0 == text).ok_or_else(|| format!("`{text}` is no unit of a parameter"))
    }
}

impl Serialize for Unit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0)
    }
}

impl<'de> Deserialize<'de> for Unit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Unit, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}
