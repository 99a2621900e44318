//! The parameters of a motor that turns with several joints, and of an element between joints: names and units.
//!
//! | parameter | letters | column f along w (see `coupling`) | unit (prismatic) |
//! |---|---|---|---|
//! | motor: rotor inertia, viscous and Coulomb friction | IAM, FVM, FSM | d2w/dt2, dw/dt, sign | kg m^2 (kg), N m s/rad (N s/m), N m (N) |
//! | element: inertia, viscous and Coulomb friction | IAE, FVE, FSE | d2w/dt2, dw/dt, sign | like the motor |
//! | element: stiffness | KE | w | N m/rad (N/m) |
//! | element: sine, cosine and constant torque | SE, CE, OFFE | sin w, cos w, 1 | N m (N) |

use serde::{Deserialize, Serialize};

use crate::unit::Unit;

/// A parameter of a motor that also turns with a joint other than its own, or of an element between joints.
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
    /// IAE: inertia of an element (torque of the element per acceleration d2w/dt2).
    Inertia,
    /// FVE: viscous friction of an element (torque of the element per speed dw/dt).
    #[serde(rename = "viscous")]
    ElementViscous,
    /// FSE: Coulomb friction of an element (torque of constant size, with the sign of the speed dw/dt).
    #[serde(rename = "coulomb")]
    ElementCoulomb,
    /// KE: stiffness of an element (torque of the element per position w).
    #[serde(rename = "spring")]
    Stiffness,
    /// SE: torque of an element that is proportional to sin w.
    Sine,
    /// CE: torque of an element that is proportional to cos w.
    Cosine,
    /// OFFE: constant torque of an element.
    Offset,
}

impl CouplingParameter {
    /// The parameters of a motor, in the order of their columns.
    pub const MOTOR: [CouplingParameter; 3] = [Self::Rotor, Self::Viscous, Self::Coulomb];
    /// The parameters that the user can give to an element.
    pub const ELEMENT: [CouplingParameter; 7] = [
        Self::Inertia,
        Self::ElementViscous,
        Self::ElementCoulomb,
        Self::Stiffness,
        Self::Sine,
        Self::Cosine,
        Self::Offset,
    ];

    /// The letters in the name of the parameter: `IAM` of `IAM3`.
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

    /// The SI unit if the motor or element acts on revolute joints.
    pub(crate) fn unit(self) -> Unit {
        match self {
            Self::Rotor | Self::Inertia => Unit::INERTIA,
            Self::Viscous | Self::ElementViscous => Unit::VISCOUS,
            Self::Stiffness => Unit::STIFFNESS,
            Self::Coulomb | Self::ElementCoulomb | Self::Sine | Self::Cosine | Self::Offset => Unit::TORQUE,
        }
    }
}
