//! File formats. Each reader converts a text to a [`crate::Robot`].
//!
//! If a description cannot be used, the reader returns one [`crate::Error`]: the file, the line, what was found and what was
//! expected. No text makes a reader panic, because sizes, depths and expressions are bounded here.

mod budget;
mod description;
mod expression;
mod follows;
mod jointed;
mod loop_frames;
mod mjcf;
mod names;
mod node;
mod options;
mod par;
mod read;
mod reframe;
mod shown;
mod typed;
mod urdf;
pub mod written;
mod xacro;
mod xml;
mod yaml;

pub use crate::angle_snap::AngleSnapping;
pub use budget::REPEATS_TOO_MUCH;
pub use description::{
    DescriptionBody, DescriptionJoint, DescriptionReader, ReadDescription, RobotDescription,
    register as register_readers,
};
pub use options::{Mimic, ReadOptions};
pub use par::read_par;
pub use read::{READ_EXTENSIONS, parse_with, read, read_text, read_with, text_of, without_macros};
pub use typed::read_as;
pub use urdf::{read_urdf, read_urdf_with, roll_pitch_yaw, write_urdf};
pub use yaml::{GeometryErrors, read_yaml, write_geometry_into_yaml, write_repairs_into_yaml, write_yaml};
