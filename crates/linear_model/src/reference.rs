//! The robot that an artefact was made for.

use serde::{Deserialize, Serialize};

/// The robot that an artefact is about.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ModelReference {
    /// Name of the robot.
    pub name: String,
    /// Fingerprint of its base regressor: it tells the robot from one of the same name and another geometry.
    pub fingerprint: String,
}
