//! Identifies a robot from logs and makes an `Estimate` (parameters with standard deviations and residuals).
//!
//! `estimators::weighted` solves the least-squares problem; for robust weights, `estimators::huber` then repeats the fit with
//! new weights of the rows. This module adds standard deviations, errors of cross-validation and remarks.

use linear_model::linear_model::Model;
use linear_model::parameter::Parameter;
use linear_model::regressor::Regressor;
use logs::{Error, Log};
use nalgebra::DMatrix;
use numerics::least_squares::Solution;
use numerics::triangle::Triangle;

use crate::estimate::artefact::Estimate;
use crate::estimate::autocorrelation::Autocorrelation;
use crate::estimate::claims::hypotheses::FitPoint;
use crate::estimate::cross_talk::{CrossTalk, CrossTalkSums};
use crate::estimate::directions::directions;
use crate::estimate::held_out::{cross_validate_by_part, residuals};
use crate::estimate::identified::{Deviations, Identified};
use crate::estimate::options::Options;
use crate::estimate::remarks::{little_motion, remarks, weak};
use crate::estimate::residuals::JointResidual;
use crate::estimators::huber::{Reweighted, Robust, reweighted};
use crate::estimators::replicate_deviation::{ReplicateDeviation, replicate_deviation, state_bands, white_deviation};
use crate::estimators::weighted::fit;
use crate::rows::observation::Observation;
use crate::rows::residual_sums::residual_sums;
use crate::signals::preparation::{of_log, states};
use crate::signals::records::Records;

/// Identifies a robot from one log.
///
/// Fails if the log does not match the robot, the transmission or the signal options. Parameters that the data do not
/// determine are no failure; they get the status not identifiable.
pub fn identify(regressor: &dyn Regressor, log: &Log, options: &Options) -> Result<Estimate, Error> {
    identify_all(regressor, std::slice::from_ref(log), options)
}

/// Identifies a robot from several logs in one fit.
pub(crate) fn identify_all(regressor: &dyn Regressor, logs: &[Log], options: &Options) -> Result<Estimate, Error> {
    let fit = Fit::of(regressor, logs, options)?;
    Ok(fit.estimate)
}

/// Error message if no joint has a row that can be used.
pub const NO_JOINT_MOVES: &str = "every joint stands still all the time, and friction holds it there: log motions, or omit friction for torques of poses at rest";

/// An estimate, with the rows and the solution from which it was made.
pub struct Fit {
    /// The estimate: parameters, standard deviations, residuals and remarks.
    pub estimate: Estimate,
    /// The rows W and torques, compressed to triangles (R of QR): one triangle per block of the record and joint.
    pub observation: Observation,
    /// The least-squares solution.
    pub solution: Solution,
    /// Weight of the rows of each joint: 1 / standard deviation of the joint's residual; 1 for ordinary least squares (OLS).
    pub weights: Vec<f64>,
    /// Robust weights of rows, which depend on the residual of each row; `None` if all rows have equal weight.
    pub robust: Option<Robust>,
    /// Standard deviations of the parameters, for white noise and for several kinds of correlated errors.
    pub deviation: ReplicateDeviation,
}

