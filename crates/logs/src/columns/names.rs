//! Names of columns that a user gives.

use serde::{Deserialize, Serialize};

/// Names given by the user, for the quantities whose columns cannot be found by their names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ColumnNames {
    /// Header of the time.
    pub time: Option<String>,
    /// Headers of the positions.
    pub position: Option<Names>,
    /// Headers of the velocities.
    pub velocity: Option<Names>,
    /// Headers of the accelerations.
    pub acceleration: Option<Names>,
    /// Headers of the torques.
    pub torque: Option<Names>,
    /// Headers of the currents.
    pub current: Option<Names>,
}

/// `taum_abs{}`, the braces standing for 1, 2, ..; or one name per joint. A unit at the end of the
/// name (`_deg`, `_mA`, also before the number) counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Names {
    /// `q_{}`: braces stand for the number of the coordinate.
    Pattern(String),
    /// One per coordinate.
    Each(Vec<String>),
}
