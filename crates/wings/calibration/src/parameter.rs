//! The parameters of a kinematic calibration, and their names.
//!
//! Two groups: unknowns of the measurement (pose of the base, tool, measured points), and errors of the robot (zeros of joints,
//! geometry, scales, compliances). A letter names a geometric parameter of a link. An axis is a number from 0 to 5: x, y, z,
//! then the angles about x, y, z.

use std::fmt;

/// A geometric parameter of a link, named by its letter: the six parameters of Khalil and Kleinfinger, and beta of Hayati.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Letter {
    /// Angle about the z axis of the antecedent, rad.
    Gamma,
    /// Distance along the z axis of the antecedent, m.
    B,
    /// Angle about the y axis before alpha, rad. Its nominal value is zero [Hayati, Mirmirani 1985].
    Beta,
    /// Angle about the x axis, rad.
    Alpha,
    /// Distance along the x axis, m.
    D,
    /// Angle about the z axis of the link, rad.
    Theta,
    /// Distance along the z axis of the link, m.
    R,
}

impl Letter {
    /// The word in names of parameters.
    pub fn word(self) -> &'static str {
        match self {
            Letter::Gamma => "gamma",
            Letter::B => "b",
            Letter::Beta => "beta",
            Letter::Alpha => "alpha",
            Letter::D => "d",
            Letter::Theta => "theta",
            Letter::R => "r",
        }
    }

    /// Whether the letter is an angle.
    pub fn is_angle(self) -> bool {
        matches!(self, Letter::Gamma | Letter::Beta | Letter::Alpha | Letter::Theta)
    }
}

/// A parameter of a calibration: an error of the description, or an unknown of the measurement. `link`: index of a link of the
/// robot; `coordinate`: index of a coordinate of the robot; `axis`: 0 to 2 are lengths along x, y, z, m, and 3 to 5 are angles
/// about x, y, z, rad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// The base of the robot in the frame of the measurements.
    Base {
        /// The axis.
        axis: usize,
    },
    /// The fixed point in the base frame from which distances are measured, m.
    Anchor {
        /// The axis.
        axis: usize,
    },
    /// The radius of a sphere that was touched, m.
    Radius,
    /// A measured point (marker) in the frame of the last link, m.
    Point {
        /// Index of the point.
        point: usize,
        /// The axis.
        axis: usize,
    },
    /// The orientation of the tool in the frame of the last link, rad.
    Tool {
        /// The axis.
        axis: usize,
    },
    /// The zero error of a coordinate: q of the robot is q of the table plus this, rad (m).
    Zero {
        /// Index of the coordinate.
        coordinate: usize,
    },
    /// An error of a letter of the geometry of a link, rad or m.
    Dh {
        /// Index of the link.
        link: usize,
        /// The letter.
        letter: Letter,
    },
    /// An error of the frame of a joint in its description (URDF), rad or m.
    Frame {
        /// Index of the link.
        link: usize,
        /// The axis.
        axis: usize,
    },
    /// The relative error of the scale of a coordinate (gear ratio).
    Gear {
        /// Index of the coordinate.
        coordinate: usize,
    },
    /// The compliance of a coordinate: q of the robot is reduced by this times the holding torque, rad/(N m).
    Compliance {
        /// Index of the coordinate.
        coordinate: usize,
    },
}

/// The kinds of parameters, by which they are selected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterGroup {
    /// Unknowns of the measurement: base, tool, markers, anchor, radius.
    Frames,
    /// Zero errors.
    Zeros,
    /// Errors of the geometry.
    Geometry,
    /// Errors of scales.
    Gears,
    /// Compliances.
    Compliances,
}

impl Parameter {
    /// The kind of the parameter.
    pub fn group(self) -> ParameterGroup {
        match self {
            Parameter::Base { .. }
            | Parameter::Anchor { .. }
            | Parameter::Radius
            | Parameter::Point { .. }
            | Parameter::Tool { .. } => ParameterGroup::Frames,
            Parameter::Zero { .. } => ParameterGroup::Zeros,
            Parameter::Dh { .. } | Parameter::Frame { .. } => ParameterGroup::Geometry,
            Parameter::Gear { .. } => ParameterGroup::Gears,
            Parameter::Compliance { .. } => ParameterGroup::Compliances,
        }
    }
}

/// The names that are needed to print parameters.
#[derive(Clone, Debug, Default)]
pub struct ParameterNames {
    /// Names of the coordinates of the robot.
    pub coordinates: Vec<String>,
    /// Whether each coordinate is a length.
    pub slides: Vec<bool>,
    /// Labels of the links of the robot: the `4` of `alpha4`.
    pub labels: Vec<String>,
    /// Names of the joints of the links.
    pub joints: Vec<String>,
    /// Whether there are several measured points.
    pub has_markers: bool,
}

/// Words of the six axes of a frame.
pub(crate) const AXES: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];

impl ParameterNames {
    /// A parameter with what is needed to print it.
    pub fn of(&self, parameter: Parameter) -> NamedParameter<'_> {
        NamedParameter { names: self, parameter }
    }

    /// The name of the unit of a parameter.
    pub fn unit(&self, parameter: Parameter) -> &'static str {
        let of = |is_angle: bool| if is_angle { "rad" } else { "m" };
        match parameter {
            Parameter::Base { axis } | Parameter::Frame { axis, .. } => of(axis >= 3),
            Parameter::Anchor { .. } | Parameter::Radius | Parameter::Point { .. } => "m",
            Parameter::Tool { .. } => "rad",
            Parameter::Zero { coordinate } => of(!self.slides[coordinate]),
            Parameter::Dh { letter, .. } => of(letter.is_angle()),
            Parameter::Gear { .. } => "1",
            Parameter::Compliance { coordinate } if self.slides[coordinate] => "m/N",
            Parameter::Compliance { .. } => "rad/(N m)",
        }
    }
}

/// A parameter that prints its name: `alpha4`, `zero elbow`, `tool x`.
pub struct NamedParameter<'a> {
    names: &'a ParameterNames,
    parameter: Parameter,
}

impl fmt::Display for NamedParameter<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ParameterNames { coordinates, labels, joints, has_markers, .. } = self.names;
        match self.parameter {
            Parameter::Base { axis } => write!(f, "base {}", AXES[axis]),
            Parameter::Anchor { axis } => write!(f, "anchor {}", AXES[axis]),
            Parameter::Radius => f.write_str("radius"),
            Parameter::Point { point, axis } if *has_markers => write!(f, "marker {} {}", point + 1, AXES[axis]),
            Parameter::Point { axis, .. } => write!(f, "tool {}", AXES[axis]),
            Parameter::Tool { axis } => write!(f, "tool {}", AXES[axis + 3]),
            Parameter::Zero { coordinate } => write!(f, "zero {}", coordinates[coordinate]),
            Parameter::Dh { link, letter } => write!(f, "{}{}", letter.word(), labels[link]),
            Parameter::Frame { link, axis } => write!(f, "{} {}", joints[link], AXES[axis]),
            Parameter::Gear { coordinate } => write!(f, "gear {}", coordinates[coordinate]),
            Parameter::Compliance { coordinate } => write!(f, "compliance {}", coordinates[coordinate]),
        }
    }
}
