//! Tests how well an estimate predicts logs that were not fitted.
//!
//! tau: measured torques; W: regression matrix; X: parameters of the estimate. The relative error of a prediction is |tau - W
//! X| / |tau|. An estimate of experiments (from the logs of a plan) has no friction, so friction is fitted to the predicted
//! motion.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use experiments::motion::record::Record;
use gate::source::Source;
use identification::estimate::held_out;
use identification::estimate::log_check::visited::VisitedStates;
use identification::estimate::nominal_prediction::nominal_residuals;
use identification::estimate::options::Options;
use identification::estimate::residuals::Residuals;
use identification::estimators::weighted::{Weights, fit};
use identification::plot_data::series::series;
use identification::rows::observation::Observation;
use identification::signals::records::SourceRecords;
use identification::spectrum::validate::validate_motions;
use linear_model::linear_model::Model as LinearModel;
use logs::{ColumnNames, Log, LogSource};
use numerics::triangle::Triangle;

pub use identification::estimate::validation::Validation;
pub use identification::plot_data::PlotData;
pub use identification::plot_data::series::{TorqueSeries, series_to_csv, series_to_parquet};

use crate::describe::model::{Model, predicts};
use crate::error::Error;
use crate::fit::contact::Contacts;
pub use crate::request::ValidateRequest;
use crate::request::{MOTION_CUTOFF, Request};
use identification::estimate::artefact::Estimate;

/// The prediction of a log by an estimate.
pub struct Predicted {
    /// The name of the log.
    pub log: String,
    /// Residuals of the predicted torques.
    pub residuals: Residuals,
    /// Relative error |tau - W X| / |tau| of the description with fitted friction; `None` if the description has no inertial
    /// parameters.
    pub described: Option<f64>,
    /// The relative error expected from the covariance of the parameters; `None` if the covariance is not known.
    pub unsure: Option<f64>,
    /// Smallest possible relative error |tau - W X| / |tau|, which is reached by parameters fitted to this log alone.
    pub(crate) least: f64,
    /// A sentence on each interval in which the residual is an outlier, such as a contact.
    pub contacts: Vec<String>,
    /// Relative error |tau - W X| / |tau|. If contacts explain the error, their rows are left out here and in all fields below.
    pub error: f64,
    /// The regression rows of the log, as one triangular matrix (R of a QR decomposition) per joint.
    pub(crate) joints: Vec<Triangle>,
    /// The states (positions, velocities) that the log covers.
    pub visited: VisitedStates,
}

impl Predicted {
    /// The part of the relative error that other parameter values could remove.
    pub(crate) fn by_parameters(&self) -> f64 {
        held_out::of_parameters(self.error, self.least)
    }
}

/// Predicts each log, with the signal options and friction terms of the estimate's fit.
///
/// Empty for an estimate of experiments, for which [`validate_experiments`] is used instead. `covariance`: covariance of the
/// estimate's parameters, if known. Fails if a log cannot be read, or if the estimate lacks a parameter.
pub fn predictions(
    model: &Model,
    estimate: &Estimate,
    covariance: Option<&[Vec<f64>]>,
    logs: &[LogSource],
) -> Result<Vec<Predicted>, Error> {
    let Some(options) = &estimate.options else { return Ok(Vec::new()) };
    let linear = options.linear_model(model.regressor());
    let x = values_of(&linear, estimate)?;
    let described = model.nominal_parameters();
    let predict = |log: &LogSource| {
        let logs = std::slice::from_ref(log);
        let read = |options: &Options| SourceRecords::new(model.regressor(), logs, &options.preparation());
        let rows = |records: &SourceRecords| -> Result<Vec<Triangle>, Error> {
            Ok(Observation::of_records(&linear, records, None)?.joints(|_| true))
        };
        let records = read(options)?;
        let mut joints = rows(&records)?;
        let residuals = held_out::residuals(&linear, &joints, &x);
        let contacts = Contacts::of_prediction(model, &x, logs, options)?;
        // `residuals` contains all rows. If contacts explain the residual, the errors below are computed without the rows of
        // contact.
        if contacts.explain() {
            joints = rows(&read(&contacts.options)?)?;
        }
        let of_description = |x: &Vec<f64>| nominal_residuals(&linear, &joints, &vec![1.0; joints.len()], x).total;
        Ok(Predicted {
            log: log.name(),
            residuals,
            contacts: contacts.sentences(model, logs),
            error: if contacts.explain() { contacts.errors[1] } else { contacts.errors[0] },
            described: described.as_ref().map(of_description),
            // The error that remains if the parameters are fitted to this log itself: noise and errors of the model.
            least: held_out::residuals(&linear, &joints, &fit(&joints, Weights::None).0.x).total,
            unsure: covariance.map(|covariance| held_out::unsure(&linear, &joints, covariance)),
            visited: VisitedStates::of_records(&records, model.regressor().coordinates().len())?,
            joints,
        })
    };
    logs.iter().map(predict).collect()
}

