//! The class `rist.Verdict`.
//!
//! A verdict states whether to trust a result (yes, with care, no), overall and for each use of the result. Claims are single
//! statements with their evidence.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::artefact::hash;
use crate::error::{all_spelled, for_python};
use rist::fit::verdict::{Trust, UseVerdict};

use crate::html;

/// Whether to trust a result: `trust` is "yes", "with care" or "no".
#[pyclass(frozen, module = "rist")]
pub struct Verdict {
    pub said: Said,
}

/// A verdict and its sentences. Claims cannot be rebuilt from a pickle, so a verdict from a pickle has only their sentences.
#[derive(Clone)]
pub struct Said {
    pub inner: rist::fit::verdict::Verdict,
    claims: Vec<String>,
    pub text: String,
}

impl From<rist::fit::verdict::Verdict> for Said {
    fn from(inner: rist::fit::verdict::Verdict) -> Said {
        Said { claims: inner.claims.iter().map(ToString::to_string).collect(), text: inner.to_string(), inner }
    }
}

/// One use of an estimate in a pickle: name, trust, relative error, and the joint with the largest error.
type UseParts = (String, String, Option<f64>, Option<(String, f64)>);

#[pymethods]
impl Verdict {
    /// "yes", "with care" or "no".
    #[getter]
    fn trust(&self) -> &'static str {
        self.said.inner.trust.word()
    }

    /// The verdict for each use, by the name of the use: "yes", "with care" or "no".
    #[getter]
    fn uses(&self) -> BTreeMap<&str, &str> {
        self.said.inner.uses.iter().map(|u| (u.name.as_str(), u.trust.word())).collect()
    }

    /// Relative uncertainty of the torque for each use, by the name of the use; None if it is not known.
    #[getter]
    fn torque_errors(&self) -> BTreeMap<&str, Option<f64>> {
        self.said.inner.uses.iter().map(|u| (u.name.as_str(), u.error)).collect()
    }

    /// All claims that were checked, each with its evidence.
    #[getter]
    fn claims(&self) -> Vec<String> {
        all_spelled(&self.said.claims)
    }

    /// What was found.
    #[getter]
    fn found(&self) -> &str {
        &self.said.inner.found
    }

    /// The reasons of the verdict, the most important first.
    #[getter]
    fn reasons(&self) -> Vec<String> {
        all_spelled(&self.said.inner.reasons)
    }

    /// The next step: what to do now.
    #[getter]
    fn next(&self) -> String {
        for_python(&self.said.inner.next)
    }

    fn __repr__(&self) -> String {
        for_python(&self.said.text)
    }

    fn _repr_html_(&self) -> String {
        html::text(&self.__repr__())
    }

    /// trust, found, reasons, next, uses, torque_errors and claims by their names.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("trust", self.trust())?;
        dict.set_item("found", self.found())?;
        dict.set_item("reasons", self.reasons())?;
        dict.set_item("next", self.next())?;
        dict.set_item("uses", self.uses())?;
        dict.set_item("torque_errors", self.torque_errors())?;
        dict.set_item("claims", self.claims())?;
        Ok(dict)
    }

    fn __eq__(&self, other: &Bound<'_, Verdict>) -> bool {
        self.said.text == other.get().said.text && self.said.claims == other.get().said.claims
    }

    fn __hash__(&self) -> u64 {
        hash(&self.said.text)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Parts)> {
        let rist::fit::verdict::Verdict { found, reasons, next, uses, .. } = &self.said.inner;
        let part = |u: &UseVerdict| (u.name.clone(), u.trust.word().into(), u.error, u.worst_joint.clone());
        let uses = uses.iter().map(part).collect();
        let (claims, text) = (self.said.claims.clone(), self.said.text.clone());
        let parts = (self.trust().into(), found.clone(), reasons.clone(), next.clone(), uses, claims, text);
        Ok((py.import("rist")?.getattr("_verdict")?, parts))
    }
}

/// Content of the pickle of a verdict: trust, found, reasons, next, uses, claims, text.
type Parts = (String, String, Vec<String>, String, Vec<UseParts>, Vec<String>, String);

fn trust(word: &str) -> Trust {
    match word {
        "yes" => Trust::Yes,
        "with care" => Trust::WithCare,
        _ => Trust::No,
    }
}

/// Rebuilds a verdict from its pickle.
#[pyfunction]
pub fn _verdict(
    word: &str,
    found: String,
    reasons: Vec<String>,
    next: String,
    uses: Vec<UseParts>,
    claims: Vec<String>,
    text: String,
) -> Verdict {
    let one = |(name, word, error, worst_joint): UseParts| UseVerdict { name, trust: trust(&word), error, worst_joint };
    let uses = uses.into_iter().map(one).collect();
    let inner = rist::fit::verdict::Verdict { trust: trust(word), found, reasons, next, uses, claims: Vec::new() };
    Verdict { said: Said { inner, claims, text } }
}
