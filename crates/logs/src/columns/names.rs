//! Names of columns from the user.

use gate::suggestion::did_you_mean;
use serde::{Deserialize, Serialize};

use crate::cleaning::undriven::NoTorqueReason;
use crate::columns::units::UnitNames;

/// Names from the user, for the quantities whose columns cannot be found by their headers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ColumnNames {
    /// Header of the time.
    pub time: Option<String>,
    /// Rows per second, Hz, of a log without a clock: row r is at r / rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// Header of the column with the episode number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub episode: Option<String>,
    /// Headers of the positions.
    pub position: Option<NamePattern>,
    /// Headers of the velocities.
    pub velocity: Option<NamePattern>,
    /// Headers of the accelerations.
    pub acceleration: Option<NamePattern>,
    /// Headers of the torques.
    pub torque: Option<NamePattern>,
    /// Headers of the currents.
    pub current: Option<NamePattern>,
    /// Headers of the commanded positions of servos: their errors replace torques.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal: Option<NamePattern>,
    /// Coordinates that are moved from outside: their positions count, and no torque is expected.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub prescribed: Vec<String>,
    /// Coordinates without a drive: their torque is zero, and no column of it is expected.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub free: Vec<String>,
    /// Units, where the headers name none or wrong ones.
    #[serde(skip_serializing_if = "UnitNames::is_empty")]
    pub units: UnitNames,
}

impl ColumnNames {
    /// The reason why a coordinate has no torque, one per coordinate; `None`: it has one.
    ///
    /// Fails on a name that is no coordinate, or occurs twice.
    pub(crate) fn undriven(&self, coordinates: &[String]) -> Result<Vec<Option<NoTorqueReason>>, String> {
        let mut found = vec![None; coordinates.len()];
        for (key, names, why) in
            [("prescribed", &self.prescribed, NoTorqueReason::Prescribed), ("free", &self.free, NoTorqueReason::Free)]
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
        if !found.is_empty() && found.iter().all(|why| *why == Some(NoTorqueReason::Prescribed)) {
            return Err(
                "[options.columns.prescribed]: where no coordinate has a torque, nothing is identifiable".into()
            );
        }
        Ok(found)
    }
}

/// `taum_abs{}`, with braces for 1, 2, .., for 0, 1, .., or for the names of the joints, whichever the file has; `{joint}` stands
/// for the names alone. Or one name per joint. A unit at the end of the name (`_deg`, `_mA`, also before the number) is
/// recognised.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum NamePattern {
    /// `q_{}`: braces stand for the number of the coordinate, or its name.
    Pattern(String),
    /// One name per coordinate.
    Each(Vec<String>),
}
