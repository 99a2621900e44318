//! The exception `rist.Error`, a `ValueError` with the message of the library, and warnings.

use pyo3::exceptions::{PyDeprecationWarning, PyUserWarning, PyValueError};
use pyo3::prelude::*;
use rist::fit::verdict::{Trust, Verdict};
use rist::request::spelling::{Audience, spelled};

pyo3::create_exception!(
    rist,
    Error,
    PyValueError,
    "Input that cannot be used, or data that contradict the request. The message says where the fault is, what was \
     found, what was expected and what to do."
);

pyo3::create_exception!(
    rist,
    TrustWarning,
    PyUserWarning,
    "A result that is not to be trusted, because its verdict is no. The message says why, and what to do now."
);

/// Issues a warning if the verdict on the trust in a result is "no", so that the user of a notebook notices it.
pub fn warn_of(py: Python<'_>, verdict: &Verdict) -> PyResult<()> {
    if verdict.trust != Trust::No {
        return Ok(());
    }
    let text = format!("not to be trusted: {}; next: {}", verdict.reasons.join("; "), verdict.next);
    warn(py, &text, py.get_type::<TrustWarning>().as_any())
}

/// Issues a warning of the class `category` for the calling line of Python.
pub fn warn(py: Python<'_>, text: &str, category: &Bound<'_, PyAny>) -> PyResult<()> {
    py.import("warnings")?.call_method1("warn", (for_python(text), category))?;
    Ok(())
}

/// Rewrites a message for Python: names of request fields become Python keywords, and commands become Python functions.
pub fn for_python(text: &str) -> String {
    spelled(text, Audience::Python)
}

/// The exception `rist.Error`. Names of request fields in its message are written as Python keywords.
pub fn error(message: impl std::fmt::Display) -> PyErr {
    Error::new_err(for_python(&message.to_string()))
}

/// Sentences in which names of request fields are written as Python keywords.
pub fn all_spelled(texts: &[String]) -> Vec<String> {
    texts.iter().map(|text| for_python(text)).collect()
}

/// Converts errors of the library to the exception `rist.Error`.
pub trait OrError<T> {
    /// The result, with an error converted to an exception with the same message.
    fn or_error(self) -> PyResult<T>;
}

impl<T, E: std::fmt::Display> OrError<T> for Result<T, E> {
    fn or_error(self) -> PyResult<T> {
        self.map_err(error)
    }
}

/// Issues a DeprecationWarning that something has a new name. The next version removes the former name.
pub(crate) fn renamed(py: Python<'_>, text: &str) -> PyResult<()> {
    warn(py, text, py.get_type::<PyDeprecationWarning>().as_any())
}
