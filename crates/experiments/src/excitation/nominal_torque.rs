//! The torques of a robot for a proof: their enclosures, friction, and a possible payload.

use numerics::jet::Jet;
use serde::{Deserialize, Serialize};

/// The torque function of a described robot on jets of its motion.
pub trait EnclosedTorque: Sync {
    /// Torque of each coordinate, N m (N), without friction.
    fn torque(&self, q: &[Jet], dq: &[Jet], ddq: &[Jet]) -> Vec<Jet>;
}

/// Friction of a coordinate from the description.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NominalFriction {
    /// Viscous friction, N m s/rad (N s/m).
    pub viscous: f64,
    /// Coulomb friction, N m (N).
    pub coulomb: f64,
    /// Offset, N m (N).
    pub offset: f64,
}

/// Torques from an earlier identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdentifiedTorque {
    /// Base parameters, in the order of the model.
    pub parameters: Vec<f64>,
    /// Friction, one per coordinate.
    pub friction: Vec<NominalFriction>,
}

/// The torques of a robot, from the description or identified.
pub struct NominalTorque<'a> {
    /// Encloses the torque without payload.
    pub torque: &'a dyn EnclosedTorque,
    /// Friction, one per coordinate.
    pub friction: Vec<NominalFriction>,
    /// Share of the limits of effort and power that a motion may use; the rest covers errors of the description.
    pub share: f64,
    /// Encloses the torque with the possible payload.
    pub loaded: Option<&'a dyn EnclosedTorque>,
}

impl NominalTorque<'_> {
    /// The torques with the payload; `None` where there is none.
    pub(super) fn with_payload(&self) -> Option<NominalTorque<'_>> {
        let torque = self.loaded?;
        Some(NominalTorque { torque, friction: self.friction.clone(), share: self.share, loaded: None })
    }
}
