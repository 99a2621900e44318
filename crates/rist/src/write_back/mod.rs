//! Writes what was identified into the files that simulators read.
//!
//! [`steps`] are what a user calls; the other files know bodies and text alone.

pub mod body;
pub mod mjcf;
pub mod mjcf_into;
pub mod steps;
mod text_edit;
pub mod urdf;
