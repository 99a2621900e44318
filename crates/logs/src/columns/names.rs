//! Names of columns that the user gives.
//!
//! They come from the file of options, for quantities whose columns cannot be found by their headers. Efforts are torques,
//! currents, or goals (commanded positions) of servos.

use gate::suggestion::did_you_mean;
use serde::{Deserialize, Serialize};

use crate::cleaning::undriven::NoTorqueReason;
use crate::columns::units::{UnitNames, given_unit};
use crate::columns::words::{Quantity, unit_at_end, written};

/// Column names that the user gives, for quantities whose columns cannot be found by their headers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ColumnNames {
    /// Header of the clock column.
    pub time: Option<String>,
    /// Rows per second (Hz) of a log without a clock: row r is at the time r / rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// Header of the column with the episode number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub episode: Option<String>,
    /// Headers of the position columns.
    pub position: Option<NamePattern>,
    /// Headers of the velocity columns.
    pub velocity: Option<NamePattern>,
    /// Headers of the acceleration columns.
    pub acceleration: Option<NamePattern>,
    /// Headers of the torque columns.
    pub torque: Option<NamePattern>,
    /// Headers of the current columns.
    pub current: Option<NamePattern>,
    /// Headers of the columns with goals (commanded positions) of servos. Position errors are then used as efforts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal: Option<NamePattern>,
    /// Coordinates that are moved from outside: their positions are used, and they need no torque column.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub prescribed: Vec<String>,
    /// Coordinates without a drive: their torque is zero, and they need no torque column.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub free: Vec<String>,
    /// Units of quantities, if the headers have no unit or a wrong one.
    #[serde(skip_serializing_if = "UnitNames::is_empty")]
    pub units: UnitNames,
}

impl ColumnNames {
    /// The unit of the numbers of a quantity, and its factor to the SI unit: the unit that the user gives, or the unit at the end
    /// of the header that the user gives, or the SI unit.
    ///
    /// Fails if the text is no unit of the quantity.
    pub fn unit(&self, quantity: Quantity) -> Result<(String, f64), String> {
        if let Some(text) = self.units.of(quantity) {
            return given_unit(quantity, text).map(|unit| (written(&unit.name).to_string(), unit.factor));
        }
        let pattern = match quantity {
            Quantity::Position => &self.position,
            Quantity::Velocity => &self.velocity,
            Quantity::Torque => &self.torque,
            Quantity::Current => &self.current,
            Quantity::Goal => &self.goal,
            _ => &None,
        };
        let header = match pattern {
            Some(NamePattern::Pattern(header)) => header.as_str(),
            Some(NamePattern::Each(headers)) => headers.first().map_or("", String::as_str),
            None => "",
        };
        let (unit, factor) = unit_at_end(header, quantity);
        Ok((written(unit).to_string(), factor))
    }

    /// For each coordinate, the reason why it has no torque; `None` if it has a torque.
    ///
    /// Fails if a name is not a coordinate, or occurs twice.
    pub fn undriven(&self, coordinates: &[String]) -> Result<Vec<Option<NoTorqueReason>>, String> {
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

/// Headers of the joints: a pattern such as `taum_abs{}`, or one header per joint. `{}` stands for 1, 2, .., for 0, 1, .., or for
/// the joint names, depending on the file. `{joint}` stands only for joint names. A unit at the end of a header (`_deg`, `_mA`,
/// also before the number) is recognised.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum NamePattern {
    /// A pattern such as `q_{}`: the braces stand for the number or the name of the coordinate.
    Pattern(String),
    /// One header per coordinate.
    Each(Vec<String>),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_options_and_of_headers() {
        let units = UnitNames { velocity: Some("counts(2 deg/s)".into()), ..UnitNames::default() };
        let pattern = |header: &str| Some(NamePattern::Pattern(header.into()));
        let (position, current) = (pattern("q{}_deg"), pattern("i_mA_{}"));
        let names = ColumnNames { position, current, units, ..ColumnNames::default() };
        let unit = |quantity| names.unit(quantity).unwrap();
        assert_eq!(unit(Quantity::Position), ("deg".to_string(), 1f64.to_radians()));
        assert_eq!(unit(Quantity::Velocity), ("counts(2 deg/s)".to_string(), 2f64.to_radians()));
        assert_eq!(unit(Quantity::Current), ("mA".to_string(), 1e-3));
        assert_eq!(unit(Quantity::Torque), ("N m".to_string(), 1.0));
        let units = UnitNames { torque: Some("apples".into()), ..UnitNames::default() };
        assert!(ColumnNames { units, ..ColumnNames::default() }.unit(Quantity::Torque).is_err());
    }
}
