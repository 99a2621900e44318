//! Named columns of numbers, without an assignment to signals.
//!
//! `columns` and `log` decide the meaning of a cell and the usable rows.

use std::collections::BTreeMap;

use gate::shown::{self, is_hidden};

use crate::Error;

/// Named columns of one length. A cell that is empty, missing or not a number is NaN.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Name of the file, as given by the user.
    pub file: String,
    /// Names of the columns.
    pub header: Vec<String>,
    /// `columns[c][r]`: column c, row r. Unwanted columns of a text are empty.
    pub columns: Vec<Vec<f64>>,
    /// The line of each row in the file; empty for files without lines.
    pub lines: Lines,
    /// For each column the first cell with text: its line and the text.
    pub texts: Vec<Option<(usize, String)>>,
    /// Rows with fewer or more cells than the header.
    pub ragged: usize,
    /// Number of rows of the file before the first of these.
    pub skipped: usize,
    /// Notes on choices of the reader: what was read and what was not.
    pub notes: Vec<String>,
}

impl Table {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// The line of a row, 0 where the file has none.
    pub fn line(&self, row: usize) -> usize {
        self.lines.get(row).unwrap_or(0)
    }
}

/// The lines of rows, from 1. Only rows that are not directly below the row before take memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lines {
    /// (row, line): from this row on each row is one line below the row before.
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

    /// The line of a row; `None` after the last.
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

    /// Appends the lines of the next rows, which are counted from `above`.
    pub(crate) fn append(&mut self, next: &Lines, above: usize) {
        for (i, (row, line)) in next.runs.iter().enumerate() {
            self.push(line + above);
            self.rows += next.runs.get(i + 1).map_or(next.rows, |run| run.0) - row - 1;
        }
    }
}

/// Greatest number of columns of a robot's log.
pub const MAX_COLUMNS: usize = 10_000;

/// Greatest number of values of a table, 2 GiB: three hours of 22 columns at 1 kHz. Larger tables must be cut by the user.
pub const MAX_CELLS: usize = 1 << 28;

/// Greatest size of a file that is read as a whole or comes through a pipe, except plain text.
pub const MAX_FILE_BYTES: u64 = 1 << 31;

/// A reader of the rows of a file.
pub trait RowReader: Send {
    /// Number of columns of the tables, from the head of the file.
    fn width(&self) -> usize;

    /// Skips all other columns from now on: they are empty in the next tables.
    fn keep(&mut self, columns: &[usize]);

    /// The next rows, at most `most`; none at the end.
    ///
    /// Fails when a row cannot be read, and when there are more numbers than [`MAX_CELLS`].
    fn rows(&mut self, most: usize) -> Result<Table, Error>;
}

/// Numbers names that stand several times, all of them, so that none is taken by chance: `q_d #1`, `q_d #2`.
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

/// Escapes hidden characters in names, numbers repeated names, and refuses headers without column names or with too many; `line`:
/// the line of the header.
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
