//! Names of columns that a user gives.

use gate::suggestion::did_you_mean;
use serde::{Deserialize, Serialize};

use crate::cleaning::undriven::Undriven;
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
    /// Headers of the positions that servos are told: their errors stand for torques.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal: Option<Names>,
    /// Coordinates that something else moves: their positions count, and no torque of theirs is expected.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub prescribed: Vec<String>,
    /// Coordinates that nothing drives: their torque is zero, and no column of it is expected.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub free: Vec<String>,
    /// Units, where the headers do not name them or name others.
    #[serde(skip_serializing_if = "UnitNames::is_empty")]
    pub units: UnitNames,
}

impl ColumnNames {
    /// Why there is no torque of each of some coordinates; `None`: there is one.
    ///
    /// Fails on a name that is none of them, or stands there twice.
    pub(crate) fn undriven(&self, coordinates: &[String]) -> Result<Vec<Option<Undriven>>, String> {
        let mut found = vec![None; coordinates.len()];
        for (key, names, why) in
            [("prescribed", &self.prescribed, Undriven::Prescribed), ("free", &self.free, Undriven::Free)]
        {
            for name in names {
                let place = coordinates.iter().position(|c| c == name).ok_or_else(|| {
                    let meant = did_you_mean(name, coordinates.iter().map(String::as_str));
                    let known = coordinates.join(", ");
                    format!("[options.columns.{key}]: `{name}` is no coordinate{meant}; they are {known}")
                })?;
                if found[place].replace(why).is_some() {
                    return Err(format!(
                        "[options.columns.{key}]: `{name}` stands there twice, or is free and prescribed"
                    ));
                }
            }
        }
        if !found.is_empty() && found.iter().all(|why| *why == Some(Undriven::Prescribed)) {
            return Err("[options.columns.prescribed]: where no coordinate has a torque, nothing is told".into());
        }
        Ok(found)
    }
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
