//! The parameters of the observation equation: identity, name and unit of each parameter.
//!
//! The name of a parameter is the `Display` of its [`ParameterId`]: letters, then a [`Label`]. Names are parsed only when a file
//! is read.
//!
//! | parameter | letters | unit (prismatic joint) |
//! |---|---|---|
//! | inertia, rotor inertia | XX .. ZZ, IA | kg m^2 (IA: kg) |
//! | first moment, mass | MX MY MZ, M | kg m, kg |
//! | friction proportional to the speed; to the root of the speed | FV, FVP, FVN, FVA; FR | N m s/rad (N s/m); N m (s/rad)^(1/2) (N (s/m)^(1/2)) |
//! | Coulomb friction, offset, Stribeck | FS, FSP, FSN, OFF, FT, FTP, FTN | N m (N) |
//! | Coulomb friction proportional to the load | FL, FLP, FLN | 1 |
//! | motor that turns with several joints, element between joints | IAM, FVM, FSM; IAE, FVE, FSE, KE, SE, CE, OFFE | see [`coupling_parameter`] |
//! | drive gain | KT | N m/A (N/A) |
//!
//! [`coupling_parameter`]: crate::coupling_parameter

use std::fmt;
use std::str::FromStr;

use robot::Inertial;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::coupling_parameter::CouplingParameter;
use crate::label::Label;
use crate::unit::Unit;

/// The identity of a parameter. Parameters with equal names are identical.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ParameterId {
    /// A base parameter of the dynamics.
    Base(BaseName),
    /// A friction parameter of one coordinate.
    Friction(FrictionParameter, Label),
    /// A parameter of a motor that also turns with other joints than its own, or of an element between joints.
    Coupling(CouplingParameter, Label),
    /// The gain of one drive: torque per unit of current.
    DriveGain(Label),
}

impl ParameterId {
    /// The identity of a friction parameter of a coordinate. A rotor inertia among the friction terms is the base parameter IA.
    pub fn friction(parameter: FrictionParameter, coordinate: &str) -> ParameterId {
        let label = Label::of_coordinate(coordinate);
        match parameter {
            FrictionParameter::Rotor => ParameterId::Base(BaseName::plain(Inertial::Ia, label)),
            other => ParameterId::Friction(other, label),
        }
    }

    /// The identity of the drive gain of a coordinate.
    pub fn drive_gain(coordinate: &str) -> ParameterId {
        ParameterId::DriveGain(Label::of_coordinate(coordinate))
    }

    /// The SI unit of the parameter. `is_prismatic`: whether the joint of the parameter is prismatic.
    pub fn unit(&self, is_prismatic: bool) -> Unit {
        match self {
            ParameterId::Base(name) => match name.inertial {
                Inertial::Ia => Unit::INERTIA.along(is_prismatic),
                Inertial::M => Unit::MASS,
                inertial if inertial.is_first_moment() => Unit::FIRST_MOMENT,
                _ => Unit::INERTIA,
            },
            ParameterId::Friction(parameter, _) => parameter.unit().along(is_prismatic),
            ParameterId::Coupling(parameter, _) => parameter.unit().along(is_prismatic),
            ParameterId::DriveGain(_) => Unit::DRIVE_GAIN.along(is_prismatic),
        }
    }
}

impl fmt::Display for ParameterId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ParameterId::Base(name) => name.fmt(f),
            ParameterId::Friction(parameter, label) => write!(f, "{}{label}", parameter.letters()),
            ParameterId::Coupling(parameter, label) => write!(f, "{}{label}", parameter.letters()),
            ParameterId::DriveGain(label) => write!(f, "KT{label}"),
        }
    }
}

/// Reads the name of a parameter. Fails if no parameter can have this name.
impl FromStr for ParameterId {
    type Err = String;

    fn from_str(name: &str) -> Result<ParameterId, String> {
        let behind = |letters: &str| name.strip_prefix(letters).and_then(|rest| rest.parse::<Label>().ok());
        if let Some(label) = behind("KT") {
            return Ok(ParameterId::DriveGain(label));
        }
        for parameter in CouplingParameter::MOTOR.into_iter().chain(CouplingParameter::ELEMENT) {
            if let Some(label) = behind(parameter.letters()) {
                return Ok(ParameterId::Coupling(parameter, label));
            }
        }
        for (parameter, letters, _) in
            FrictionParameter::ALL.into_iter().filter(|(p, ..)| *p != FrictionParameter::Rotor)
        {
            if let Some(label) = behind(letters) {
                return Ok(ParameterId::Friction(parameter, label));
            }
        }
        name.parse().map(ParameterId::Base)
    }
}

