//! The reason why a step gives no result.

use std::fmt;

/// A message that says what was found, what was expected and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    message: String,
    is_verdict: bool,
}

impl Error {
    /// Input that cannot be used.
    pub fn new(message: impl fmt::Display) -> Error {
        Error { message: message.to_string(), is_verdict: false }
    }

    /// Input that was used, and speaks against what was asked.
    pub fn verdict(message: impl fmt::Display) -> Error {
        Error { message: message.to_string(), is_verdict: true }
    }

    /// Whether the data were read and understood, and the answer is no.
    pub fn is_verdict(&self) -> bool {
        self.is_verdict
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Error {}

impl From<robot::Error> for Error {
    fn from(e: robot::Error) -> Error {
        Error::new(e)
    }
}

impl From<logs::Error> for Error {
    fn from(e: logs::Error) -> Error {
        Error::new(e)
    }
}
