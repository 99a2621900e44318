//! How well an estimate predicts logs it was not made from.

use std::path::PathBuf;

use identification::estimate::held_out;
use identification::estimate::residuals::Residuals;
use identification::experiments::record::Record;
use identification::model::linear_model::Model as LinearModel;
use identification::signals::records::{Records, SourceRecords};
use identification::spectrum::validate::validate_motions;
use logs::{ColumnNames, Effort, Log, LogSource};

use crate::error::Error;
use crate::model::{Model, predicts};
use crate::{Estimate, Validation};

/// Hz, of the low-pass on position and torque of motions of a plan, where none is given: twice the cut-off of the
/// equations is where the paper's figure 2 looks.
pub const MOTION_CUTOFF: f64 = 20.0;

/// Predicts logs as those of the estimate were fitted, with its signals and its friction, log by log.
///
/// Empty for an estimate of experiments: [`validate_experiments`] is for that. Fails where a log cannot be read, and
/// where the estimate lacks a parameter.
pub fn predictions(model: &Model, estimate: &Estimate, logs: &[LogSource]) -> Result<Vec<(String, Residuals)>, Error> {
    let Some(options) = &estimate.options else { return Ok(Vec::new()) };
    let couplings = options.transmission.coupled();
    let linear = LinearModel::new(model.regressor(), &options.friction, &couplings);
    let x = linear.parameters.iter().map(|p| predicts(estimate, &p.id)).collect::<Result<Vec<f64>, Error>>()?;
    let predict = |log: &LogSource| {
        let records = SourceRecords::new(model.regressor(), std::slice::from_ref(log), &options.preparation())?;
        Ok((log.name(), held_out::validate(&linear, &x, &records)?))
    };
    logs.iter().map(predict).collect()
}

/// The torques of a log over time, filtered as the estimate was made: rows of n joints, N m (N).
pub struct TorqueSeries {
    /// The log, as the user named it.
    pub name: String,
    /// s, one an instant.
    pub t: Vec<f64>,
    /// tau, an instant a row.
    pub measured: Vec<f64>,
    /// Y X and friction, an instant a row; not a number where a row of a joint does not count, at standstill.
    pub predicted: Vec<f64>,
}

/// The torques that an estimate from samples predicts, log by log.
///
/// Fails where a log cannot be read, where the estimate lacks a parameter, and for an estimate of experiments.
pub fn predicted_torques(model: &Model, estimate: &Estimate, logs: &[LogSource]) -> Result<Vec<TorqueSeries>, Error> {
    let Some(options) = &estimate.options else {
        return Err(Error::new(
            "an estimate of experiments has no filter for other logs: validate predicts its motions",
        ));
    };
    let couplings = options.transmission.coupled();
    let linear = LinearModel::new(model.regressor(), &options.friction, &couplings);
    let x = linear.parameters.iter().map(|p| predicts(estimate, &p.id)).collect::<Result<Vec<f64>, Error>>()?;
    let predict = |log: &LogSource| {
        let mut series = TorqueSeries { name: log.name(), t: Vec::new(), measured: Vec::new(), predicted: Vec::new() };
        let records = SourceRecords::new(model.regressor(), std::slice::from_ref(log), &options.preparation())?;
        records.each(&mut |states| {
            let before = series.measured.len();
            series.t.extend(&states.t);
            series.measured.extend(&states.tau);
            series.predicted.resize(before + states.tau.len(), f64::NAN);
            linear.residuals(states, &x, |r, j, residual| {
                let entry = r * states.n + j;
                series.predicted[before + entry] = states.tau[entry] - residual;
            });
        })?;
        Ok(series)
    };
    logs.iter().map(predict).collect()
}

/// Predicts logs with an estimate from samples.
///
/// Fails where a log cannot be read or does not fit the robot.
pub fn validate(model: &Model, estimate: &Estimate, logs: &[LogSource]) -> Result<Validation, Error> {
    let found = predictions(model, estimate, logs)?;
    let (reference, method) = (model.reference.clone(), &estimate.method);
    Ok(Validation::of_logs(reference, method, estimate.cutoff, model.regressor(), &found))
}

/// Predicts motions with an estimate of experiments; friction is fitted to the motions, since the paper's rows
/// estimate none. `gains`: of drives, by coordinate, over those of the estimate, N m/A. `cutoff`: Hz.
///
/// Fails where a log cannot be read, or is too short or too slow for the low-pass.
pub fn validate_experiments(
    model: &Model,
    estimate: &Estimate,
    motions: &[PathBuf],
    gains: &[(String, f64)],
    cutoff: f64,
) -> Result<Validation, Error> {
    let regressor = model.regressor();
    let mut records = Vec::new();
    let mut currents = false;
    for path in motions {
        let (log, _) = Log::read(path, regressor.coordinates(), &ColumnNames::default())?;
        currents |= log.effort_is == Effort::Current;
        records.push((path.display().to_string(), Record::from_log(&log)?));
    }
    let mut gain = vec![1.0; regressor.coordinates().len()];
    if currents {
        let found = model.estimated_gains(estimate).into_iter().zip(model.drive_gains());
        gain = found.map(|(estimated, of_file)| estimated.or(of_file).unwrap_or(1.0)).collect();
        for (coordinate, given) in gains {
            gain[model.coordinate(coordinate)?] = *given;
        }
    }
    let parameters = model.values(estimate)?;
    let method = &estimate.method;
    Ok(validate_motions(&model.reference, method, regressor, &parameters, &gain, &records, cutoff)?)
}
