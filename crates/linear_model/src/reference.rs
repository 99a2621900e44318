//! The entry of an artefact (file of rist) that identifies the robot for which the artefact was made: name and fingerprint. The
//! fingerprint is a hash of the base regressor.

use serde::{Deserialize, Serialize};

/// Identifies the robot for which an artefact was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ModelReference {
    /// Name of the robot in its description file.
    pub name: String,
    /// Fingerprint of the base regressor. A robot of the same name with another geometry has another fingerprint.
    pub fingerprint: String,
}
