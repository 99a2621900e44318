//! The parameters of a motor that turns with several joints, and of an element between joints: names and units.
//!
//! | parameter | letters | torque along w (`coupling`) | unit (prismatic) |
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
    /// FVM: viscous friction of the motor.
    #[serde(skip)]
    Viscous,
    /// FSM: Coulomb friction of the motor.
    #[serde(skip)]
    Coulomb,
    /// IAE: torque of an element per acceleration along it.
    Inertia,
    /// FVE: torque of an element per speed along it.
    #[serde(rename = "viscous")]
    ElementViscous,
    /// FSE: torque of an element with the sign of its speed.
    #[serde(rename = "coulomb")]
    ElementCoulomb,
    /// KE: torque of an element per position along it.
    #[serde(rename = "spring")]
    Stiffness,
    /// SE: torque of an element over the sine of its position.
    Sine,
    /// CE: torque of an element over the cosine of its position.
    Cosine,
    /// OFFE: constant torque of an element.
    Offset,
}

impl CouplingParameter {
    /// The parameters of a motor, in the order of their columns.
    pub const MOTOR: [CouplingParameter; 3] = [Self::Rotor, Self::Viscous, Self::Coulomb];
    /// The parameters that an element may have.
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

    /// The unit along a revolute joint.
    pub(crate) fn unit(self) -> Unit {
        match self {
            Self::Rotor | Self::Inertia => Unit::INERTIA,
            Self::Viscous | Self::ElementViscous => Unit::VISCOUS,
            Self::Stiffness => Unit::STIFFNESS,
            Self::Coulomb | Self::ElementCoulomb | Self::Sine | Self::Cosine | Self::Offset => Unit::TORQUE,
        }
    }
}
