//! Writes identified parameters into the files of simulators.
//!
//! Users call `steps`; the other files only handle bodies and text.

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