impl Fit {
    /// The solution and the weights of the fit, as input for further sums over the rows.
    pub fn point(&self) -> FitPoint<'_> {
        FitPoint { x: &self.solution.x, weights: &self.weights, robust: self.robust.as_ref() }
    }

    /// The parameters and the robust weights of rows; `None` without robust weights.
    pub fn of_rows(&self) -> Option<(&[f64], &Robust)> {
        Some((&self.solution.x, self.robust.as_ref()?))
    }

    /// Fits logs that are in memory. Fails for the reasons of [`identify`].
    pub fn of(regressor: &dyn Regressor, logs: &[Log], options: &Options) -> Result<Fit, Error> {
        let preparation = options.preparation().for_logs(logs)?;
        let mut records = Vec::new();
        for (number, log) in logs.iter().enumerate() {
            records.extend(of_log(number, states(regressor, log, &preparation)?));
        }
        let names = logs.iter().map(|l| l.name.clone()).collect();
        Fit::of_records(regressor, records.as_slice(), names, options)
    }

    /// Fits records (prepared segments of logs). `logs`: names of the log files, which are stored in the estimate.
    ///
    /// Fails if no joint has a used row, or if a record cannot be read.
    pub fn of_records<R: Records + ?Sized>(
        regressor: &dyn Regressor,
        records: &R,
        logs: Vec<String>,
        options: &Options,
    ) -> Result<Fit, Error> {
        let model = options.linear_model(regressor);
        let observation = Observation::of_records(&model, records, None)?;
        Fit::of_observation(regressor, records, observation, logs, options)
    }

    /// Fits records, if their rows `observation` are already computed for the model of `options`. `logs`: names of the log
    /// files.
    ///
    /// Fails if no joint has a used row, or if a record cannot be read.
    pub fn of_observation<R: Records + ?Sized>(
        regressor: &dyn Regressor,
        records: &R,
        mut observation: Observation,
        logs: Vec<String>,
        options: &Options,
    ) -> Result<Fit, Error> {
        let model = options.linear_model(regressor);
        let mut joints = observation.joints(|_| true);
        if joints.iter().all(|t| t.rows == 0) {
            return Err(Error::new(NO_JOINT_MOVES));
        }
        let (mut solution, mut weights) = fit(&joints, options.weights);
        // Robust fit: each loss function (Huber, then Tukey) starts from the previous solution.
        let mut by_rows: Option<Reweighted> = None;
        for &loss in options.weights.losses() {
            let start = by_rows.as_ref().map_or(&solution, |found| &found.solution);
            by_rows = Some(reweighted(&model, records, start, loss)?);
        }
        if let Some(found) = &mut by_rows {
            observation.parts = std::mem::take(&mut found.observation.parts);
            joints = observation.joints(|_| true);
            (solution, weights) = (found.solution.clone(), found.weights.clone());
        }
        // Statistics of the residuals need the solution. So these statistics need another pass over the records.
        let bands = state_bands(&model, &observation, &weights, by_rows.as_ref());
        let robust = by_rows.as_ref().map(|found| found.rows.clone());
        let talk = CrossTalkSums::new(model.n(), robust.clone());
        let sums = (bands, (talk, Autocorrelation::new(model.n(), robust.clone())));
        let (bands, (talk, autocorrelation)) = residual_sums(&model, records, &solution.x, sums)?;
        let deviation = replicate_deviation(&model, &observation, &solution, &weights, by_rows.as_ref(), bands);
        let sigma = deviation.sigma();
        let mut estimate = report(&model, &joints, &observation, &solution, &sigma);
        estimate.remarks.extend(by_rows.iter().map(|found| outliers(found, regressor.coordinates())));
        estimate.remarks.extend(coupled(&estimate.joints, &talk.cross_talk()));
        let (held_out, tenths) = cross_validate_by_part(&model, &observation, options.weights);
        estimate.cross_validation = Some(held_out.total);
        for (joint, out) in estimate.joints.iter_mut().zip(held_out.joints) {
            joint.held_out = Some(out.relative);
        }
        estimate.tenths = tenths;
        estimate.directions = directions(&model, &joints, &weights, &solution, estimate.discount());
        for (j, joint) in estimate.joints.iter_mut().enumerate() {
            joint.memory = autocorrelation.memory(j);
        }
        of_signals(&mut estimate, &observation, options);
        estimate.model = options.model.clone();
        estimate.method = options.weights.method().into();
        estimate.logs = logs;
        if options.covariance {
            estimate.covariance = with_deviations(&solution.inverse, &sigma);
        }
        Ok(Fit { estimate, observation, solution, weights, robust, deviation })
    }
}

/// Covariance matrix sigma_i sigma_j rho_ij from the standard deviations `sigma`, p x p, row by row.
///
/// The correlations are rho_ij = a_ij / sqrt(a_ii a_jj). `a`: the covariance for white noise, up to a common factor. Entries
/// with a_ii = 0 are zero.
pub fn with_deviations(a: &DMatrix<f64>, sigma: &[f64]) -> Vec<Vec<f64>> {
    let share = |c: usize| if a[(c, c)] > 0.0 { sigma[c] / a[(c, c)].sqrt() } else { 0.0 };
    let entry = |i: usize, j: usize| share(i) * share(j) * a[(i, j)];
    (0..sigma.len()).map(|i| (0..sigma.len()).map(|j| entry(i, j)).collect()).collect()
}

/// Adds to the estimate: the bandwidth of each joint, Hz (95 % of the energy of the velocity is below this frequency); the
/// cut-off, Hz; and the options with the cut-off that was used.
pub fn of_signals(estimate: &mut Estimate, observation: &Observation, options: &Options) {
    for (joint, &f95) in estimate.joints.iter_mut().zip(&observation.f95) {
        joint.f95 = (f95 > 0.0).then_some(f95);
    }
    let mut used = options.clone();
    if options.signal.order > 0 && options.signal.cutoff.is_none() {
        estimate.remarks.extend(without_frequency(&estimate.joints));
        used.signal.cutoff = Some(observation.cutoff);
    }
    estimate.options = Some(used);
    estimate.cutoff = Some(observation.cutoff).filter(|hz| *hz > 0.0);
}

