//! The error for a log, a column or an option that cannot be used.

use std::fmt;

/// An error with its place. The message tells what was found, what was expected, and what the user can do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    file: String,
    line: usize,
    message: String,
}

impl Error {
    /// An error that does not belong to a file.
    pub fn new(message: impl Into<String>) -> Error {
        Error { file: String::new(), line: 0, message: message.into() }
    }

    /// An error in a file. `line` is counted from 1; 0 if it concerns the whole file.
    pub fn at(file: &str, line: usize, message: impl Into<String>) -> Error {
        Error { file: file.into(), line, message: message.into() }
    }

    /// Name of the file; empty if the error does not belong to a file.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Line in the file, counted from 1; 0 if the error has no line.
    pub fn line(&self) -> usize {
        self.line
    }

    /// The message: what was found, what was expected, and what the user can do.
    pub fn message(&self) -> &str {
        &self.message
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.file.as_str(), self.line) {
            ("", _) => write!(f, "{}", self.message),
            (file, 0) => write!(f, "{file}: {}", self.message),
            (file, line) => write!(f, "{file}:{line}: {}", self.message),
        }
    }
}

impl std::error::Error for Error {}
