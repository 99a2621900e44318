//! Named columns of numbers, before anybody says what they mean.
//!
//! `columns` and `log` decide what a cell means and which rows are usable.

use gate::shown::{self, is_hidden};

use crate::Error;

/// Named columns of one length. A cell that is empty, missing or no number is NaN.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// The file as the user named it.
    pub file: String,
    /// Names of the columns.
    pub header: Vec<String>,
    /// `columns[c][r]`: column c, row r. Columns of a text that were not asked for are empty.
    pub columns: Vec<Vec<f64>>,
    /// The line of the file each row stands on; none for files without lines.
    pub lines: Lines,
    /// For each column the first cell that holds text: its line and the text.
    pub texts: Vec<Option<(usize, String)>>,
    /// Rows with fewer or more cells than the header.
    pub ragged: usize,
    /// Rows of the file before the first of these.
    pub skipped: usize,
    /// Where the file leaves a choice, a sentence on what was read and what was not.
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

/// The lines of rows, from 1. Only rows that do not stand directly below the row before take memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lines {
    /// (row, line): from this row on each stands one line below the one before.
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

    /// The line of a row; `None` behind the last.
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

    /// Adds those of rows that follow, whose lines are counted from `above`.
    pub(crate) fn append(&mut self, next: &Lines, above: usize) {
        for (i, (row, line)) in next.runs.iter().enumerate() {
            self.push(line + above);
            self.rows += next.runs.get(i + 1).map_or(next.rows, |run| run.0) - row - 1;
        }
    }
}

/// More columns than this is not a log of a robot.
pub const MAX_COLUMNS: usize = 10_000;

/// Tables of more numbers, 2 GiB, must be cut by the user. Three hours of 22 columns at 1 kHz have as many.
pub const MAX_CELLS: usize = 1 << 28;

/// Bytes of a file that is held whole, or of one that comes through a pipe: all but plain text.
pub const MAX_FILE_BYTES: u64 = 1 << 31;

/// Rows of a file on their way into tables.
pub trait RowReader: Send {
    /// How many columns the tables will have, as far as the head of the file tells.
    fn width(&self) -> usize;

    /// Leaves all but these columns of the tables unread from now on: they are empty in the tables that follow.
    fn keep(&mut self, columns: &[usize]);

    /// The next rows, at most `most`; none at the end.
    ///
    /// Fails when a row cannot be read, and when there are more numbers than [`MAX_CELLS`].
    fn rows(&mut self, most: usize) -> Result<Table, Error>;
}

/// Shows what names hide, and refuses headers that name no columns, or too many, or one twice; `line` is where they stand.
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
    for (i, name) in header.iter().enumerate() {
        if !name.is_empty() && header[..i].contains(name) {
            return at(format!("two columns are named `{name}`; every column needs a name of its own"));
        }
    }
    Ok(())
}
