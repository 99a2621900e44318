//! How a description was read: what must stand beside its file to give the same model again.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// What was asked for beside the file; the default is nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DescriptionOptions {
    /// Values of symbols, m or rad.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub values: BTreeMap<String, f64>,
    /// Values of the arguments of a xacro.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub arguments: BTreeMap<String, String>,
    /// Folders of the packages that a xacro includes from.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub packages: BTreeMap<String, String>,
    /// Whether the mimic joints of a URDF are coordinates of their own.
    #[serde(skip_serializing_if = "is_false")]
    pub independent_mimic: bool,
    /// Whether angles near a right angle stay as the file gives them.
    #[serde(skip_serializing_if = "is_false")]
    pub angles_as_given: bool,
    /// Which joints have a rotor inertia among their parameters; `None`: as the file says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotor_inertia: Option<RotorInertias>,
    /// How the base is mounted, rad: roll, pitch and yaw of its frame in a frame in which gravity is as the file says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<[f64; 3]>,
    /// Joints that stand still, at these positions, rad or m.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub locked: BTreeMap<String, f64>,
    /// Whether the base is a link with parameters of its own, behind six coordinates.
    #[serde(skip_serializing_if = "is_false")]
    pub floating_base: bool,
}

/// Joints with a rotor inertia of their own.
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
