//! Whether to trust an estimate: one of experiments by itself, one of logs by other logs.

use identification::estimate::described::described_residuals;
use identification::estimate::options::Options;
use identification::estimate::passport::finding::Fault;
use identification::estimate::verdict::{Evidence, Prediction};
use identification::rows::observation::Observation;
use identification::signals::records::SourceRecords;
use logs::LogSource;

pub use identification::estimate::verdict::{Trust, UseVerdict, Verdict, claim_line};

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::doctor::examine;
use identification::estimate::artefact::Estimate;

/// Whether to trust an estimate by its own evidence alone. [`crate::fit::samples::Identification::judged`] has more evidence.
pub fn estimate_verdict(estimate: &Estimate) -> Verdict {
    predicted_verdict(estimate, None)
}

/// The same with the error on motions that it was not made from, where there are some.
pub fn predicted_verdict(estimate: &Estimate, predicted: Option<f64>) -> Verdict {
    Verdict::of(&evidence(estimate, predicted))
}

/// What an estimate says of itself. Which motion its parts left out were is not in it; each experiment of a plan is a motion of
/// its own.
pub fn evidence(estimate: &Estimate, predicted: Option<f64>) -> Evidence<'_> {
    let (held_out, parts_are_new) = (estimate.cross_validation, estimate.options.is_none());
    Evidence {
        estimate,
        passport: None,
        described: None,
        described_parameters: None,
        total: estimate.total,
        is_of_fit: true,
        prediction: Prediction { others: predicted, held_out, parts_are_new, ..Prediction::default() },
        bodies: None,
        opens_in_any_motion: false,
        faults: &[],
        mended: &[],
    }
}

/// Whether to trust an estimate by the logs it was fitted to, read once more.
///
/// Fails where a log cannot be read.
pub fn fitted_verdict(model: &Model, estimate: &Estimate, logs: &[LogSource]) -> Result<Verdict, Error> {
    let Some(options) = &estimate.options else { return Ok(estimate_verdict(estimate)) };
    let (passport, parameters) = (examine(model, logs, options)?, model.described_parameters());
    let mut evidence = evidence(estimate, None);
    evidence.prediction.parts_are_new = passport.visited.has_new_parts();
    Ok(Verdict::of(&Evidence {
        passport: Some(&passport),
        described: described(model, options, logs)?,
        described_parameters: parameters.as_deref(),
        ..evidence
    }))
}

/// Error of the description with fitted friction; `None` where it has no inertials.
fn described(model: &Model, options: &Options, logs: &[LogSource]) -> Result<Option<f64>, Error> {
    let Some(described) = model.described_parameters() else { return Ok(None) };
    let linear = options.linear_model(model.regressor());
    let records = SourceRecords::new(model.regressor(), logs, &options.preparation())?;
    let joints = Observation::of_records(&linear, &records, None)?.joints(|_| true);
    Ok(Some(described_residuals(&linear, &joints, &vec![1.0; joints.len()], &described).total))
}

/// Whether to trust an estimate, by how well it predicts logs, `total`. For an estimate of experiments `total` is the
/// only evidence. `are_new`: it was not made from any of them, as [`crate::fit::validation::is_fitted`] tells.
///
/// Fails where a log cannot be read.
pub fn validation_verdict(
    model: &Model,
    estimate: &Estimate,
    logs: &[LogSource],
    total: f64,
    are_new: bool,
) -> Result<Verdict, Error> {
    let parameters = model.described_parameters();
    let mut evidence =
        Evidence { total: Some(total), is_of_fit: false, ..evidence(estimate, Some(total).filter(|_| are_new)) };
    evidence.prediction.held_out = None;
    let Some(options) = &estimate.options else { return Ok(Verdict::of(&evidence)) };
    let mut passport = examine(model, logs, options)?;
    // A short log is long enough for a prediction.
    passport.findings.retain(|f| !matches!(f.fault, Fault::Short(_)));
    evidence.passport = Some(&passport);
    evidence.described = described(model, options, logs)?;
    evidence.prediction.others_described = evidence.described.filter(|_| are_new);
    evidence.described_parameters = parameters.as_deref();
    Ok(Verdict::of(&evidence))
}
