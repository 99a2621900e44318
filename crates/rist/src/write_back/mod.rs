//! Writes what was identified into the files that simulators read.
//!
//! `steps` are what a user calls; the other files know bodies and text alone.

pub mod body;
mod identified_values;
pub mod mjcf;
pub mod mjcf_into;
mod mjcf_pose;
mod steps;
mod text_edit;
pub mod urdf;

pub use steps::{write_mjcf, write_urdf};
pub use urdf::WrittenBack;
