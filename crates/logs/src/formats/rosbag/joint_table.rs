//! Converts the joint states of one topic to a table.
//!
//! Each message is a row: `time`, then `position_<joint>`, `velocity_<joint>` and `effort_<joint>` of every joint. Messages may
//! have different joints or another order of joints. A value that a message does not contain is NaN. Time is counted from the
//! first message (s), because nanoseconds since 1970 have more digits than an f64.
//!
//! A joint that occurs in few messages would give a nearly empty column, so it is omitted with a note. So the table has at most
//! [`SPARSE_JOINT_RATIO`] times as many cells as the messages have values.

use std::collections::{BTreeMap, BTreeSet};

use gate::shown;

use crate::formats::rosbag::joint_state::JointState;
use crate::table::{MAX_CELLS, Table};

/// The quantities of a JointState, in the order of its fields.
const JOINT_STATE_QUANTITIES: [&str; 3] = ["position", "velocity", "effort"];

/// Largest number of joints of one robot.
const MAX_JOINTS: usize = 500;

/// A joint is omitted if its share of the messages is below one over this number.
pub(super) const SPARSE_JOINT_RATIO: usize = 64;

/// Memory of one number, bytes: the number and the index of its row, in arrays that grow by doubling.
pub(super) const CELL_BYTES: usize = 2 * (size_of::<f64>() + size_of::<u32>());

/// The messages of one topic, and the table that is made of them.
#[derive(Default)]
pub(crate) struct JointTable {
    /// Times of the messages, ns: `stamps` from their headers, `log_times` from the recorder.
    stamps: Vec<i64>,
    log_times: Vec<i64>,
    /// Names of the joints, in the order in which they first occur.
    joints: Vec<String>,
    places: BTreeMap<String, usize>,
    /// For each joint, the series of position, velocity and effort.
    series: Vec<[NumbersByRow; 3]>,
    uneven: usize,
    /// Number of values in all messages.
    cells: usize,
}

/// The numbers of a series, and the index of the row of each number.
#[derive(Default)]
pub(super) struct NumbersByRow {
    rows: Vec<u32>,
    values: Vec<f64>,
}

impl JointTable {
    pub(crate) fn messages(&self) -> usize {
        self.stamps.len()
    }

    /// Names of the joints, in the order in which they first occur.
    pub(crate) fn joints(&self) -> &[String] {
        &self.joints
    }

    /// Number of values of a message: two times and all elements of its arrays.
    pub(crate) fn cells_of(state: &JointState) -> usize {
        2 + [&state.position, &state.velocity, &state.effort].iter().map(|a| a.len()).sum::<usize>()
    }

    /// Adds a message. `log_time`: time at which the recorder received it, ns.
    ///
    /// Fails if the message names a joint twice, or if there are too many joints or numbers.
    pub(crate) fn push(&mut self, log_time: i64, state: &JointState) -> Result<(), String> {
        let row = self.stamps.len();
        let arrays = [&state.position, &state.velocity, &state.effort];
        self.cells += JointTable::cells_of(state);
        if self.cells > MAX_CELLS {
            return Err(format!("with it there are more than {MAX_CELLS} numbers; cut the recording into parts"));
        }
        self.stamps.push(state.stamp);
        self.log_times.push(log_time);
        self.uneven += usize::from(arrays.iter().any(|a| !a.is_empty() && a.len() != state.names.len()));
        let mut seen = BTreeSet::new();
        for (k, name) in state.names.iter().enumerate() {
            if !seen.insert(*name) {
                return Err(format!("it names joint `{name}` twice"));
            }
            let joint = match self.places.get(*name) {
                Some(joint) => *joint,
                None => self.new_joint(name)?,
            };
            for (series, array) in self.series[joint].iter_mut().zip(arrays) {
                if array.len() == state.names.len() {
                    series.rows.push(row as u32);
                    series.values.push(array[k]);
                }
            }
        }
        Ok(())
    }

    fn new_joint(&mut self, name: &str) -> Result<usize, String> {
        let joint = self.joints.len();
        if joint == MAX_JOINTS {
            return Err(format!("it names joint {}; at most {MAX_JOINTS} are expected", joint + 1));
        }
        self.joints.push(shown::line(name).into_owned());
        self.places.insert(name.into(), joint);
        self.series.push(Default::default());
        Ok(joint)
    }

