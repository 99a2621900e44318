//! The error of a computation without a result.

use std::fmt;

/// A computation without a result, and the reason. It knows no file: the caller adds the subject of the computation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Error {
    message: &'static str,
}

impl Error {
    /// An error with this reason.
    pub(crate) const fn new(message: &'static str) -> Error {
        Error { message }
    }

    /// The finding and the expectation.
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
