//! A column of a table that is in use, with its unit.
//!
//! A column in use gives numbers in SI units: raw register words are first converted to signed numbers (word type), and the
//! result is multiplied by a factor.

use std::fmt;

use crate::cleaning::raw_words::RawWord;
use crate::columns::words::written;

/// The text in place of the header if a column is missing.
pub(crate) const NO_COLUMN: &str = "no column";

/// A column in use: its index, header and unit.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnSource {
    /// Index of the column in the table.
    pub column: usize,
    /// Header of the column in the file.
    pub header: String,
    /// Unit of the numbers; empty if the header has none and the SI unit is assumed.
    pub unit: String,
    /// Factor that converts a number of the file to the SI unit. It is negative if the sign is changed.
    pub factor: f64,
    /// The word type of the numbers if they are register words; otherwise `None`.
    pub word: Option<RawWord>,
}

impl ColumnSource {
    /// Converts a number of the file to the SI unit.
    pub fn si(&self, x: f64) -> f64 {
        self.factor * self.word.map_or(x, |word| word.signed(x))
    }

    /// Converts numbers of the file to the SI unit, and appends them to `all`.
    pub(crate) fn append_si(&self, column: &[f64], all: &mut Vec<f64>) {
        match (self.word, self.factor) {
            (None, 1.0) => all.extend_from_slice(column),
            (None, factor) => all.extend(column.iter().map(|x| factor * x)),
            (Some(_), _) => all.extend(column.iter().map(|x| self.si(*x))),
        }
    }
}

impl ColumnSource {
    /// The name that selects the column in options: its header, with a `-` before it if its sign is changed.
    pub(crate) fn name(&self) -> String {
        format!("{}{}", if self.factor < 0.0 { "-" } else { "" }, self.header)
    }
}

impl fmt::Display for ColumnSource {
    /// Writes the header and the unit. The unit is omitted if the header ends with it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.factor < 0.0 { "-" } else { "" })?;
        let unit = written(&self.unit);
        let said = [format!("[{unit}]"), format!("({unit})")];
        let said = said.iter().any(|said| self.header.to_lowercase().ends_with(&said.to_lowercase()));
        if said { f.write_str(&self.header) } else { write!(f, "{} [{unit}]", self.header) }
    }
}