/// Plot data with measured and predicted torques of logs, joint by joint; `None` for an estimate of experiments.
///
/// Fails if a log cannot be read, or if the estimate lacks a parameter.
pub fn plot_data(model: &Model, estimate: &Estimate, logs: &[LogSource]) -> Result<Option<PlotData>, Error> {
    let Some(options) = &estimate.options else { return Ok(None) };
    let linear = options.linear_model(model.regressor());
    let x = values_of(&linear, estimate)?;
    let described = model.nominal_parameters();
    Ok(Some(identification::plot_data::plot_data(&linear, &x, described.as_deref(), options, logs)?))
}

/// The measured and predicted torques of logs, sample by sample.
///
/// Fails for an estimate of experiments, if a log cannot be read, or if the estimate lacks a parameter.
pub fn predicted_torques(model: &Model, estimate: &Estimate, logs: &[LogSource]) -> Result<Vec<TorqueSeries>, Error> {
    let Some(options) = &estimate.options else {
        return Err(Error::new("an estimate of experiments has no series of samples; one of logs has"));
    };
    let linear = options.linear_model(model.regressor());
    let x = values_of(&linear, estimate)?;
    Ok(series(&linear, &x, options, logs)?)
}

/// For each column of the regression matrix, the parameter value with which torques are predicted.
pub(crate) fn values_of(linear: &LinearModel, estimate: &Estimate) -> Result<Vec<f64>, Error> {
    linear.parameters.iter().map(|p| predicts(estimate, &p.id)).collect()
}

/// Whether the estimate was fitted to the log `log`: one of the fitted logs is the same file, or a file with the same bytes.
pub fn is_fitted(estimate: &Estimate, log: &Path) -> bool {
    let place = |name: &Path| std::fs::canonicalize(name).unwrap_or_else(|_| name.to_path_buf());
    let is_log = |fitted: &Path| place(fitted) == place(log) || is_copy(fitted, log).unwrap_or(false);
    estimate.logs.iter().any(|fitted| is_log(Path::new(fitted)))
}

/// Whether two files have the same bytes.
fn is_copy(a: &Path, b: &Path) -> std::io::Result<bool> {
    let (of_a, of_b) = (std::fs::metadata(a)?, std::fs::metadata(b)?);
    // Pipes must not be opened here, because a pipe can be read only once.
    if !of_a.is_file() || !of_b.is_file() || of_a.len() != of_b.len() {
        return Ok(false);
    }
    let (mut a, mut b) = (BufReader::new(Source::open(a)?), BufReader::new(Source::open(b)?));
    loop {
        let (left, right) = (a.fill_buf()?, b.fill_buf()?);
        let count = left.len().min(right.len());
        if count == 0 || left[..count] != right[..count] {
            return Ok(left.is_empty() && right.is_empty());
        }
        a.consume(count);
        b.consume(count);
    }
}

/// Predicts logs with an estimate that was fitted to samples. Returns the errors as the content of a result file.
///
/// Fails if a log cannot be read or does not fit the robot.
pub fn validate(model: &Model, estimate: &Estimate, logs: &[LogSource]) -> Result<Validation, Error> {
    let found = predictions(model, estimate, None, logs)?.into_iter().map(|p| (p.log, p.residuals)).collect::<Vec<_>>();
    let (reference, method) = (model.reference.clone(), &estimate.method);
    Ok(Validation::of_logs(reference, method, estimate.cutoff, model.regressor(), &found))
}

/// Predicts motions with an estimate of plan experiments. Friction is fitted to the motions, since the rows of Sp [Vandanjon,
/// Gautier, Desbats 1995] contain no friction. Drive gains in the request replace the gains of the estimate.
///
/// Fails if a log cannot be read, or is too short or too slow for the low-pass.
pub fn validate_experiments(
    model: &Model,
    estimate: &Estimate,
    motions: &[PathBuf],
    request: &ValidateRequest,
) -> Result<Validation, Error> {
    request.check()?;
    let cutoff = request.cutoff.unwrap_or(MOTION_CUTOFF);
    let regressor = model.regressor();
    let mut records = Vec::new();
    let mut currents = false;
    for path in motions {
        let (log, _) = Log::read(path, regressor.coordinates(), &ColumnNames::default())?;
        currents |= log.effort_is.needs_gains();
        records.push((path.display().to_string(), Record::from_log(&log)?));
    }
    let mut gain = vec![1.0; regressor.coordinates().len()];
    if currents {
        let found = model.estimated_gains(estimate).into_iter().zip(model.drive_gains());
        gain = found.map(|(estimated, of_file)| estimated.or(of_file).unwrap_or(1.0)).collect();
        model.give_gains(&mut gain, &request.gain)?;
    }
    let parameters = model.values(estimate)?;
    let method = &estimate.method;
    Ok(validate_motions(&model.reference, method, regressor, &parameters, &gain, &records, cutoff)?)
}
