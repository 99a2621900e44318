//! A column put to use.

use std::fmt;

use crate::cleaning::raw_words::RawWord;
use crate::columns::words::written;

/// The header of a column that is not there.
pub(crate) const NO_COLUMN: &str = "no column";

/// One column put to use.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Index in the table.
    pub column: usize,
    /// As the file has it.
    pub header: String,
    /// Unit of its numbers; empty where the header names none and SI is assumed.
    pub unit: String,
    /// SI per unit of the file.
    pub factor: f64,
    /// How its numbers hold their sign, where they are words of a register.
    pub word: Option<RawWord>,
}

impl Source {
    /// What a number of the file is in SI.
    pub(crate) fn si(&self, x: f64) -> f64 {
        self.factor * self.word.map_or(x, |word| word.signed(x))
    }

    /// Appends numbers of the file in SI.
    pub(crate) fn append_si(&self, column: &[f64], all: &mut Vec<f64>) {
        match (self.word, self.factor) {
            (None, 1.0) => all.extend_from_slice(column),
            (None, factor) => all.extend(column.iter().map(|x| factor * x)),
            (Some(_), _) => all.extend(column.iter().map(|x| self.si(*x))),
        }
    }
}

impl Source {
    /// The name by which options choose it: the header, behind a `-` where its sign is changed.
    pub(crate) fn name(&self) -> String {
        format!("{}{}", if self.factor < 0.0 { "-" } else { "" }, self.header)
    }
}

impl fmt::Display for Source {
    /// The header and the unit, which is not said twice.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.factor < 0.0 { "-" } else { "" })?;
        let unit = written(&self.unit);
        let said = [format!("[{unit}]"), format!("({unit})")];
        let said = said.iter().any(|said| self.header.to_lowercase().ends_with(&said.to_lowercase()));
        if said { f.write_str(&self.header) } else { write!(f, "{} [{unit}]", self.header) }
    }
}
