//! `rist.Error`: a `ValueError` with the message of the program.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rist::request::spelling::{Reader, spelled};

pyo3::create_exception!(
    rist,
    Error,
    PyValueError,
    "Input that cannot be used, or data that speak against what was asked. The message says where, what was found, what was \
     expected and what to do."
);

/// The exception with a message, whose fields are spelled as keywords.
pub fn error(message: impl std::fmt::Display) -> PyErr {
    Error::new_err(spelled(&message.to_string(), Reader::Python))
}

/// Sentences whose fields are spelled as keywords.
pub fn all_spelled(texts: &[String]) -> Vec<String> {
    texts.iter().map(|text| spelled(text, Reader::Python)).collect()
}

/// Turns the errors of the library into the exception.
pub trait OrError<T> {
    /// The same message.
    fn or_error(self) -> PyResult<T>;
}

impl<T, E: std::fmt::Display> OrError<T> for Result<T, E> {
    fn or_error(self) -> PyResult<T> {
        self.map_err(error)
    }
}
