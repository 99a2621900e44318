//! The error of a description: a message and its place.

use std::fmt;

/// A place in a file; line and column count from 1, zero where unknown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// The file name that the caller gave.
    pub file: String,
    /// Line, from 1; 0 where the error concerns the whole file.
    pub line: usize,
    /// Column, from 1; 0 where unknown.
    pub column: usize,
}

/// A description that cannot be used: where, what was found, what was expected, what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    /// Where the description is wrong.
    pub place: Place,
    /// What was found, what was expected, what to do.
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
