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
pub use write::{roll_pitch_yaw, write_urdf};
