//! `rist.Error`: a `ValueError` with the message of the program.

use pyo3::exceptions::{PyUserWarning, PyValueError};
use pyo3::prelude::*;
use rist::fit::verdict::{Trust, Verdict};
use rist::request::spelling::{Reader, spelled};

pyo3::create_exception!(
    rist,
    Error,
    PyValueError,
    "Input that cannot be used, or data that speak against what was asked. The message says where, what was found, what was \
     expected and what to do."
);

pyo3::create_exception!(
    rist,
    TrustWarning,
    PyUserWarning,
    "A result that is not to be trusted: its verdict says no. The message says why, and what to do now."
);

/// Warns where the verdict is no; nobody should overlook that in a notebook.
pub fn warn_of(py: Python<'_>, verdict: &Verdict) -> PyResult<()> {
    if verdict.trust != Trust::No {
        return Ok(());
    }
    let text = format!("not to be trusted: {}; next: {}", verdict.reasons.join("; "), verdict.next);
    warn(py, &text, py.get_type::<TrustWarning>().as_any())
}

/// A warning of this category at the line of Python that called.
pub fn warn(py: Python<'_>, text: &str, category: &Bound<'_, PyAny>) -> PyResult<()> {
    py.import("warnings")?.call_method1("warn", (for_python(text), category))?;
    Ok(())
}

/// A text with its fields spelled as keywords, and steps as functions.
pub fn for_python(text: &str) -> String {
    spelled(text, Reader::Python)
}

/// The exception with a message, whose fields are spelled as keywords.
pub fn error(message: impl std::fmt::Display) -> PyErr {
    Error::new_err(for_python(&message.to_string()))
}

/// Sentences whose fields are spelled as keywords.
pub fn all_spelled(texts: &[String]) -> Vec<String> {
    texts.iter().map(|text| for_python(text)).collect()
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
