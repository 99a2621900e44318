//! Named columns of numbers, before anybody says what they mean.
//!
//! What a cell means, and which rows are usable, is for `columns` and `log` to say.

use crate::Error;

/// Named columns of one length. A cell that is empty, missing or no number is NaN.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// The file as the user named it.
    pub file: String,
    /// Names of the columns.
    pub header: Vec<String>,
    /// `columns[c][r]`: column c, row r.
    pub columns: Vec<Vec<f64>>,
    /// The line of the file each row stands on, from 1; empty for files without lines.
    pub lines: Vec<usize>,
    /// For each column the first cell that holds text: its line and the text.
    pub texts: Vec<Option<(usize, String)>>,
    /// Rows with fewer or more cells than the header.
    pub ragged: usize,
    /// Rows of the file before the first of these.
    pub skipped: usize,
    /// What was read and what was not, in a sentence each, where the file leaves a choice.
    pub notes: Vec<String>,
}

impl Table {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// The line of a row, 0 where the file has none.
    pub fn line(&self, row: usize) -> usize {
        self.lines.get(row).copied().unwrap_or(0)
    }
}

/// More columns than this is not a log of a robot.
pub const MAX_COLUMNS: usize = 10_000;

/// More numbers than this, 2 GiB, are to be cut before: three hours of 22 columns at 1 kHz.
pub const MAX_CELLS: usize = 1 << 28;

/// Bytes of a file that is held whole, or of one that comes through a pipe: all but plain text.
pub const MAX_BYTES: u64 = 1 << 31;

/// Refuses headers that name no columns, or too many, or one twice; `line` is where they stand.
pub fn check_header(file: &str, line: usize, header: &[String]) -> Result<(), Error> {
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
