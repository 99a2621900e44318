//! The options with which the description of a robot was read. The file (URDF, xacro, MJCF, ..) and these options together give
//! the same model again.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// The options for reading the description of a robot. By default no option is set.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DescriptionOptions {
    /// The value of each symbol of the description, m or rad.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub values: BTreeMap<String, f64>,
    /// The value of each argument of a xacro file.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub arguments: BTreeMap<String, String>,
    /// The folder of each package from which a xacro file or an MJCF takes files.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub packages: BTreeMap<String, String>,
    /// The robot that was chosen from a file with several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub root: Option<String>,
    /// Whether the mimic joints of a URDF are independent coordinates.
    #[serde(skip_serializing_if = "is_false")]
    pub independent_mimic: bool,
    /// Whether rounded angles keep the value in the file. By default, 1.5707 counts as pi/2.
    #[serde(skip_serializing_if = "is_false")]
    pub angles_as_given: bool,
    /// The joints that have a rotor inertia parameter. `None`: the joints that the file states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotor_inertia: Option<RotorInertias>,
    /// Orientation of the base: roll, pitch and yaw of its frame, rad, in the frame in which the file defines gravity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<[f64; 3]>,
    /// Name of each locked joint, with its position, rad or m.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub locked: BTreeMap<String, f64>,
    /// Whether the base is a link with inertial parameters, moved by six coordinates.
    #[serde(skip_serializing_if = "is_false")]
    pub floating_base: bool,
}

/// The choice of the joints that have a rotor inertia parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RotorInertias {
    /// No joint has a rotor inertia.
    None,
    /// Only joints that a motor moves.
    Actuated,
    /// All joints that move.
    All,
}

fn is_false(x: &bool) -> bool {
    !x
}
