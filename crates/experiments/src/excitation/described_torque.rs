//! What is known of the torques of a robot, for a proof: their enclosures, friction, and a payload that may be there.

use numerics::jet::Jet;
use serde::{Deserialize, Serialize};

/// The torque function of a described robot on jets of its motion.
pub trait EnclosedTorque: Sync {
    /// Torque of each coordinate, N m (N), friction left out.
    fn torque(&self, q: &[Jet], dq: &[Jet], ddq: &[Jet]) -> Vec<Jet>;
}

/// Friction that the description gives for a coordinate: N m s/rad, N m (N s/m, N).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DescribedFriction {
    /// N m s/rad (N s/m).
    pub viscous: f64,
    /// N m (N).
    pub coulomb: f64,
    /// N m (N).
    pub offset: f64,
}

/// Torques as an earlier identification found them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdentifiedTorque {
    /// Base parameters, in the order of the model.
    pub parameters: Vec<f64>,
    /// One per coordinate.
    pub friction: Vec<DescribedFriction>,
}

/// What is known of the torques of a robot, described or identified.
pub struct DescribedTorque<'a> {
    /// Encloses the torque of the description.
    pub torque: &'a dyn EnclosedTorque,
    /// One per coordinate.
    pub friction: Vec<DescribedFriction>,
    /// Share of the limits of effort and power that a motion may use: the description is not the robot.
    pub share: f64,
    /// The same torque with a payload that may be there.
    pub loaded: Option<&'a dyn EnclosedTorque>,
}

impl DescribedTorque<'_> {
    /// With the payload, where one may be there.
    pub(super) fn with_payload(&self) -> Option<DescribedTorque<'_>> {
        let torque = self.loaded?;
        Some(DescribedTorque { torque, friction: self.friction.clone(), share: self.share, loaded: None })
    }
}
