//! What may be said of an estimate: claims with their evidence, and what they mean for each use of it.
//!
//! | file | says |
//! |---|---|
//! | `claims_of_log` | what the passport found, and what it would have found |
//! | `claims_of_columns` | whether velocities and accelerations are the slopes they should be |
//! | `claims_of_fit` | what the fit leaves open |
//! | `noise` | whether what is left looks like noise |
//! | `claims_of_prediction` | what it predicts, and whether several logs have one set of parameters |
//! | `claims_of_faults` | what unknowns more explain ([`hypotheses`]; all that is known of a kind: `hypothesis`) |
//! | `widening` | by how much those that are not named, or not excluded, widen deviations |
//! | `unknowns` | the same unknowns all at once, where they are asked for |
//! | `purposes` | what each use needs of all these, and of the torques that may be wrong ([`crate::estimate::torque_error`]) |

mod claims_of_columns;
mod claims_of_faults;
mod claims_of_fit;
mod claims_of_log;
mod claims_of_prediction;
pub mod hypotheses;
mod noise;
pub mod purposes;
pub mod unknowns;
mod widening;

pub(crate) use claims_of_faults::claims_of_faults;
pub(crate) use claims_of_fit::{Beside, LACKING_MODEL_CHI_SQUARE, NOISE_CHI_SQUARE, claims_of_fit};
pub(crate) use claims_of_log::units_of_logs;
pub use claims_of_log::{claims_of_log, common_factor_shown};
pub use claims_of_prediction::Prediction;
pub(crate) use noise::not_noise;
pub use unknowns::widen_by_unknowns;
pub use widening::{effects_of_faults, widen_by_faults, widen_by_what_may_be_there};
