//! What is wrong with a log, a column or an option, and where.

use std::fmt;

use robot::Place;

/// Input that cannot be used: where, what was found, what was expected, what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    place: Place,
    message: String,
}

impl Error {
    /// An error that concerns no file.
    pub fn new(message: impl Into<String>) -> Error {
        Error { place: Place::default(), message: message.into() }
    }

    /// An error in a file; `line` counts from 1, 0 where no line is to blame.
    pub fn at(file: &str, line: usize, message: impl Into<String>) -> Error {
        Error { place: Place { file: file.into(), line, column: 0 }, message: message.into() }
    }

    /// File and line; an empty file name where none is to blame.
    pub fn place(&self) -> &Place {
        &self.place
    }

    pub fn message(&self) -> &str {
        &self.message
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.place.file.as_str(), self.place.line) {
            ("", _) => write!(f, "{}", self.message),
            (file, 0) => write!(f, "{file}: {}", self.message),
            (file, line) => write!(f, "{file}:{line}: {}", self.message),
        }
    }
}

impl std::error::Error for Error {}
