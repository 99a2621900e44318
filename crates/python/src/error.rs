//! `rist.Error`: a `ValueError` with the message of the program.

use pyo3::exceptions::{PyUserWarning, PyValueError};
use pyo3::prelude::*;
use rist::request::spelling::{Reader, spelled};
use rist::fit::verdict::{Trust, Verdict};

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

/// What a text of the library calls a command of the program, and how Python has it; the longer ones first.
const COMMANDS: [(&str, &str); 13] = [
    (
        "rist identify write_urdf= or write_mjcf= for simulators, rist generate estimate= for code",
        "identify(.., consistent=True) and estimate.write_urdf or write_mjcf for simulators, model.generate(estimate=estimate) \
         for code",
    ),
    ("rist report draws it", "estimate.report draws it"),
    ("rist simulate feedforward=", "rist.simulate(.., feedforward=estimate)"),
    ("rist validate MODEL ESTIMATE LOG", "rist.validate(model, estimate, log)"),
    ("rist excite after=", "rist.excite(.., after=estimate)"),
    ("rist doctor", "rist.doctor"),
    ("rist plan", "rist.plan"),
    ("rist excite", "rist.excite"),
    ("rist simulate", "rist.simulate"),
    ("rist identify", "rist.identify"),
    ("rist validate", "rist.validate"),
    ("rist check", "rist.check"),
    ("rist accumulate", "rist.Accumulator"),
];

/// A text with its fields spelled as keywords, and commands as functions.
pub fn for_python(text: &str) -> String {
    with_functions(spelled(text, Reader::Python))
}

/// A text whose fields are spelled already, with functions for commands.
pub fn with_functions(text: String) -> String {
    COMMANDS.iter().fold(text, |text, (command, function)| text.replace(command, function))
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