impl Serialize for ParameterId {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for ParameterId {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<ParameterId, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

/// A base parameter: the parameter of one column of the base regressor. The parameter is named after one link; the joint of
/// this link determines the other fields.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseParameter {
    /// The name of the parameter.
    pub name: BaseName,
    /// The coordinate of the joint of the named link. If this joint is passive: the coordinates that determine the position of
    /// the joint.
    pub coordinates: Vec<usize>,
    /// Whether the joint of the named link is prismatic.
    pub is_prismatic: bool,
}

impl BaseParameter {
    /// Makes the parameter `name` of a link with a revolute joint, which `coordinate` moves.
    ///
    /// Fails if no base parameter can have this name.
    pub fn turning(name: &str, coordinate: usize) -> Result<BaseParameter, String> {
        Ok(BaseParameter { name: name.parse()?, coordinates: vec![coordinate], is_prismatic: false })
    }
}

/// The name of a base parameter: `ZZR1`, `XXR_elbow`, `D2MXR4`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BaseName {
    /// The length factor of a first moment in a model without gravity, such as `D2` in `D2MXR4`; empty otherwise.
    pub lever: String,
    /// The standard parameter whose column of the regressor is kept after regrouping.
    pub inertial: Inertial,
    /// Whether other standard parameters are regrouped into `inertial`. Then the name has an R after the letters.
    pub absorbs: bool,
    /// The label of the link.
    pub label: Label,
}

impl BaseName {
    /// The name of a parameter into which no other parameter is regrouped.
    pub fn plain(inertial: Inertial, label: Label) -> BaseName {
        BaseName { lever: String::new(), inertial, absorbs: false, label }
    }
}

impl fmt::Display for BaseName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let regrouped = if self.absorbs { "R" } else { "" };
        write!(f, "{}{}{regrouped}{}", self.lever, self.inertial.letters(), self.label)
    }
}

impl FromStr for BaseName {
    type Err = String;

    fn from_str(name: &str) -> Result<BaseName, String> {
        // A name is letters, then an optional R, then a label. The name of a first moment may start with a length factor
        // (lever).
        let at = |start: usize, inertial: Inertial| {
            let rest = name[start..].strip_prefix(inertial.letters())?;
            let found = |absorbs: bool, label: &str| {
                let lever = name[..start].to_string();
                Some(BaseName { lever, inertial, absorbs, label: label.parse().ok()? })
            };
            found(false, rest).or_else(|| found(true, rest.strip_prefix('R')?))
        };
        let inertials = || Inertial::BODY.into_iter().chain([Inertial::Ia]);
        let with_lever = || {
            let starts = name.char_indices().map(|(i, _)| i);
            starts
                .flat_map(|i| inertials().filter(|x| x.is_first_moment()).map(move |x| (i, x)))
                .find_map(|(i, x)| at(i, x))
        };
        let found = inertials().find_map(|inertial| at(0, inertial)).or_else(with_lever);
        found.ok_or_else(|| {
            format!("`{name}` is no parameter: expected letters and a label, such as ZZR1, FV_elbow or KT2")
        })
    }
}

/// A friction parameter of one coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrictionParameter {
    /// FV: viscous friction.
    Viscous,
    /// FS: Coulomb friction.
    Coulomb,
    /// OFF: constant torque.
    Offset,
    /// FVP: viscous friction for dq > 0.
    ViscousForward,
    /// FSP: Coulomb friction for dq > 0.
    CoulombForward,
    /// FVN: viscous friction for dq < 0.
    ViscousBackward,
    /// FSN: Coulomb friction for dq < 0; the value is negative.
    CoulombBackward,
    /// FT: excess of friction near rest (stiction) over Coulomb friction.
    Stribeck,
    /// FTP: excess of stiction for dq > 0.
    StribeckForward,
    /// FTN: excess of stiction for dq < 0.
    StribeckBackward,
    /// FL: growth of Coulomb friction per unit of load torque.
    Load,
    /// FLP: growth of Coulomb friction per unit of load torque for dq > 0.
    LoadForward,
    /// FLN: growth of Coulomb friction per unit of load torque for dq < 0.
    LoadBackward,
    /// IA: rotor inertia, for regressors that do not contain rotor inertias.
    Rotor,
    /// FVA: half of the difference between viscous friction forward and backward.
    ViscousAsymmetry,
    /// FR: friction proportional to the root of the speed.
    Root,
}

impl FrictionParameter {
    /// All parameters, each with its letters and its meaning, in the order of declaration.
    const ALL: [(FrictionParameter, &str, &str); 16] = {
        use FrictionParameter::*;
        [
            (Viscous, "FV", "viscous friction: grows with the speed"),
            (Coulomb, "FS", "Coulomb friction: turns with the direction"),
            (Offset, "OFF", "offset of the torque: sensor, or friction that differs by direction"),
            (ViscousForward, "FVP", "viscous friction forward"),
            (CoulombForward, "FSP", "Coulomb friction forward"),
            (ViscousBackward, "FVN", "viscous friction backward"),
            (CoulombBackward, "FSN", "Coulomb friction backward"),
            (Stribeck, "FT", "friction near rest beyond Coulomb's"),
            (StribeckForward, "FTP", "friction near rest beyond Coulomb's"),
            (StribeckBackward, "FTN", "friction near rest beyond Coulomb's"),
            (Load, "FL", "Coulomb friction per unit of torque"),
            (LoadForward, "FLP", "Coulomb friction per unit of torque"),
            (LoadBackward, "FLN", "Coulomb friction per unit of torque"),
            (Rotor, "IA", "rotor inertia of the motor"),
            (ViscousAsymmetry, "FVA", "viscous friction that differs by direction: half of the difference"),
            (Root, "FR", "friction that grows with the root of the speed"),
        ]
    };

