//! Makes an estimate from logs: the solution with its standard deviations, errors of cross-validation and remarks. Also checks
//! logs before a fit (`log_check`) and states the evidence for an estimate as claims (`claims`, `verdict`).

pub mod absent_friction;
pub mod artefact;
pub mod autocorrelation;
pub mod claims;
pub mod consistent;
pub mod cross_talk;
pub mod delay;
pub mod digits;
pub mod directions;
pub mod drive_gains;
pub mod essential;
pub mod held_out;
pub mod hypothesis;
pub mod identified;
pub mod identify;
pub mod impossible;
pub mod joint_terms;
pub mod log_check;
pub mod logs_left_out;
pub mod nominal_prediction;
pub mod options;
pub mod other_logs;
mod play;
pub mod remarks;
pub mod residuals;
pub mod rotors;
pub mod selection;
pub mod standing_out;
pub mod standing_torque;
pub mod topics;
pub mod torque_error;
pub mod undone;
pub mod validation;
pub mod verdict;
