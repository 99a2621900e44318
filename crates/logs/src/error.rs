//! What is wrong with a log, a column or an option, and where.

use std::fmt;

/// Input that cannot be used: where, what was found, what was expected, what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    file: String,
    line: usize,
    message: String,
}

impl Error {
    /// An error that concerns no file.
    pub fn new(message: impl Into<String>) -> Error {
        Error { file: String::new(), line: 0, message: message.into() }
    }

    /// An error in a file; `line` counts from 1, 0 where no line is to blame.
    pub fn at(file: &str, line: usize, message: impl Into<String>) -> Error {
        Error { file: file.into(), line, message: message.into() }
    }

    /// The file at fault; empty where none is.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The line at fault, from 1; 0 where none is.
    pub fn line(&self) -> usize {
        self.line
    }

    /// What was found, what was expected, what to do.
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