    /// The letters in the name of the parameter: `FV` of `FV3`.
    pub fn letters(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    /// The meaning of the parameter in words.
    pub fn meaning(self) -> &'static str {
        Self::ALL[self as usize].2
    }

    /// Whether the parameter is a friction parameter, but neither standard friction (viscous friction, Coulomb friction,
    /// offset) nor rotor inertia.
    pub fn is_other_friction(self) -> bool {
        let is_coulomb = matches!(self, Self::Coulomb | Self::CoulombForward | Self::CoulombBackward);
        !self.is_viscous() && !is_coulomb && !matches!(self, Self::Offset | Self::Rotor)
    }

    /// Whether the parameter is a viscous friction coefficient. If such a coefficient were negative, friction would drive the
    /// joint instead of braking it.
    pub fn is_viscous(self) -> bool {
        matches!(self, Self::Viscous | Self::ViscousForward | Self::ViscousBackward)
    }

    /// Whether the value must be positive. If it were negative, friction would drive the joint instead of braking it.
    pub fn brakes(self) -> bool {
        self.is_viscous() || matches!(self, Self::Coulomb | Self::CoulombForward)
    }

    /// The unit for a revolute joint.
    fn unit(self) -> Unit {
        match self {
            Self::Viscous | Self::ViscousForward | Self::ViscousBackward | Self::ViscousAsymmetry => Unit::VISCOUS,
            Self::Root => Unit::ROOT_OF_SPEED,
            Self::Load | Self::LoadForward | Self::LoadBackward => Unit::ONE,
            Self::Rotor => Unit::INERTIA,
            _ => Unit::TORQUE,
        }
    }
}

/// The parameter of a column of the observation equation.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// The identity of the parameter.
    pub id: ParameterId,
    /// The coordinates to which the parameter belongs. A friction parameter belongs to one coordinate; a base parameter belongs
    /// to the coordinates that move the joint of its link.
    pub coordinates: Vec<usize>,
    /// Whether the joint of the parameter is prismatic.
    pub is_prismatic: bool,
}

impl Parameter {
    /// The SI unit of the parameter.
    pub fn unit(&self) -> Unit {
        self.id.unit(self.is_prismatic)
    }
}

impl From<&BaseParameter> for Parameter {
    fn from(base: &BaseParameter) -> Parameter {
        Parameter {
            id: ParameterId::Base(base.name.clone()),
            coordinates: base.coordinates.clone(),
            is_prismatic: base.is_prismatic,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_parsed_as_they_are_shown() {
        let base =
            ["XX1", "ZZR1", "XZ_wrist_1", "ZZR_shoulder_pan", "MY2", "MXR10", "M3", "IA1", "D2MXR4", "L_1MX2", "XX4a"];
        let others = [
            "FV1",
            "FS_elbow",
            "OFF3",
            "FVA1",
            "FSN2",
            "FT_q",
            "FL1",
            "FR3",
            "KT2",
            "IAM6",
            "FVM_wrist",
            "FSM6",
            "KE_cable",
            "OFFE_cable",
        ];
        for name in base.iter().chain(&others) {
            let id: ParameterId = name.parse().unwrap();
            assert_eq!(id.to_string(), *name);
            assert_eq!(matches!(id, ParameterId::Base(_)), base.contains(name), "{id:?}");
        }
        for name in ["", "FV", "XXQ1", "1", "ZZR", "_elbow", "FV 1", "drive gain of q1"] {
            assert!(name.parse::<ParameterId>().is_err(), "{name}");
        }
        let Ok(ParameterId::Base(name)) = "D2MXR4".parse() else { panic!() };
        assert_eq!((name.lever.as_str(), name.inertial, name.absorbs), ("D2", Inertial::Mx, true));
    }

    #[test]
    fn units_know_prismatic_joints() {
        for (name, turning, sliding) in [
            ("IA1", "kg m^2", "kg"),
            ("XXR1", "kg m^2", "kg m^2"),
            ("D2MX_arm", "kg m", "kg m"),
            ("MR2", "kg", "kg"),
            ("FV1", "N m s/rad", "N s/m"),
            ("OFF1", "N m", "N"),
            ("FL1", "1", "1"),
            ("KT1", "N m/A", "N/A"),
        ] {
            let id: ParameterId = name.parse().unwrap();
            assert_eq!((id.unit(false).to_string(), id.unit(true).to_string()), (turning.into(), sliding.into()));
        }
    }

    #[test]
    fn each_friction_parameter_stands_at_its_number() {
        for (k, (parameter, ..)) in FrictionParameter::ALL.into_iter().enumerate() {
            assert_eq!(parameter as usize, k, "{parameter:?}");
        }
    }

    #[test]
    fn a_rotor_inertia_has_one_identity() {
        assert_eq!(ParameterId::friction(FrictionParameter::Rotor, "q1"), "IA1".parse().unwrap());
    }
}
