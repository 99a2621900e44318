//! Names of columns that a user gives.

use serde::{Deserialize, Serialize};

use crate::columns::units::UnitNames;

/// Names given by the user, for the quantities whose columns cannot be found by their names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ColumnNames {
    /// Header of the time.
    pub time: Option<String>,
    /// Header of the column that numbers the episodes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub episode: Option<String>,
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
    /// Units, where the headers do not name them or name others.
    #[serde(skip_serializing_if = "UnitNames::is_empty")]
    pub units: UnitNames,
}

/// `taum_abs{}`, the braces standing for 1, 2, .., for 0, 1, .., or for the names of the joints, whichever the file has;
/// `{joint}` stands for the names alone. Or one name per joint. A unit at the end of the name (`_deg`, `_mA`, also before
/// the number) counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Names {
    /// `q_{}`: braces stand for the number of the coordinate, or its name.
    Pattern(String),
    /// One per coordinate.
    Each(Vec<String>),
}
