//! From logs to parameters: what a log is looked at for, what is chosen, the fit, and whether to trust it.

pub(crate) mod candidates;
pub mod column_proposal;
pub mod doctor;
pub(crate) mod drive_gains;
pub(crate) mod effects;
pub mod experiments;
pub mod gravity_direction;
pub mod judged;
pub mod load;
pub(crate) mod looked;
pub(crate) mod motion_range;
pub mod mount;
mod normalised;
pub mod samples;
pub(crate) mod search;
pub(crate) mod signal_sources;
pub mod unspoken;
pub mod unsure_torques;
pub mod validation;
pub mod verdict;
