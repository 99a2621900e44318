//! Writes identified parameters into the files of simulators.
//!
//! Users of the library call `steps`; the other files work on bodies and text for it.

pub mod body;
mod identified_values;
pub mod mjcf;
pub mod mjcf_into;
mod mjcf_pose;
mod steps;
mod text_edit;
pub mod urdf;

pub use steps::{write_mjcf, write_repaired, write_urdf};
pub use urdf::WrittenBack;