    /// The table of all messages. `name`: topic. `file`: file name for messages.
    ///
    /// Fails if the table would have more than [`MAX_CELLS`] numbers.
    pub(crate) fn table(mut self, name: &str, file: &str, notes: Vec<String>) -> Result<Table, String> {
        let rows = self.stamps.len();
        let (time, clock) = seconds(&self.stamps, &self.log_times);
        let mut table = Table { file: file.into(), notes, ..Table::default() };
        table.notes.insert(0, format!("topic {name}; time from {clock}"));
        table.header.push("time".into());
        table.columns.push(time);
        let mut rare = BTreeSet::new();
        for (k, quantity) in JOINT_STATE_QUANTITIES.iter().enumerate() {
            let mut without = Vec::new();
            for (joint, series) in self.joints.iter().zip(&mut self.series) {
                let series = std::mem::take(&mut series[k]);
                // Some controllers set values to NaN that they do not measure.
                if series.values.iter().all(|x| x.is_nan()) {
                    without.push(joint.as_str());
                    continue;
                }
                if series.rows.len() < rows / SPARSE_JOINT_RATIO {
                    rare.insert(joint.as_str());
                    continue;
                }
                if (table.columns.len() + 1).saturating_mul(rows) > MAX_CELLS {
                    return Err(format!("more than {MAX_CELLS} numbers; cut the recording into parts"));
                }
                table.header.push(format!("{quantity}_{joint}"));
                table.columns.push(series.column(rows));
            }
            if !without.is_empty() {
                table.notes.push(format!("no {quantity} of {}", clipped(without.join(", "))));
            }
        }
        if !rare.is_empty() {
            let rare = clipped(rare.into_iter().collect::<Vec<_>>().join(", "));
            table
                .notes
                .push(format!("left out, because fewer than one message in {SPARSE_JOINT_RATIO} names them: {rare}"));
        }
        if self.uneven > 0 {
            let message = "messages with an array that is neither empty nor as long as `name`: it is not used";
            table.notes.push(format!("{} {message}", self.uneven));
        }
        table.texts = vec![None; table.header.len()];
        Ok(table)
    }
}

/// Time of each message since the first message (s) and the name of the clock. The clock of the recorder is used if no header
/// has a time.
pub(super) fn seconds(stamps: &[i64], log_times: &[i64]) -> (Vec<f64>, &'static str) {
    let stamped = stamps.iter().any(|&s| s != 0);
    // The difference of integers is exact, so a single division gives the nearest f64.
    let times = if stamped { stamps } else { log_times };
    // The first messages of a driver may have the time zero, so the first other time is the start.
    let first = i128::from(times.iter().copied().find(|&t| t != 0).unwrap_or(0));
    let time = times.iter().map(|&t| (i128::from(t) - first) as f64 / 1e9).collect();
    (time, if stamped { "header.stamp" } else { "the recorder's clock, for every header.stamp is zero" })
}

impl NumbersByRow {
    pub(super) fn len(&self) -> usize {
        self.values.len()
    }

    pub(super) fn push(&mut self, row: u32, value: f64) {
        self.rows.push(row);
        self.values.push(value);
    }

    pub(super) fn column(self, rows: usize) -> Vec<f64> {
        if self.values.len() == rows {
            return self.values;
        }
        let mut column = vec![f64::NAN; rows];
        for (row, value) in self.rows.iter().zip(self.values) {
            column[*row as usize] = value;
        }
        column
    }
}

/// Largest number of characters of a list of names in a message.
const MAX_LISTED_CHARACTERS: usize = 600;
/// A list of names, shortened to a readable length.
pub(crate) fn clipped(text: String) -> String {
    let has_room = text.chars().count() <= MAX_LISTED_CHARACTERS;
    if has_room { text } else { text.chars().take(MAX_LISTED_CHARACTERS).chain(" ..".chars()).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_that_come_once_make_no_columns() {
        let names: Vec<String> = (0..MAX_JOINTS).map(|j| format!("j{j}")).collect();
        let all = JointState { names: names.iter().map(String::as_str).collect(), ..JointState::default() };
        let all = JointState { position: vec![1.0; MAX_JOINTS], ..all };
        let one = JointState { names: vec!["j0"], position: vec![2.0], ..JointState::default() };
        let mut table = JointTable::default();
        table.push(1, &all).unwrap();
        (0..20_000).for_each(|r| table.push(2 + r, &one).unwrap());
        let table = table.table("/a", "log", vec![]).unwrap();
        assert_eq!(table.header, ["time", "position_j0"]);
        let notes = &table.notes;
        assert!(notes.iter().any(|n| n.starts_with("left out") && n.contains("j1, j10, j100")), "{notes:?}");
    }
}
