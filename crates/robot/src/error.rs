//! The error for a description that cannot be used: a message and a place in the file.

use std::fmt;

/// A place in a file. Line and column are counted from 1.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Name of the file, as the caller gave it.
    pub file: String,
    /// Line, counted from 1; 0 if the error concerns the whole file.
    pub line: usize,
    /// Column, counted from 1; 0 if it is unknown.
    pub column: usize,
}

/// The error for a description that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    /// The place in the file where the mistake is.
    pub place: Place,
    /// The message: what was found, what was expected, and what the user can do.
    pub message: String,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Place { file, line, column } = &self.place;
        match (line, column) {
            (0, _) => write!(f, "{file}: {}", self.message),
            (line, 0) => write!(f, "{file}:{line}: {}", self.message),
            (line, column) => write!(f, "{file}:{line}:{column}: {}", self.message),
        }
    }
}

impl std::error::Error for Error {}
