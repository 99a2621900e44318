//! The nominal torques of a robot for a proof: their enclosures, friction, and a possible payload.

use numerics::jet::Jet;
use serde::{Deserialize, Serialize};

/// The torque function of a robot, evaluated on jets (interval Taylor expansions) of its motion.
pub trait EnclosedTorque: Sync {
    /// Torque of each coordinate without friction, N m (N).
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

/// Torque parameters from an earlier identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdentifiedTorque {
    /// Values of the base parameters, in the order of the model.
    pub parameters: Vec<f64>,
    /// Friction coefficients, one per coordinate.
    pub friction: Vec<NominalFriction>,
}

/// The torques of a robot from its description, or from an identification.
pub struct NominalTorque<'a> {
    /// Torque function without payload.
    pub torque: &'a dyn EnclosedTorque,
    /// Friction coefficients, one per coordinate.
    pub friction: Vec<NominalFriction>,
    /// Share of the limits of effort and power that a motion may use; the rest of the limits covers errors of the model.
    pub share: f64,
    /// Torque function with the possible payload; `None`: there is no payload.
    pub loaded: Option<&'a dyn EnclosedTorque>,
}

impl NominalTorque<'_> {
    /// The torques with the payload instead of without; `None` if there is no payload.
    pub(super) fn with_payload(&self) -> Option<NominalTorque<'_>> {
        let torque = self.loaded?;
        Some(NominalTorque { torque, friction: self.friction.clone(), share: self.share, loaded: None })
    }
}
