//! The parameters of a motor that turns with several joints, and of an element between joints: names and units.
//!
//! | parameter | letters | torque along w, as `coupling` has it | unit (sliding) |
//! |---|---|---|---|
//! | motor: rotor inertia, viscous and Coulomb friction | IAM, FVM, FSM | d2w/dt2, dw/dt, sign | kg m^2 (kg), N m s/rad (N s/m), N m (N) |
//! | element: the same | IAE, FVE, FSE | d2w/dt2, dw/dt, sign | the same |
//! | element: stiffness | KE | w | N m/rad (N/m) |
//! | element: with sine and cosine, constant | SE, CE, OFFE | sin w, cos w, 1 | N m (N) |

use serde::{Deserialize, Serialize};

use crate::unit::Unit;

/// A parameter of a motor that turns with a joint other than its own, or of an element between joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CouplingParameter {
    /// IAM: rotor inertia of the motor.
    #[serde(skip)]
    Rotor,
    /// FVM: its viscous friction.
    #[serde(skip)]
    Viscous,
    /// FSM: its Coulomb friction.
    #[serde(skip)]
    Coulomb,
    /// IAE: torque of an element per acceleration along it.
    Inertia,
    /// FVE: per speed.
    #[serde(rename = "viscous")]
    ElementViscous,
    /// FSE: with the direction.
    #[serde(rename = "coulomb")]
    ElementCoulomb,
    /// KE: per position.
    #[serde(rename = "spring")]
    Stiffness,
    /// SE: with the sine of the position.
    Sine,
    /// CE: with the cosine of the position.
    Cosine,
    /// OFFE: constant.
    Offset,
}

impl CouplingParameter {
    /// Those of a motor, in the order of their columns.
    pub const MOTOR: [CouplingParameter; 3] = [Self::Rotor, Self::Viscous, Self::Coulomb];
    /// Those that an element may have.
    pub const ELEMENT: [CouplingParameter; 7] = [
        Self::Inertia,
        Self::ElementViscous,
        Self::ElementCoulomb,
        Self::Stiffness,
        Self::Sine,
        Self::Cosine,
        Self::Offset,
    ];

    /// The letters of its name.
    pub fn letters(self) -> &'static str {
        match self {
            CouplingParameter::Rotor => "IAM",
            CouplingParameter::Viscous => "FVM",
            CouplingParameter::Coulomb => "FSM",
            CouplingParameter::Inertia => "IAE",
            CouplingParameter::ElementViscous => "FVE",
            CouplingParameter::ElementCoulomb => "FSE",
            CouplingParameter::Stiffness => "KE",
            CouplingParameter::Sine => "SE",
            CouplingParameter::Cosine => "CE",
            CouplingParameter::Offset => "OFFE",
        }
    }

    /// The unit along a joint that turns.
    pub(crate) fn unit(self) -> Unit {
        match self {
            Self::Rotor | Self::Inertia => Unit::INERTIA,
            Self::Viscous | Self::ElementViscous => Unit::VISCOUS,
            Self::Stiffness => Unit::STIFFNESS,
            Self::Coulomb | Self::ElementCoulomb | Self::Sine | Self::Cosine | Self::Offset => Unit::TORQUE,
        }
    }
}