/// A sentence with the share of outliers of each joint: rows with a residual beyond the bound of the robust loss.
fn outliers(found: &Reweighted, coordinates: &[String]) -> String {
    let share = |(name, share): (&String, &f64)| format!("{name} {:.1} %", 100.0 * share);
    let shares: Vec<String> = coordinates.iter().zip(&found.outliers).map(share).collect();
    format!("rows that count {}, in the residuals too: {}", found.rows.loss.beyond(), shares.join(", "))
}

/// A sentence on joints that move too little to be used for the choice of the cut-off frequency; `None` if there are no such
/// joints.
fn without_frequency(joints: &[JointResidual]) -> Option<String> {
    let names: Vec<&str> = joints.iter().filter(|j| j.f95.is_none()).map(|j| j.coordinate.as_str()).collect();
    match names.len() {
        0 => None,
        all if all == joints.len() => Some("no joint moves: the cut-off is a fifth of the sampling rate".into()),
        _ => Some(format!(
            "the cut-off follows from the other joints: {} hardly move compared with them, and show the frequency of noise",
            names.join(", ")
        )),
    }
}

/// A remark reports cross talk if the motion of another joint explains more than this share of the squared residual of a joint.
/// Robots with a complete model of the transmission stay below 0.25; a TX40 whose model lacks the coupling of the wrist has
/// 0.84.
const LARGE_CROSS_TALK_SHARE: f64 = 0.5;
/// Cross talk is not reported if the residual of the joint, relative to its torque, is below this value.
const SMALLEST_CROSS_TALK_RESIDUAL: f64 = 0.02;

/// Sentences on joints with cross talk: the motion of another joint explains much of the residual of such a joint. `talk`: one
/// entry per joint.
fn coupled(joints: &[JointResidual], talk: &[CrossTalk]) -> Vec<String> {
    let loud = talk
        .iter()
        .filter(|t| t.share > LARGE_CROSS_TALK_SHARE && joints[t.joint].relative > SMALLEST_CROSS_TALK_RESIDUAL);
    let sentence = |t: &CrossTalk| {
        let (joint, of) = (&joints[t.joint], &joints[t.of].coordinate);
        format!(
            "the residual of the torque of {} ({:.0} % of the torque) moves with {of}, which explains {:.0} % of it: a motor \
             turns with both joints, and the model lacks its inertia and friction (transmission: couplings)",
            joint.coordinate,
            100.0 * joint.relative,
            100.0 * t.share
        )
    };
    loud.map(sentence).collect()
}

/// Makes an estimate from a solution: values, standard deviations, residuals and remarks. `joints`: triangles (R of QR) of
/// the rows, one per joint; `sigma`: standard deviations of the parameters.
pub fn report(
    model: &Model,
    joints: &[Triangle],
    observation: &Observation,
    solution: &Solution,
    sigma: &[f64],
) -> Estimate {
    let white = white_deviation(solution);
    let still = little_motion(model, observation);
    // A base parameter is not identifiable if its sigma exceeds the largest torque of the log (compared as numbers in SI
    // units). In a motion of unit size, an error of this parameter would then change a torque by more than the largest torque.
    let most = observation.effort.iter().fold(0.0, |most: f64, effort| most.max(*effort));
    let base = model.regressor.parameters().len();
    let is_beyond =
        |c: usize| c < base && solution.determined[c] && most > 0.0 && sigma.get(c).is_some_and(|s| *s > most);
    // A parameter that the rows do not determine has no value. For such a parameter, the entry of the solution x is used only
    // for predictions of torques.
    let parameter = |(c, parameter): (usize, &Parameter)| {
        let (id, unit) = (parameter.id.clone(), parameter.unit());
        if !solution.determined[c] || is_beyond(c) {
            return Identified::unidentifiable(id, unit, solution.x[c]);
        }
        let (sigma, white) = (sigma[c], Some(white[c]));
        let deviations = Deviations { sigma, white, weak: weak(parameter, &still) };
        Identified::new(id, unit, solution.x[c], deviations)
    };
    let residuals = residuals(model, joints, &solution.x);
    Estimate {
        parameters: model.parameters.iter().enumerate().map(parameter).collect(),
        joints: residuals.joints,
        total: Some(residuals.total),
        condition_number: Some(solution.condition_number),
        rank: solution.rank.saturating_sub((0..model.p()).filter(|c| is_beyond(*c)).count()),
        rows: joints.iter().map(|t| t.rows).sum(),
        remarks: remarks(model, observation, solution),
        ..Estimate::default()
    }
}
