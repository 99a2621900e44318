//! Writes identified parameters into simulator files (URDF, MJCF) and generated source.
//!
//! Users of the library call `steps`. The other modules are parts of these steps.

pub mod body;
mod identified_values;
pub mod mjcf;
mod mjcf_actuators;
pub mod mjcf_into;
mod mjcf_names;
mod mjcf_pose;
mod repairs;
mod steps;
mod text_edit;
pub mod urdf;

pub use steps::{own_mjcf, write_mjcf, write_repaired, write_urdf};
pub use urdf::{WrittenBack, origins, write_origins};
