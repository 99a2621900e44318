//! Reference of an artefact to its robot.

use serde::{Deserialize, Serialize};

/// The robot of an artefact.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ModelReference {
    /// Name of the robot.
    pub name: String,
    /// Fingerprint of its base regressor, which differs for a robot of the same name with another geometry.
    pub fingerprint: String,
}
