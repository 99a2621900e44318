//! A column in use.

use std::fmt;

use crate::cleaning::raw_words::RawWord;
use crate::columns::words::written;

/// The header in place of a missing column.
pub(crate) const NO_COLUMN: &str = "no column";

/// A column in use, with its unit.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnSource {
    /// Index in the table.
    pub column: usize,
    /// Header in the file.
    pub header: String,
    /// Unit of its numbers; empty where the header names none and SI is assumed.
    pub unit: String,
    /// SI per unit of the file.
    pub factor: f64,
    /// The sign representation of its numbers, where they are register words.
    pub word: Option<RawWord>,
}

impl ColumnSource {
    /// A number of the file in SI.
    pub(crate) fn si(&self, x: f64) -> f64 {
        self.factor * self.word.map_or(x, |word| word.signed(x))
    }

    /// Appends numbers of the file, converted to SI.
    pub(crate) fn append_si(&self, column: &[f64], all: &mut Vec<f64>) {
        match (self.word, self.factor) {
            (None, 1.0) => all.extend_from_slice(column),
            (None, factor) => all.extend(column.iter().map(|x| factor * x)),
            (Some(_), _) => all.extend(column.iter().map(|x| self.si(*x))),
        }
    }
}

impl ColumnSource {
    /// The name that selects it in options: the header, with a leading `-` where its sign is changed.
    pub(crate) fn name(&self) -> String {
        format!("{}{}", if self.factor < 0.0 { "-" } else { "" }, self.header)
    }
}

impl fmt::Display for ColumnSource {
    /// The header and the unit, unless the header already ends in the unit.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.factor < 0.0 { "-" } else { "" })?;
        let unit = written(&self.unit);
        let said = [format!("[{unit}]"), format!("({unit})")];
        let said = said.iter().any(|said| self.header.to_lowercase().ends_with(&said.to_lowercase()));
        if said { f.write_str(&self.header) } else { write!(f, "{} [{unit}]", self.header) }
    }
}
