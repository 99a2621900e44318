//! A table of named columns of numbers, before its columns are assigned to signals.
//!
//! `columns` and `log` determine the meaning of the columns and which rows are usable.

use std::collections::BTreeMap;

use gate::shown::{self, is_hidden};

use crate::Error;

/// Named columns of the same length. A cell that is empty, missing or not a number is NaN.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Name of the file, as given by the user.
    pub file: String,
    /// Names of the columns.
    pub header: Vec<String>,
    /// `columns[c][r]`: column c, row r. A column that was not read is empty.
    pub columns: Vec<Vec<f64>>,
    /// The line number of each row in the file; empty if the file has no lines.
    pub lines: Lines,
    /// For each column, the first cell with text: its line and the text. `None` if the column has no text.
    pub texts: Vec<Option<(usize, String)>>,
    /// Number of rows with too few or too many cells.
    pub ragged: usize,
    /// Number of rows of the file before the first row of this table.
    pub skipped: usize,
    /// Notes on how the file was read.
    pub notes: Vec<String>,
}

impl Table {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// The line number of a row; 0 if the file has no lines.
    pub fn line(&self, row: usize) -> usize {
        self.lines.get(row).unwrap_or(0)
    }
}

/// The line numbers of rows, counted from 1. Memory is only needed for rows that do not follow the previous row directly.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lines {
    /// Pairs (row, line): from this row on, each row is one line after the previous row.
    runs: Vec<(usize, usize)>,
    rows: usize,
}

impl Lines {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.rows == 0
    }

    /// The line number of a row; `None` if there is no such row.
    pub fn get(&self, row: usize) -> Option<usize> {
        let run = self.runs.partition_point(|(first, _)| *first <= row).checked_sub(1)?;
        let (first, line) = self.runs[run];
        (row < self.rows).then(|| line + row - first)
    }

    pub(crate) fn push(&mut self, line: usize) {
        let expected = self.runs.last().map(|(row, line)| line + self.rows - row);
        if expected != Some(line) {
            self.runs.push((self.rows, line));
        }
        self.rows += 1;
    }

    /// Appends the line numbers of the next rows. `above`: number that is added to them.
    pub(crate) fn append(&mut self, next: &Lines, above: usize) {
        for (i, (row, line)) in next.runs.iter().enumerate() {
            self.push(line + above);
            self.rows += next.runs.get(i + 1).map_or(next.rows, |run| run.0) - row - 1;
        }
    }
}

/// Largest number of columns of a log.
pub const MAX_COLUMNS: usize = 10_000;

/// Largest number of values of a table: 2 GiB, or three hours of 22 columns at 1 kHz. A larger table must be divided by the user.
pub const MAX_CELLS: usize = 1 << 28;

/// Largest size of a file that is read as a whole or through a pipe, bytes. Plain text has no such limit.
pub const MAX_FILE_BYTES: u64 = 1 << 31;

/// Reads the rows of a file in several tables.
pub trait RowReader: Send {
    /// Number of columns of the tables.
    fn width(&self) -> usize;

    /// From now on, only these columns are read; all other columns are empty in the next tables.
    fn keep(&mut self, columns: &[usize]);

    /// The next rows, at most `most`. An empty table means the end of the file.
    ///
    /// Fails if a row cannot be read, or if there are more than [`MAX_CELLS`] numbers.
    fn rows(&mut self, most: usize) -> Result<Table, Error>;
}

/// Adds a number to each name that occurs several times: `q_d #1`, `q_d #2`. So none of them is chosen by chance.
fn number_repeated_names(header: &mut [String]) {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    header.iter().for_each(|name| *counts.entry(name.clone()).or_default() += 1);
    counts.retain(|name, count| *count > 1 && !name.is_empty());
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    for name in header.iter_mut().filter(|name| counts.contains_key(*name)) {
        let number = seen.entry(name.clone()).or_default();
        *number += 1;
        *name = format!("{name} #{number}");
    }
}

/// Checks a header: makes hidden characters printable, and numbers repeated names. Fails if there are no names or too many.
/// `line`: line of the header.
pub fn check_header(file: &str, line: usize, header: &mut [String]) -> Result<(), Error> {
    for name in header.iter_mut().filter(|name| name.contains(is_hidden)) {
        *name = shown::line(name).into_owned();
    }
    let at = |message: String| Err(Error::at(file, line, message));
    if header.len() > MAX_COLUMNS {
        return at(format!("{} columns; at most {MAX_COLUMNS} are expected", header.len()));
    }
    if header.iter().all(|h| h.parse::<f64>().is_ok()) {
        return at("the first line holds numbers; a header with the names of the columns is expected".into());
    }
    number_repeated_names(header);
    Ok(())
}
