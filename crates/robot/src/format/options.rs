//! Options for reading a robot description.

use std::path::PathBuf;

use crate::angle_snap::AngleSnapping;

/// Options for reading a robot description. The caller chooses them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions<'a> {
    /// Whether mimic joints follow their leader or are independent coordinates.
    pub mimic: Mimic,
    /// Whether rounded angles are replaced by exact values.
    pub angles: AngleSnapping,
    /// Whether the robot has a floating base. With a floating base, a URDF with a single body is accepted.
    pub floating_base: bool,
    /// Values of symbols, m or rad. They replace the values in the file.
    pub values: &'a [(String, f64)],
    /// Values of the xacro arguments, used by `$(arg)`: name and value of each.
    pub arguments: &'a [(String, String)],
    /// Folders of the packages that a xacro may open, used by `$(find)`, and from which an MJCF may read: name and folder of
    /// each.
    pub packages: &'a [(String, PathBuf)],
    /// The robot, if the file has several: a body of the world of an MJCF, or a model of an SDF.
    pub root: Option<&'a str>,
}

/// How joints that mimic another joint are treated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mimic {
    /// A mimic joint is passive: its position is an affine function of the coordinate of its leader. It has no motor and no
    /// torque. The parameters of the bodies that it carries appear in the torque of the leader. Choose `Constraint` if torques
    /// are measured.
    #[default]
    Constraint,
    /// A mimic joint is an ordinary coordinate, as in libraries that ignore the tag (default of Pinocchio).
    Independent,
}
