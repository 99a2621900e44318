//! The robot that an artefact was made for.

use serde::{Deserialize, Serialize};

/// Which robot an artefact is about.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ModelReference {
    /// Name of the robot.
    pub name: String,
    /// Of its base regressor: tells it from a robot of the same name and another geometry.
    pub fingerprint: String,
}
