//! `rist.Verdict`.

use pyo3::prelude::*;
use rist::request::spelling::{Reader, spelled};

use crate::error::all_spelled;
use rist::verdict::Trust;

use crate::html;

/// Whether to trust a result: `trust` is "yes", "with care" or "no".
#[pyclass(frozen, module = "rist")]
pub struct Verdict {
    pub inner: rist::verdict::Verdict,
}

#[pymethods]
impl Verdict {
    /// "yes", "with care" or "no".
    #[getter]
    fn trust(&self) -> &'static str {
        match self.inner.trust {
            Trust::Yes => "yes",
            Trust::WithCare => "with care",
            Trust::No => "no",
        }
    }

    /// What was found.
    #[getter]
    fn found(&self) -> &str {
        &self.inner.found
    }

    /// Why, the weightiest reason first.
    #[getter]
    fn reasons(&self) -> Vec<String> {
        all_spelled(&self.inner.reasons)
    }

    /// What to do now.
    #[getter]
    fn next(&self) -> String {
        spelled(&self.inner.next, Reader::Python)
    }

    fn __repr__(&self) -> String {
        spelled(&self.inner.to_string(), Reader::Python)
    }

    fn _repr_html_(&self) -> String {
        html::text(&self.inner.to_string())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, String, Vec<String>, String))> {
        let of =
            (self.trust().to_string(), self.inner.found.clone(), self.inner.reasons.clone(), self.inner.next.clone());
        Ok((py.import("rist")?.getattr("_verdict")?, of))
    }
}

/// What a pickle of a verdict calls.
#[pyfunction]
pub fn _verdict(trust: &str, found: String, reasons: Vec<String>, next: String) -> Verdict {
    let trust = match trust {
        "yes" => Trust::Yes,
        "with care" => Trust::WithCare,
        _ => Trust::No,
    };
    Verdict { inner: rist::verdict::Verdict { trust, found, reasons, next } }
}
