//! Reads texts with one row per joint and sample, and the joints in turn: `timestamp,joint,position,effort`.
//!
//! A sample is the rows from one joint to the next appearance of this joint. A column of the text becomes one column per joint,
//! `name_<joint>`. The time of a sample is the time of its first row.

use logs::reading::{Budget, Records, TextHead, is_clock, number, rows};
use logs::{Error, Table};

use std::collections::BTreeSet;

/// Headers by which the column with the name of the joint is recognised.
const JOINT_HEADERS: [&str; 14] = [
    "joint",
    "joint_name",
    "joint_id",
    "jointname",
    "name",
    "id",
    "motor",
    "motor_id",
    "motor_name",
    "servo",
    "servo_id",
    "axis",
    "actuator",
    "joint_index",
];

fn joint_column(header: &[String]) -> Option<usize> {
    header.iter().position(|name| JOINT_HEADERS.contains(&name.trim().to_lowercase().as_str()))
}

/// Whether the first rows name several joints, always in the same order and at least twice each.
pub(crate) fn is_so(head: &TextHead) -> bool {
    let Some((header, rows)) = head.rows.split_first() else { return false };
    let Some(column) = joint_column(header) else { return false };
    let joints: Vec<&String> = rows.iter().filter_map(|row| row.get(column)).collect();
    let count = joints.iter().collect::<BTreeSet<_>>().len();
    let is_in_turn = joints.iter().zip(joints.iter().skip(count)).all(|(a, b)| a == b);
    count > 1 && joints.len() >= 2 * count && is_in_turn
}

/// Reads a text with one row per joint as a table. Fails if there are too many columns.
pub(crate) fn read(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
    let delimiter = TextHead::delimiter_of(bytes);
    let mut all = rows(bytes, delimiter);
    let header = all.next().map(|(_, cells)| cells).unwrap_or_default();
    let column = joint_column(&header).unwrap_or_default();
    let mut found = Records::new(budget);
    let mut seen: BTreeSet<String> = BTreeSet::new();
    let mut begin = 0;
    for (line, cells) in all {
        let joint = cells.get(column).cloned().unwrap_or_default();
        // A joint that the present sample already contains begins the next sample.
        let is_next = seen.contains(&joint);
        let mut set = || {
            if is_next {
                found.end_row(begin)?;
            }
            for (name, cell) in
                header.iter().zip(&cells).enumerate().filter(|(k, _)| *k != column).map(|(_, pair)| pair)
            {
                // The clock is read only in the first row of a sample.
                let is_clock = is_clock(name);
                let Some(x) = number(cell.as_bytes(), delimiter).filter(|_| !is_clock || is_next || seen.is_empty())
                else {
                    continue;
                };
                let of_joint = format!("{name}_{joint}");
                found.set(if is_clock { name } else { &of_joint }, x)?;
            }
            Ok(())
        };
        set().map_err(|e: String| Error::at(file, line, e))?;
        if is_next || seen.is_empty() {
            seen.clear();
            begin = line;
        }
        seen.insert(joint);
    }
    // No row follows the last sample, so it is ended here.
    if !seen.is_empty() {
        found.end_row(begin).map_err(|e| Error::at(file, begin, e))?;
    }
    found.into_table(file, "a row with numbers")
}

#[cfg(test)]
mod tests {
    #[test]
    fn rows_of_joints_become_columns() {
        let text = "t,joint,position,effort\n0,b,1,5\n0,a,2,6\n0.1,b,3,7\n0.1,a,4,8\n0.2,b,5,9\n";
        let found = crate::text::table(text).unwrap();
        assert_eq!(found.header, ["t", "position_b", "effort_b", "position_a", "effort_a"]);
        assert_eq!((&found.columns[0], &found.columns[1]), (&vec![0.0, 0.1, 0.2], &vec![1.0, 3.0, 5.0]));
        // The last sample lacks joint a.
        assert!(found.columns[3][..2] == [2.0, 4.0] && found.columns[3][2].is_nan());
        assert_eq!(found.line(1), 4);
        // The joints are numbers, and the time increases also within a sample.
        let found = crate::text::table("time_ms,id,pos\n0,1,1\n1,2,2\n10,1,3\n11,2,4\n").unwrap();
        assert_eq!((found.header.join(" "), &found.columns[0]), ("time_ms pos_1 pos_2".into(), &vec![0.0, 10.0]));
    }
}
