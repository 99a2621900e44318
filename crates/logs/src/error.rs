//! A fault of a log, a column or an option, with its place.

use std::fmt;

/// Unusable input: the place, the finding, the expectation, and the remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    file: String,
    line: usize,
    message: String,
}

impl Error {
    /// An error without a file.
    pub fn new(message: impl Into<String>) -> Error {
        Error { file: String::new(), line: 0, message: message.into() }
    }

    /// An error in a file; `line` counts from 1; 0: no particular line.
    pub fn at(file: &str, line: usize, message: impl Into<String>) -> Error {
        Error { file: file.into(), line, message: message.into() }
    }

    /// The file of the error; empty where there is none.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The line of the error, from 1; 0 where there is none.
    pub fn line(&self) -> usize {
        self.line
    }

    /// The finding, the expectation, and the remedy.
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
