//! The nominal torques of a robot, from which a proof bounds torques and powers along a motion: a torque function that is
//! evaluated on intervals of time, the friction, and a possible payload.

use numerics::jet::Jet;
use serde::{Deserialize, Serialize};

/// The torque function of a robot, evaluated on jets (interval Taylor expansions) of its motion.
pub trait EnclosedTorque: Sync {
    /// Torque of each coordinate without friction (N m or N) from the jets of its position, velocity and acceleration.
    fn torque(&self, q: &[Jet], dq: &[Jet], ddq: &[Jet]) -> Vec<Jet>;
}

/// Friction coefficients of a coordinate from the description or an identification.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NominalFriction {
    /// Viscous friction coefficient, N m s/rad (N s/m).
    pub viscous: f64,
    /// Coulomb friction torque, N m (N).
    pub coulomb: f64,
    /// Constant offset of the torque, N m (N).
    pub offset: f64,
}

/// Torque parameters of a robot from an earlier identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdentifiedTorque {
    /// Values of the base parameters, in the order of the columns of the regressor.
    pub parameters: Vec<f64>,
    /// Friction coefficients, one per coordinate.
    pub friction: Vec<NominalFriction>,
}

/// The nominal torques of a robot: from its description, or from an identification.
pub struct NominalTorque<'a> {
    /// Torque function of the robot without payload.
    pub torque: &'a dyn EnclosedTorque,
    /// Friction coefficients, one per coordinate.
    pub friction: Vec<NominalFriction>,
    /// Share of the effort and power limits that a motion may use; the rest of these limits covers errors of the model.
    pub share: f64,
    /// Torque function of the robot with the payload. `None`: no payload is given.
    pub loaded: Option<&'a dyn EnclosedTorque>,
}

impl NominalTorque<'_> {
    /// The nominal torques of the robot with its payload; `None` if no payload is given.
    pub(super) fn with_payload(&self) -> Option<NominalTorque<'_>> {
        let torque = self.loaded?;
        Some(NominalTorque { torque, friction: self.friction.clone(), share: self.share, loaded: None })
    }
}
