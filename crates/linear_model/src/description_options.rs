//! The options with which a description was read: with its file they reproduce the model.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// The options for reading a description; by default none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DescriptionOptions {
    /// Values of symbols, m or rad.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub values: BTreeMap<String, f64>,
    /// Values of the arguments of a xacro.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub arguments: BTreeMap<String, String>,
    /// Folders of the packages from which a xacro includes files.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub packages: BTreeMap<String, String>,
    /// Whether the mimic joints of a URDF are independent coordinates.
    #[serde(skip_serializing_if = "is_false")]
    pub independent_mimic: bool,
    /// Whether angles near a right angle stay as the file gives them.
    #[serde(skip_serializing_if = "is_false")]
    pub angles_as_given: bool,
    /// Which joints have a rotor inertia among their parameters; `None`: as in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotor_inertia: Option<RotorInertias>,
    /// Orientation of the base, rad: roll, pitch and yaw of its frame in the frame in which the file defines gravity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<[f64; 3]>,
    /// Locked joints with their positions, rad or m.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub locked: BTreeMap<String, f64>,
    /// Whether the base is a link with inertial parameters, moved by six coordinates.
    #[serde(skip_serializing_if = "is_false")]
    pub floating_base: bool,
}

/// Joints with a rotor inertia.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RotorInertias {
    /// No joint.
    None,
    /// Joints that a motor moves.
    Actuated,
    /// All joints that move.
    All,
}

fn is_false(x: &bool) -> bool {
    !x
}
