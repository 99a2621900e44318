//! Whether to trust an estimate: one of experiments by itself, one of logs by other logs.

use identification::estimate::described::described_residuals;
use identification::estimate::options::Options;
use identification::estimate::passport::finding::Fault;
use identification::estimate::verdict::Evidence;
use identification::rows::observation::Observation;
use identification::signals::records::SourceRecords;
use linear_model::linear_model::Model as LinearModel;
use logs::LogSource;

pub use identification::estimate::verdict::{Trust, Verdict};

use crate::Estimate;
use crate::doctor::examine;
use crate::error::Error;
use crate::model::Model;

/// Whether to trust an estimate by its own evidence alone. [`crate::samples::Identification::judge`] has more evidence.
pub fn estimate_verdict(estimate: &Estimate) -> Verdict {
    predicted_verdict(estimate, None)
}

/// The same with the error on motions that it was not made from, where there are some.
pub fn predicted_verdict(estimate: &Estimate, predicted: Option<f64>) -> Verdict {
    Verdict::of(&Evidence {
        estimate,
        passport: None,
        described: None,
        total: estimate.total,
        held_out: estimate.cross_validation,
        predicted,
        bodies: None,
    })
}

/// Whether to trust an estimate by the logs it was fitted to, read once more.
///
/// Fails where a log cannot be read.
pub fn fitted_verdict(model: &Model, estimate: &Estimate, logs: &[LogSource]) -> Result<Verdict, Error> {
    let Some(options) = &estimate.options else { return Ok(estimate_verdict(estimate)) };
    let passport = examine(model, logs, options)?;
    Ok(Verdict::of(&Evidence {
        estimate,
        passport: Some(&passport),
        described: described(model, options, logs)?,
        total: estimate.total,
        held_out: estimate.cross_validation,
        predicted: None,
        bodies: None,
    }))
}

/// Error of the description with fitted friction; `None` where it has no inertials.
fn described(model: &Model, options: &Options, logs: &[LogSource]) -> Result<Option<f64>, Error> {
    let Some(described) = model.described_parameters() else { return Ok(None) };
    let couplings = options.transmission.coupled();
    let linear = LinearModel::new(model.regressor(), &options.friction, &couplings);
    let records = SourceRecords::new(model.regressor(), logs, &options.preparation())?;
    let joints = Observation::of_records(&linear, &records, None)?.joints(|_| true);
    Ok(Some(described_residuals(&linear, &joints, &vec![1.0; joints.len()], &described).total))
}

/// Whether to trust an estimate, by how well it predicts logs, `total`. For an estimate of experiments `total` is the
/// only evidence. `are_new`: it was not made from any of them, as [`crate::validation::is_fitted`] tells.
///
/// Fails where a log cannot be read.
pub fn validation_verdict(
    model: &Model,
    estimate: &Estimate,
    logs: &[LogSource],
    total: f64,
    are_new: bool,
) -> Result<Verdict, Error> {
    let mut evidence = Evidence {
        estimate,
        passport: None,
        described: None,
        total,
        held_out: None,
        predicted: Some(total).filter(|_| are_new),
        bodies: None,
    };
    let Some(options) = &estimate.options else { return Ok(Verdict::of(&evidence)) };
    let mut passport = examine(model, logs, options)?;
    // A short log is long enough for a prediction.
    passport.findings.retain(|f| !matches!(f.fault, Fault::Short(_)));
    evidence.passport = Some(&passport);
    evidence.described = described(model, options, logs)?;
    Ok(Verdict::of(&evidence))
}
