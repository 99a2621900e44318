//! The function `rist.validate`: computes the prediction errors of an estimate on logs that were not fitted.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rist::fit::validation::{ValidateRequest, is_fitted};
use rist::page::{Origin, PageRequest};
use rist::request::Request;
use rist::request::spelling::Audience;

use crate::artefact::{artefact, save};
use crate::call::Call;
use crate::error::{OrError, error, warn_of};
use crate::estimate::Estimate;
use crate::logs::{logs, open};
use crate::model::Model;
use crate::verdict::Verdict;
use crate::work::work;

artefact! {
    Validation,
    rist::Validation,
    "How well an estimate predicts logs from which it was not made.",
    /// Relative error |tau - tau_predicted| / |tau| over all joints and logs.
    #[getter]
    fn total(&self) -> f64 {
        self.inner.total
    }
    /// Errors of the joints: a dict of columns (coordinate, relative, rms, unit), one row per joint.
    #[getter]
    fn joints<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (joints, table) = (&self.inner.joints, PyDict::new(py));
        table.set_item("coordinate", joints.iter().map(|j| j.coordinate.as_str()).collect::<Vec<_>>())?;
        table.set_item("relative", joints.iter().map(|j| j.relative).collect::<Vec<_>>())?;
        table.set_item("rms", joints.iter().map(|j| j.rms).collect::<Vec<_>>())?;
        table.set_item("unit", joints.iter().map(|j| j.unit.to_string()).collect::<Vec<_>>())?;
        Ok(table)
    }
    /// Draws the relative errors by joint and by log. Returns axes of matplotlib; without matplotlib, a rist.Picture.
    fn plot<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("rist._plot")?.call_method1("validation", (slf,))
    }

    /// The charts of the HTML page of this validation: the name and the SVG text of each chart.
    fn _pictures(&self) -> Vec<(String, String)> {
        rist::page::page(&PageRequest { validation: Some(&self.inner), ..PageRequest::default() }).1
    }

    /// Writes one self-contained HTML page.
    #[pyo3(signature = (path, date=None))]
    fn report(&self, path: PathBuf, date: Option<&str>) -> PyResult<()> {
        save(&path, &self.page(date).unwrap_or_default(), &[])
    }

    /// Relative errors by log.
    #[getter]
    fn logs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let logs = PyDict::new(py);
        self.inner.motions.iter().try_for_each(|m| logs.set_item(&m.name, m.relative))?;
        Ok(logs)
    }
}

impl Validation {
    /// The page of the validation.
    fn page(&self, date: Option<&str>) -> Option<String> {
        let request = PageRequest {
            model: self.model.as_ref().map(|model| model.get().inner.as_ref()),
            validation: Some(&self.inner),
            origin: Origin { date, version: env!("CARGO_PKG_VERSION"), command: "rist.Validation.report", model: None },
            reader: Audience::Python,
            ..PageRequest::default()
        };
        Some(rist::page::page(&request).0)
    }
}

/// Predicts logs with an estimate, and compares measured and predicted torques. Returns a Validation and a Verdict. If the
/// verdict is no, a rist.TrustWarning says so.
///
/// model: the Model of the estimate, or its path. logs: as for `identify`. For an estimate from the experiments of a plan, logs
/// are the paths of motions, and you can give gain={"q1": 2.4} (N m/A) and cutoff (Hz, default 20).
///
/// Options:
/// - gain: Drive gain (torque per current), N m/A [default: from the estimate; otherwise from the description;
///   otherwise 1]
/// - cutoff: Cut-off of the low-pass on position and torque, Hz [default: 20; an estimate from samples uses its
///   own cut-off]
#[pyfunction]
#[pyo3(signature = (model, estimate, logs, **options), text_signature = "(model, estimate, logs, *, gain=None, cutoff=None)")]
pub fn validate(
    py: Python<'_>,
    model: &Bound<'_, PyAny>,
    estimate: &Estimate,
    logs: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<(Validation, Verdict)> {
    let call = Call::new("validate", &[], options)?;
    let request: ValidateRequest = call.request()?;
    let used = Model::for_estimate(model, estimate)?;
    let (model, estimate, logs) = (&used.get().inner, &estimate.inner, self::logs(logs)?);
    model.check_estimate("the estimate".as_ref(), estimate).or_error()?;
    // A log that was used in the fit does not test predictions.
    let are_new = !logs.iter().filter_map(|log| log.path()).any(|path| is_fitted(estimate, path.as_ref()));
    let (inner, verdict) = match &estimate.options {
        Some(options) => {
            if !request.given().is_empty() {
                return Err(error(
                    "validate: leave cutoff and gain out, since an estimate from samples holds those that it was made with",
                ));
            }
            work(py, None, |_| {
                let logs = open(logs, model, &options.columns)?;
                let validation = rist::validate(model, estimate, &logs)?;
                let verdict =
                    rist::fit::verdict::validation_verdict(model, estimate, &logs, validation.total, are_new)?;
                Ok((validation, verdict))
            })?
        }
        None => {
            let paths: Option<Vec<PathBuf>> = logs.iter().map(|log| log.path().map(Into::into)).collect();
            let paths = paths
                .ok_or_else(|| error("validate: an estimate of experiments predicts motions in files: give paths"))?;
            work(py, None, |_| {
                let validation = rist::fit::validation::validate_experiments(model, estimate, &paths, &request)?;
                let verdict = rist::fit::verdict::validation_verdict(model, estimate, &[], validation.total, are_new)?;
                Ok((validation, verdict))
            })?
        }
    };
    warn_of(py, &verdict)?;
    Ok((Validation { inner, model: Some(used.clone().unbind()) }, Verdict { said: verdict.into() }))
}
