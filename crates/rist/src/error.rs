//! The reason why a step gives no result.

use std::fmt;

use robot::Place;

/// A message that says what was found, what was expected and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    message: String,
    is_verdict: bool,
    place: Option<Place>,
}

impl Error {
    /// Input that cannot be used.
    pub fn new(message: impl fmt::Display) -> Error {
        Error { message: message.to_string(), is_verdict: false, place: None }
    }

    /// Input that was understood, but speaks against what was asked.
    pub fn verdict(message: impl fmt::Display) -> Error {
        Error { message: message.to_string(), is_verdict: true, place: None }
    }

    /// The same error, told to be about a field; a message that names its field, or a file, stays.
    pub(crate) fn about(self, field: &str) -> Error {
        let names_it = self.place.is_some() || self.message.contains(&format!("[{field}"));
        if names_it { self } else { Error { message: format!("[{field}]: {}", self.message), ..self } }
    }

    /// The line of a file that is at fault, where one is; it stands in the message too.
    pub fn place(&self) -> Option<&Place> {
        self.place.as_ref()
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
        Error { place: Some(e.place.clone()).filter(|place| place.line > 0), ..Error::new(e) }
    }
}

impl From<logs::Error> for Error {
    fn from(e: logs::Error) -> Error {
        let place = Place { file: e.file().into(), line: e.line(), column: 0 };
        Error { place: Some(place).filter(|place| place.line > 0), ..Error::new(e) }
    }
}

impl From<numerics::Error> for Error {
    fn from(e: numerics::Error) -> Error {
        Error::new(e)
    }
}
