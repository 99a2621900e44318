//! Proposes names and units for the columns of a log. The user can paste this proposal into the file of options.
//!
//! The proposal has a line for each signal (time, position, velocity, torque): the names of its columns and their unit, each
//! with a reason. For a hobby arm (a small arm with servos), the data of its servos complete the proposal.

use std::fmt;
use std::path::Path;

use logs::{Proposal, Proposed, Table, propose};
use robot::Robot;
use serde_json::{Value, json};

use crate::describe::model::coordinates as coordinates_of;
use crate::error::Error;
use crate::fit::hobby_arms::{DriveProposal, complete, proposed_arm};

/// Number of rows that are read. Some seconds of a log are enough to recognise a signal.
const READ_ROWS: usize = 20_000;

/// The signals that are proposed for the columns of a log.
pub struct ColumnProposal {
    /// The proposed lines of the options, and the signals for which no column was found.
    pub proposal: Proposal,
    /// Options that follow from the data of the arm, if an arm is named.
    pub arm: DriveProposal,
    /// A sentence on the arms that the robot may be; `None` if an arm is named.
    pub may_be: Option<String>,
    /// The headers of the columns of the log.
    pub header: Vec<String>,
}

/// Searches the first rows of a log for the signals of a robot's coordinates; no dynamics are derived. `rate`: rows per second,
/// Hz, of a log without a clock; `None`: from the velocities, if the log has them. `arm`: name of a hobby arm or of its servos,
/// with the form of its positions (`so101:degrees`); the data of this arm complete the proposal.
///
/// Fails if the log cannot be read, or if the arm is not known or does not fit the robot.
pub fn propose_columns(
    robot: &Robot,
    path: &Path,
    rate: Option<f64>,
    arm: Option<&str>,
) -> Result<ColumnProposal, Error> {
    let table = Table::glance(path, READ_ROWS)?;
    let coordinates: Vec<String> = robot.coordinates.iter().map(|coordinate| coordinate.name.clone()).collect();
    let mut proposal = propose(&table, &coordinates, rate);
    let may_be = if arm.is_none() { proposed_arm(robot) } else { None };
    let arm = arm.map(|arm| complete(robot, &table, arm, &mut proposal)).transpose()?.unwrap_or_default();
    // The units of sliding joints are shown as they will be read.
    if let Some(mapping) = proposal.mapping.take() {
        let slides: Vec<bool> = coordinates_of(robot).iter().map(|coordinate| coordinate.is_prismatic).collect();
        proposal.mapping = Some(mapping.clone().with_sliding(&slides).unwrap_or(mapping));
    }
    Ok(ColumnProposal { proposal, arm, may_be, header: table.header })
}

impl ColumnProposal {
    /// Whether the proposal is complete, so that the log can be read with this proposal.
    pub fn is_whole(&self) -> bool {
        self.proposal.mapping.is_some()
    }

    /// The proposal as JSON.
    pub fn to_json(&self) -> Value {
        let lines = |lines: &[Proposed]| -> Vec<Value> {
            lines
                .iter()
                .map(|l| json!({"key": l.key, "value": l.value.trim_matches('"'), "reason": l.reason}))
                .collect()
        };
        let Proposal { columns, units, missing, mapping, .. } = &self.proposal;
        json!({
            "columns": lines(columns),
            "units": lines(units),
            "transmission": lines(&self.arm.transmission),
            "gain": self.arm.gains.as_ref().map(|gains| &gains.value),
            "may_be": self.may_be,
            "missing": missing,
            "mapping": mapping.as_ref().map(ToString::to_string),
            "header": self.header,
        })
    }
}

impl fmt::Display for ColumnProposal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Proposal { columns, units, missing, mapping, .. } = &self.proposal;
        // Every line that is not an option begins with `#`, so that the user can paste the whole text into the file of options.
        f.write_str(match (columns.is_empty(), units.is_empty(), mapping) {
            (true, true, Some(_)) => {
                "# the columns are found by their names; a unit that no header names is taken for that of SI\n"
            }
            (_, _, Some(_)) => "# for the file of options; look through the reasons\n",
            _ => "# incomplete: write what is missing\n",
        })?;
        write!(f, "{}", self.proposal)?;
        if !self.arm.transmission.is_empty() {
            writeln!(f, "transmission:")?;
        }
        for Proposed { key, value, reason } in &self.arm.transmission {
            writeln!(f, "  {key}: {value}  # {reason}")?;
        }
        if let Some(Proposed { value, reason, .. }) = &self.arm.gains {
            writeln!(f, "# to be given with it: [gain={value}] ({reason})")?;
        }
        if let Some(may_be) = &self.may_be {
            writeln!(f, "# {may_be}")?;
        }
        for what in missing {
            writeln!(f, "# missing: {what}")?;
        }
        match mapping {
            Some(mapping) => mapping.to_string().lines().try_for_each(|line| writeln!(f, "# {line}")),
            None => writeln!(f, "# the columns are: {}", self.header.join(", ")),
        }
    }
}
