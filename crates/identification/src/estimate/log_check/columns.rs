//! Checks the numbers of a log without mechanics: integers that were read without their sign, and rows from two sources.
//!
//! If a column is unreadable in this sense, all other checks are skipped, because they would report wrong faults: a torque
//! without its sign, for example, looks like negative friction.

use logs::{RawWord, Suspect};

use crate::estimate::log_check::diagnosis::DiagnosisInput;
use crate::estimate::log_check::finding::{Fault, Finding};

impl DiagnosisInput<'_> {
    /// Findings that the numbers are no measurements of the robot (sign lost, rows of two sources); empty if there are no such
    /// findings.
    pub(super) fn unreadable(&self) -> Vec<Finding> {
        let of = |word: fn(&Suspect) -> Option<RawWord>, what: &str| {
            let raw: Vec<(&Suspect, RawWord)> = self.suspects.iter().filter_map(|s| Some((s, word(s)?))).collect();
            let (_, first) = raw.first()?;
            let evidence = format!(
                "the {what} is never negative, and jumps by nearly the whole word where it changes its sign; as a signed \
                 number it does not jump"
            );
            let remedy = format!("{first}; do the same with the {what} of the other joints of this kind");
            Some(Finding::of(Fault::RawWords, names(raw.iter().map(|(s, _)| *s)), evidence, remedy))
        };
        let mut found: Vec<Finding> = self.two_sources().into_iter().collect();
        found.extend(of(|s| s.raw_effort, "torque"));
        found.extend(of(|s| s.raw_velocity, "velocity"));
        found
    }

    fn two_sources(&self) -> Option<Finding> {
        let mixed: Vec<&Suspect> = self.suspects.iter().filter(|s| s.foreign_rows > 0).collect();
        // All joints have the same rows. So the largest count of a joint is the number of foreign rows (rows of another source).
        let rows = mixed.iter().map(|s| s.foreign_rows).max()?;
        let are_zero = mixed.iter().all(|s| s.foreign_are_zero);
        let [which, those] = match are_zero {
            true => [", and there it is zero", "those whose torques are all zero"],
            false => ["", "those of the other source"],
        };
        let evidence = format!(
            "in {rows} rows the torque jumps away and comes back in the next row, in most joints at once{which}; two \
             publishers on one topic look so"
        );
        let remedy = format!(
            "log one of them (in ROS `ros2 topic info -v TOPIC` names them), or leave out the rows of the other: {those}"
        );
        Some(Finding::of_all(Fault::TwoSources(rows), evidence, remedy))
    }
}

/// The names of the coordinates that have suspect columns, each name once. Several logs have the same coordinates.
fn names<'a>(suspects: impl Iterator<Item = &'a Suspect>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for suspect in suspects {
        if !names.contains(&suspect.coordinate) {
            names.push(suspect.coordinate.clone());
        }
    }
    names
}
