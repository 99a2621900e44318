//! Writes what was identified into the files that simulators read.

pub mod body;
pub mod mjcf;
pub mod mjcf_into;
mod text_edit;
pub mod urdf;
