//! Reads and writes URDF files.

mod collision;
mod mimic;
mod oddities;
mod read;
mod repair;
mod text;
mod tree;
mod write;

pub use read::{read_urdf, read_urdf_with};
pub(in crate::format) use repair::repaired;
pub(in crate::format) use text::IS_A_MACRO;
pub use write::{roll_pitch_yaw, write_urdf};
