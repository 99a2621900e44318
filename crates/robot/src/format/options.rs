//! Options for reading a file, which the caller chooses.

use std::path::PathBuf;

use crate::angle_snap::AngleSnapping;

/// Options for reading a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions<'a> {
    /// The treatment of mimic joints.
    pub mimic: Mimic,
    /// The treatment of rounded angles.
    pub angles: AngleSnapping,
    /// Whether the base floats: then a URDF with a single body is a robot.
    pub floating_base: bool,
    /// Values of symbols, m or rad, that replace the values of the file.
    pub values: &'a [(String, f64)],
    /// Values of the arguments of a xacro, for `$(arg)`.
    pub arguments: &'a [(String, String)],
    /// Folders of the packages that a xacro may open, for `$(find)`.
    pub packages: &'a [(String, PathBuf)],
}

/// The treatment of joints that mimic another joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mimic {
    /// They follow it: passive joints, affine in its coordinate. A mimic joint has no motor and no torque of its own.
    /// The parameters of the bodies it carries appear in the torque of the joint it follows. Choose this when torques are
    /// measured.
    #[default]
    Constraint,
    /// They are ordinary coordinates, as in libraries that ignore the tag (Pinocchio's
    /// default).
    Independent,
}
