//! Converts rows of named, nested values (as in JSON) to a table of columns.
//!
//! A number is a column with the name of its key, an array the columns key_1 .. key_k, and an object the columns key.name. Next to
//! an array `name` of texts, as in sensor_msgs/JointState, an array of the same length has the columns `key_<text>`, whatever the
//! order of the texts in a row. A key that a row lacks is a missing number.

use std::collections::BTreeMap;

use gate::budget::Budget;

use crate::Error;
use crate::table::{Lines, MAX_COLUMNS, Table, check_header};

/// Longest name of a column, bytes.
const MAX_NAME_BYTES: usize = 256;

/// The last part of the name of an array with the names of joints.
const NAMES: &str = "name";

/// Rows that were read.
pub struct Records<'a> {
    /// The memory that the rows may still take.
    pub budget: &'a mut Budget,
    places: BTreeMap<String, usize>,
    header: Vec<String>,
    /// The numbers of each column, one per row. A column ends with its last number: missing numbers after it are added at the
    /// end.
    columns: Vec<Vec<f64>>,
    texts: Vec<Option<(usize, String)>>,
    /// The values of the row that is being read.
    row: Vec<(String, RowValue)>,
    /// Number of finished rows.
    count: usize,
    lines: Lines,
}

enum RowValue {
    Number(f64),
    Text(String),
}

impl Records<'_> {
    /// Makes an empty table, to which rows can be added.
    pub fn new(budget: &mut Budget) -> Records<'_> {
        Records {
            budget,
            places: BTreeMap::new(),
            header: Vec::new(),
            columns: Vec::new(),
            texts: Vec::new(),
            row: Vec::new(),
            count: 0,
            lines: Lines::default(),
        }
    }

    /// Adds a number to the current row. Fails when the row has too many values.
    pub fn set(&mut self, name: &str, x: f64) -> Result<(), String> {
        self.add(name, RowValue::Number(x))
    }

    /// Adds a text to the current row: a name of a joint, or a cell without a number.
    pub fn set_text(&mut self, name: &str, text: &str) -> Result<(), String> {
        self.add(name, RowValue::Text(text.chars().take(MAX_NAME_BYTES).collect()))
    }

    fn add(&mut self, name: &str, value: RowValue) -> Result<(), String> {
        if self.row.len() == MAX_COLUMNS {
            return Err(format!("more than {MAX_COLUMNS} values in a row"));
        }
        self.row.push((name.into(), value));
        Ok(())
    }

    /// Ends the current row. `line`: line of the file at which the row begins; 0 if the file has no lines.
    ///
    /// Fails when there are too many columns, or the budget is spent.
    pub fn end_row(&mut self, line: usize) -> Result<(), String> {
        let mut row = std::mem::take(&mut self.row);
        name_by_joints(&mut row);
        for (name, value) in row {
            let place = self.column(&name)?;
            match value {
                RowValue::Text(text) => {
                    self.texts[place].get_or_insert((line.max(1), text));
                }
                RowValue::Number(x) => {
                    let missing = (self.count + 1).saturating_sub(self.columns[place].len());
                    self.budget.draw(missing.saturating_mul(size_of::<f64>()))?;
                    let column = &mut self.columns[place];
                    column.resize(column.len().max(self.count + 1), f64::NAN);
                    column[self.count] = x;
                }
            }
        }
        self.count += 1;
        self.lines.push(line);
        Ok(())
    }

    /// The column of a name.
    fn column(&mut self, name: &str) -> Result<usize, String> {
        if let Some(place) = self.places.get(name) {
            return Ok(*place);
        }
        if self.header.len() == MAX_COLUMNS {
            return Err(format!("more than {MAX_COLUMNS} columns"));
        }
        self.places.insert(name.into(), self.header.len());
        self.header.push(name.into());
        self.columns.push(Vec::new());
        self.texts.push(None);
        Ok(self.header.len() - 1)
    }

    /// The table of all rows. Fails where no row holds a number; `expected`: an example of a row.
    pub fn into_table(mut self, file: &str, expected: &str) -> Result<Table, Error> {
        let missing = self.columns.iter().map(|column| self.count - column.len().min(self.count)).sum::<usize>();
        self.budget.draw(missing.saturating_mul(size_of::<f64>())).map_err(|e| Error::at(file, 0, e))?;
        let is_empty = self.columns.iter().all(Vec::is_empty);
        self.columns.iter_mut().for_each(|column| column.resize(self.count, f64::NAN));
        let Records { mut header, columns, texts, lines, .. } = self;
        if is_empty {
            return Err(Error::at(file, 0, format!("no row holds a number; {expected} is expected")));
        }
        check_header(file, 0, &mut header)?;
        Ok(Table { file: file.into(), header, columns, texts, lines, ..Table::default() })
    }
}

/// Names the elements of arrays by the texts of the array `name` next to them: `position_2` becomes `position_elbow`.
fn name_by_joints(row: &mut [(String, RowValue)]) {
    let joints: BTreeMap<String, String> = row
        .iter()
        .filter_map(|(name, value)| {
            let RowValue::Text(joint) = value else { return None };
            let (array, number) = name.rsplit_once('_')?;
            let above = array.strip_suffix(NAMES).filter(|above| above.is_empty() || above.ends_with('.'))?;
            number.bytes().all(|b| b.is_ascii_digit()).then(|| (format!("{above}\0{number}"), joint.clone()))
        })
        .collect();
    if joints.is_empty() {
        return;
    }
    for (name, value) in row {
        let Some((array, number)) = name.rsplit_once('_') else { continue };
        let above = array.rfind('.').map_or("", |at| &array[..=at]);
        if let (RowValue::Number(_), Some(joint)) = (value, joints.get(&format!("{above}\0{number}"))) {
            *name = format!("{array}_{joint}");
        }
    }
}

/// The name of a value `name` inside the value `above`. Fails if the resulting name is too long.
pub fn named(above: &str, name: &str, separator: char) -> Result<String, String> {
    let all = if above.is_empty() { name.to_string() } else { format!("{above}{separator}{name}") };
    (all.len() <= MAX_NAME_BYTES).then_some(all).ok_or(format!("a name is longer than {MAX_NAME_BYTES} bytes"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The messages of two publishers have the joints in different orders. The columns are named by the joints.
    #[test]
    fn joints_are_assigned_by_their_names() {
        let mut budget = Budget::of(1000);
        let mut rows = Records::new(&mut budget);
        for (line, joints) in [["b", "a"], ["a", "b"]].into_iter().enumerate() {
            for (k, joint) in joints.into_iter().enumerate() {
                rows.set_text(&format!("state.name_{}", k + 1), joint).unwrap();
                rows.set(&format!("state.position_{}", k + 1), if joint == "a" { 1.0 } else { 2.0 }).unwrap();
                rows.set(&format!("other_{}", k + 1), 5.0 + k as f64).unwrap();
            }
            rows.end_row(line + 1).unwrap();
        }
        let table = rows.into_table("x", "a number").unwrap();
        let column = |name: &str| &table.columns[table.header.iter().position(|h| h == name).unwrap()];
        assert_eq!((column("state.position_a"), column("state.position_b")), (&vec![1.0; 2], &vec![2.0; 2]));
        // The array `other` has no array of names next to it, so its columns are numbered.
        assert_eq!((column("other_1"), column("other_2")), (&vec![5.0; 2], &vec![6.0; 2]));
    }
}
