//! Judges whether to trust an estimate. Evidence: the estimate itself, and for an estimate of logs also other logs.
//!
//! The verdict is yes, with care, or no, with reasons. Held-out segments are parts of the logs that are left out of the fit and
//! predicted. An estimate of logs is from `rist identify` with samples, an estimate of experiments from the logs of a plan.

use std::path::Path;

use identification::estimate::log_check::finding::Fault;
use identification::estimate::nominal_prediction::nominal_residuals;
use identification::estimate::options::Options;
use identification::estimate::verdict::{Evidence, Prediction};
use identification::rows::observation::Observation;
use identification::signals::records::SourceRecords;
use logs::LogSource;

pub use identification::estimate::verdict::{Trust, UseVerdict, Verdict, claim_line};

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::contact::Contacts;
use crate::fit::doctor::examine_columns;
use crate::fit::validation::values_of;
use identification::estimate::artefact::Estimate;

/// Judges an estimate by its own content alone. [`crate::fit::samples::Identification::verdict_of_logs`] also uses logs.
pub fn estimate_verdict(estimate: &Estimate) -> Verdict {
    predicted_verdict(estimate, None)
}

/// Fails if the verdict on an estimate is no, unless `anyway` is set. For messages: `file`, the name of the estimate's file;
/// `outcome`, the action that is then not done.
pub(crate) fn refuse_estimate(file: &Path, estimate: &Estimate, anyway: bool, outcome: &str) -> Result<(), Error> {
    let verdict = estimate_verdict(estimate);
    if verdict.trust != Trust::No || anyway {
        return Ok(());
    }
    // The file may repeat the reasons of an earlier verdict.
    let mut reasons: Vec<&str> = Vec::new();
    for reason in &verdict.reasons {
        if !reasons.contains(&reason.as_str()) {
            reasons.push(reason);
        }
    }
    Err(Error::verdict(format_args!("{}: not to be trusted: {}; {outcome}", file.display(), reasons.join("; "))))
}

/// Judges an estimate by its own content. `predicted`: the relative error of the estimate on motions that were not fitted, if
/// any.
pub fn predicted_verdict(estimate: &Estimate, predicted: Option<f64>) -> Verdict {
    Verdict::of(&evidence(estimate, predicted))
}

/// The evidence that an estimate contains. An estimate of logs does not store whether its held-out segments show another
/// motion. For an estimate of a plan, the held-out segments show another motion, because each experiment is another motion.
pub fn evidence(estimate: &Estimate, predicted: Option<f64>) -> Evidence<'_> {
    let (held_out, parts_are_new) = (estimate.cross_validation, estimate.options.is_none());
    Evidence {
        estimate,
        log_check: None,
        described: None,
        nominal_parameters: None,
        total: estimate.total,
        is_of_fit: true,
        prediction: Prediction { others: predicted, held_out, parts_are_new, ..Prediction::default() },
        bodies: None,
        opens_in_any_motion: false,
        faults: &[],
        mended: &[],
    }
}

/// Judges an estimate by the logs to which it was fitted. The logs are read again.
///
/// Fails if a log cannot be read.
pub fn fitted_verdict(model: &Model, estimate: &Estimate, logs: &[LogSource]) -> Result<Verdict, Error> {
    let Some(options) = &estimate.options else { return Ok(estimate_verdict(estimate)) };
    let ((log_check, _), parameters) = (examine_columns(model, logs, options)?, model.nominal_parameters());
    let mut evidence = evidence(estimate, None);
    evidence.prediction.parts_are_new = log_check.visited.has_new_parts();
    Ok(Verdict::of(&Evidence {
        log_check: Some(&log_check),
        described: nominal_error(model, options, logs)?,
        nominal_parameters: parameters.as_deref(),
        ..evidence
    }))
}

/// Relative torque error of the description with fitted friction; `None` if the description has no inertial parameters.
fn nominal_error(model: &Model, options: &Options, logs: &[LogSource]) -> Result<Option<f64>, Error> {
    let Some(nominal) = model.nominal_parameters() else { return Ok(None) };
    let linear = options.linear_model(model.regressor());
    let records = SourceRecords::new(model.regressor(), logs, &options.preparation())?;
    let joints = Observation::of_records(&linear, &records, None)?.joints(|_| true);
    Ok(Some(nominal_residuals(&linear, &joints, &vec![1.0; joints.len()], &nominal).total))
}

/// Judges an estimate by its relative torque error `total` on logs. For an estimate of experiments, this error is the only
/// evidence. `are_new`: none of the logs was fitted ([`crate::fit::validation::is_fitted`]).
///
/// Fails if a log cannot be read.
pub fn validation_verdict(
    model: &Model,
    estimate: &Estimate,
    logs: &[LogSource],
    total: f64,
    are_new: bool,
) -> Result<Verdict, Error> {
    let parameters = model.nominal_parameters();
    let mut evidence =
        Evidence { total: Some(total), is_of_fit: false, ..evidence(estimate, Some(total).filter(|_| are_new)) };
    evidence.prediction.held_out = None;
    let Some(options) = &estimate.options else { return Ok(Verdict::of(&evidence)) };
    let (mut log_check, _) = examine_columns(model, logs, options)?;
    // A log that is too short for a fit can be long enough for a prediction. So the finding "too short" is dropped.
    log_check.findings.retain(|f| !matches!(f.fault, Fault::Short(_)));
    // Contacts are named, and the errors are computed over the other rows.
    let x = values_of(&options.linear_model(model.regressor()), estimate)?;
    let contacts = Contacts::of_prediction(model, &x, logs, options)?;
    let mut options = options;
    evidence.prediction.has_events = !contacts.events.is_empty() || log_check.has_changed_load();
    if !log_check.has_changed_load() {
        log_check.contacts = contacts.sentences(model, logs);
    }
    if contacts.explain() {
        options = &contacts.options;
        evidence.total = Some(contacts.errors[1]);
        evidence.prediction.others = evidence.prediction.others.map(|_| contacts.errors[1]);
    }
    evidence.log_check = Some(&log_check);
    evidence.described = nominal_error(model, options, logs)?;
    evidence.prediction.others_nominal = evidence.described.filter(|_| are_new);
    evidence.nominal_parameters = parameters.as_deref();
    Ok(Verdict::of(&evidence))
}
