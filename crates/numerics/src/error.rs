//! The error of a numerical computation that has no result, for example if a matrix is singular.

use std::fmt;

/// The error of a computation that has no result. The message does not name a file or a quantity; the caller adds both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Error {
    message: &'static str,
}

impl Error {
    /// Makes an error from its message.
    pub(crate) const fn new(message: &'static str) -> Error {
        Error { message }
    }

    /// The message: the reason why there is no result.
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
