//! Converts a log into states (q, dq, ddq, tau at the samples): transmission, filters, derivatives, and the rows that are used.

pub mod butterworth;
pub mod cutoff;
pub mod differences;
pub mod encoder_torque;
pub mod joint_signals;
pub(crate) mod position_spectrum;
pub mod preparation;
pub mod records;
pub mod resample;
pub mod reversals;
pub(crate) mod seldom;
pub mod signal_options;
pub mod standstill;
pub mod thinned;
pub mod transmission;
pub mod velocity_check;
