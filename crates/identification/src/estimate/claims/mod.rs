//! Claims on an estimate with their evidence, and the claims that each use of the estimate needs.
//!
//! | file | content |
//! |---|---|
//! | `claims_of_log` | findings and detection limits of the log check |
//! | `claims_of_columns` | agreement of velocities and accelerations with differences of positions and velocities |
//! | `claims_of_fit` | residual and undetermined parameters of the fit |
//! | `noise` | whether the residual is noise |
//! | `claims_of_prediction` | errors of prediction, and whether one set of parameters fits several logs |
//! | `claims_of_faults` | tested faults ([`hypotheses`]; properties of each kind: `hypothesis`) |
//! | `gaps` | widths of the gaps of joints with play |
//! | `sigma_inflation` | inflation of standard deviations by faults that are not named or not excluded |
//! | `unknowns` | simultaneous estimation of several unknown faults that the user requests |
//! | `purposes` | claims that each use needs, including errors of torques ([`crate::estimate::torque_error`]) |

mod claims_of_columns;
mod claims_of_faults;
mod claims_of_fit;
mod claims_of_log;
mod claims_of_prediction;
mod gaps;
pub mod hypotheses;
mod hypothesis_test;
mod noise;
pub mod purposes;
mod sigma_inflation;
pub mod unknowns;

pub(crate) use claims_of_faults::claims_of_faults;
pub(crate) use claims_of_fit::{LACKING_MODEL_CHI_SQUARE, NOISE_CHI_SQUARE, TorqueContext, claims_of_fit};
pub(crate) use claims_of_log::units_of_logs;
pub use claims_of_log::{claims_of_log, common_factor_shown};
pub use claims_of_prediction::Prediction;
pub(crate) use noise::not_noise;
pub use sigma_inflation::{effects_of_faults, inflate_by_faults, inflate_by_undetected_faults};
pub use unknowns::inflate_by_unknowns;
