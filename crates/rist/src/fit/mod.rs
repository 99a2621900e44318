//! Identifies parameters from logs: log check, choice of a variant, fit, and verdict.
//!
//! The log check compares logs with the description before a fit. A variant is a model with options for its fit; several
//! variants are tried. The verdict states whether to trust the estimate.

pub mod arm_options;
pub(crate) mod candidates;
pub mod column_proposal;
pub(crate) mod contact;
pub mod doctor;
pub(crate) mod drive_gains;
pub(crate) mod effects;
pub mod experiments;
pub mod gravity_direction;
pub(crate) mod hobby_arms;
pub mod load;
pub(crate) mod loaded_logs;
pub(crate) mod motion_range;
pub mod mount;
mod normalised;
pub mod samples;
pub(crate) mod search;
pub(crate) mod signal_sources;
pub mod undetermined;
pub mod unsure_torques;
pub mod validation;
pub mod verdict;
pub mod verdict_of_logs;
