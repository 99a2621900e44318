//! How a description was read: what stands beside its file for the same model to come out of it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// What was asked for beside the file; the default is nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DescriptionOptions {
    /// Values of symbols, m or rad.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub values: BTreeMap<String, f64>,
    /// The mimic joints of a URDF are coordinates of their own.
    #[serde(skip_serializing_if = "is_false")]
    pub independent_mimic: bool,
    /// Angles near a right angle stay as the file gives them.
    #[serde(skip_serializing_if = "is_false")]
    pub angles_as_given: bool,
    /// Which joints have a rotor inertia among their parameters; `None`: as the file says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotor_inertia: Option<RotorInertias>,
    /// Six coordinates in front, and the base a link with parameters of its own.
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
