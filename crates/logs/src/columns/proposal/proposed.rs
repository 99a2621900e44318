//! A proposal: its lines, its names and its text.
//!
//! A line has a key of the options (for example `position`), a value (a column name, a pattern or a unit) and the reason. The
//! user can paste the printed text into the file of options.

use std::fmt;

use crate::columns::mapping::Columns;
use crate::columns::names::{ColumnNames, NamePattern};
use crate::columns::units::given_unit;
use crate::columns::words::Quantity;

/// One line of the proposal: a key, its value and the reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposed {
    /// The key in the options, for example `time` or `position`.
    pub key: &'static str,
    /// The proposed value of the key.
    pub value: String,
    /// The reason for the value.
    pub reason: String,
}

/// The proposed lines for the options file.
#[derive(Clone, Debug, Default)]
pub struct Proposal {
    /// Proposed names of columns.
    pub columns: Vec<Proposed>,
    /// Proposed units of columns without a unit in the header.
    pub units: Vec<Proposed>,
    /// The names and units of these lines.
    pub names: ColumnNames,
    /// Sentences on the quantities that could not be determined.
    pub missing: Vec<String>,
    /// The resulting mapping; `None` if a quantity is missing.
    pub mapping: Option<Columns>,
}

impl fmt::Display for Proposal {
    /// Writes lines that the user can paste into the options, each with its reason.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (title, lines) in [("columns", &self.columns), ("units", &self.units)] {
            if lines.is_empty() {
                continue;
            }
            writeln!(f, "{title}:")?;
            let width = lines.iter().map(|line| line.key.len() + line.value.len()).max().unwrap_or(0);
            for Proposed { key, value, reason } in lines {
                let gap = " ".repeat(width - key.len() - value.len());
                writeln!(f, "  {key}: {value}{gap}  # {reason}")?;
            }
        }
        Ok(())
    }
}

/// The factor to rad of the positions.
pub(super) fn factor_of(names: &ColumnNames) -> f64 {
    let unit = names.units.position.as_deref().unwrap_or("rad");
    given_unit(Quantity::Position, unit).map_or(1.0, |unit| unit.factor)
}

pub(super) fn key(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Time => "time",
        Quantity::Position => "position",
        Quantity::Velocity => "velocity",
        Quantity::Acceleration => "acceleration",
        Quantity::Torque => "torque",
        Quantity::Current => "current",
        Quantity::Goal => "goal",
    }
}

pub(super) fn names_of(names: &mut ColumnNames, quantity: Quantity) -> &mut Option<NamePattern> {
    match quantity {
        Quantity::Velocity => &mut names.velocity,
        Quantity::Acceleration => &mut names.acceleration,
        Quantity::Torque => &mut names.torque,
        Quantity::Current => &mut names.current,
        Quantity::Goal => &mut names.goal,
        _ => &mut names.position,
    }
}

pub(super) fn set_unit(names: &mut ColumnNames, quantity: Quantity, unit: String) {
    let place = match quantity {
        Quantity::Time => &mut names.units.time,
        Quantity::Position => &mut names.units.position,
        Quantity::Velocity => &mut names.units.velocity,
        Quantity::Acceleration => &mut names.units.acceleration,
        Quantity::Torque => &mut names.units.torque,
        Quantity::Current => &mut names.units.current,
        Quantity::Goal => &mut names.units.goal,
    };
    *place = Some(unit);
}

/// A number with four significant digits.
pub(super) fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    rounded.to_string()
}
