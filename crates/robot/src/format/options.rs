//! Choices that a file leaves to its reader: the caller makes them.

use std::path::PathBuf;

use crate::angle_snap::Angles;

/// What a file leaves to its reader.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions<'a> {
    /// The mimic joints of a URDF.
    pub mimic: Mimic,
    /// The rounded angles of any file.
    pub angles: Angles,
    /// Whether the base will float: then a URDF of a single body is a robot.
    pub floating_base: bool,
    /// Values of symbols instead of those of the file, m or rad, as if they stood there.
    pub values: &'a [(String, f64)],
    /// Values of the arguments of a xacro, as `$(arg)` asks for them.
    pub arguments: &'a [(String, String)],
    /// Folders of the packages that a xacro may open, as `$(find)` asks for them.
    pub packages: &'a [(String, PathBuf)],
}

/// How the joints that mimic another are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mimic {
    /// They follow it: passive joints, affine in its coordinate. A mimic joint has no motor and no torque of its own.
    /// The parameters of what it carries appear in the torque of the joint it follows. Choose this when torques are
    /// measured.
    #[default]
    Constraint,
    /// They are coordinates like any other, as in libraries that read past the tag (Pinocchio's
    /// default).
    Independent,
}
