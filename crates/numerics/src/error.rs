//! What ends a computation without a result.

use std::fmt;

/// A computation without a result, and why. It knows no file: whoever asked for the computation says of what it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Error {
    message: &'static str,
}

impl Error {
    /// An error for this reason.
    pub(crate) const fn new(message: &'static str) -> Error {
        Error { message }
    }

    /// What was found, and what was expected.
    pub fn message(&self) -> &'static str {
        self.message
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.message)
    }
}

impl std::error::Error for Error {}
