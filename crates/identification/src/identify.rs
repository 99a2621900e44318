//! From logs to an estimate: the one way in.
//!
//! OLS weighs all rows alike; WLS multiplies the rows of joint j by 1 / std(residual of joint j),
//! three times over [Gautier 1997]. Both come out of the same triangles. The robust weights (`huber`)
//! need the rows again.

use serde::{Deserialize, Serialize};

use crate::columns::ColumnNames;
use crate::cross_talk::{CrossTalk, cross_talk};
use crate::cutoff::FrequencyContent;
use crate::estimate::{Estimate, Identified, JointResidual, Status};
use crate::friction::FrictionTerm;
use crate::huber::reweighted;
use crate::least_squares::{Solution, solve};
use crate::log::Log;
use crate::observation::{Model, Observation, weighted};
use crate::records::Records;
use crate::signal::{Signal, States};
use crate::transmission::Transmission;
use crate::triangle::Triangle;
use crate::validation::cross_validate;
use crate::{Error, Regressor};

/// How an identification is done; every part has a default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// Name of the robot, for the report.
    pub model: String,
    pub columns: ColumnNames,
    pub transmission: Transmission,
    pub signal: Signal,
    pub friction: Vec<FrictionTerm>,
    pub weights: Weights,
    /// Whether the estimate carries its covariance.
    pub covariance: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            model: String::new(),
            columns: ColumnNames::default(),
            transmission: Transmission::default(),
            signal: Signal::default(),
            friction: FrictionTerm::STANDARD.to_vec(),
            weights: Weights::Joint,
            covariance: false,
        }
    }
}

impl Options {
    /// Reads options from a YAML file; what it does not name keeps its default.
    pub fn read(path: &std::path::Path) -> Result<Options, Error> {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|e| Error::at(&file, 0, e.to_string()))?;
        serde_yaml::from_str(&text).map_err(|e| Error::at(&file, 0, e.to_string()))
    }
}

/// What the rows weigh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Weights {
    /// All alike: ordinary least squares.
    None,
    /// By the standard deviation of the joint's residual: weighted least squares.
    Joint,
    /// As `Joint`, and rows that do not fit count less: robust regression.
    Huber,
}

/// Reweightings of WLS.
const REWEIGHTINGS: usize = 3;

/// Identifies a robot from one log.
///
/// Fails when the log does not fit the robot, the transmission or the signal options; parameters
/// that the data do not determine are a status, not a failure.
pub fn identify(regressor: &dyn Regressor, log: &Log, options: &Options) -> Result<Estimate, Error> {
    identify_all(regressor, std::slice::from_ref(log), options)
}

/// Identifies a robot from several logs together.
pub fn identify_all(regressor: &dyn Regressor, logs: &[Log], options: &Options) -> Result<Estimate, Error> {
    let fit = Fit::of(regressor, logs, options)?;
    Ok(fit.estimate)
}

/// An estimate with everything it came from.
pub struct Fit {
    pub estimate: Estimate,
    pub observation: Observation,
    pub solution: Solution,
    /// 1 / standard deviation of the residual, a joint; ones for OLS.
    pub weights: Vec<f64>,
}

impl Fit {
    /// From logs held in memory.
    pub fn of(regressor: &dyn Regressor, logs: &[Log], options: &Options) -> Result<Fit, Error> {
        let mut records = Vec::new();
        for log in logs {
            records.extend(states(regressor, log, options)?);
        }
        let names = logs.iter().map(|l| l.name.clone()).collect();
        Fit::of_records(regressor, records.as_slice(), names, options)
    }

    /// From records; `logs` are their names.
    ///
    /// Fails when there is none, or when they cannot be read.
    pub fn of_records<R: Records + ?Sized>(
        regressor: &dyn Regressor,
        records: &R,
        logs: Vec<String>,
        options: &Options,
    ) -> Result<Fit, Error> {
        let couplings = options.transmission.coupled();
        let model = Model::new(regressor, &options.friction, &couplings);
        let mut observation = Observation::of_records(&model, records, None)?;
        let mut joints = observation.joints(|_| true);
        if joints.iter().all(|t| t.rows == 0) {
            return Err(Error::new(
                "every joint stands still all the time, and friction holds it there: log motions, or leave friction \
                 out of the model for torques of poses at rest",
            ));
        }
        let (mut solution, mut weights) = fit(&joints, options.weights);
        let (mut sigma, mut less) = (None, None);
        if options.weights == Weights::Huber {
            let mut found = reweighted(&model, records, &solution)?;
            let influence = |j: usize, e: f64| found.influence(j, e);
            let by = crate::robust::robust(&model, records, &found.solution, &found.weights, &influence)?;
            sigma = Some(by.sigma);
            observation.parts = std::mem::take(&mut found.observation.parts);
            joints = observation.joints(|_| true);
            (solution, weights, less) = (found.solution, found.weights, Some(found.outliers));
        }
        let mut estimate = report(&model, &joints, &observation, &solution);
        let sigma = match sigma {
            Some(sigma) => sigma,
            None => crate::robust::robust(&model, records, &solution, &weights, &|_, e| e)?.sigma,
        };
        widen(&mut estimate, &sigma);
        if let Some(less) = &less {
            let share = |(name, share): (&String, &f64)| format!("{name} {:.1} %", 100.0 * share);
            let shares: Vec<String> = regressor.coordinates().iter().zip(less).map(share).collect();
            let shares = shares.join(", ");
            estimate.remarks.push(format!("rows that count less than fully, in the residuals too: {shares}"));
        }
        estimate.remarks.extend(coupled(&estimate.joints, &cross_talk(&model, records, &solution.x)?));
        let still = crate::remark::little_motion(&model, &observation);
        for (c, parameter) in estimate.parameters.iter_mut().enumerate() {
            if parameter.status == Status::Identified && crate::remark::weak(&model, &still, c) {
                parameter.status = Status::Weak;
            }
        }
        for p in estimate.parameters.iter().filter(|p| p.unit.contains("s/") && p.name.starts_with("FV")) {
            let sigma = p.sigma.unwrap_or(f64::INFINITY).max(p.robust_sigma.unwrap_or(0.0));
            if p.value.is_some_and(|value| value < -3.0 * sigma) {
                estimate.remarks.push(format!(
                    "{} is negative, and friction cannot drive: another law of friction, or the sign, the unit or the \
                     saturation of that joint's torque",
                    p.name
                ));
            }
        }
        let held_out = cross_validate(&model, &observation, options.weights);
        estimate.cross_validation = Some(held_out.total);
        for (joint, out) in estimate.joints.iter_mut().zip(held_out.joints) {
            joint.held_out = Some(out.relative);
        }
        for (joint, &f95) in estimate.joints.iter_mut().zip(&observation.f95) {
            joint.f95 = Some(f95);
        }
        estimate.model = options.model.clone();
        estimate.method = match options.weights {
            Weights::None => "ordinary least squares".into(),
            Weights::Joint => "least squares weighted by joint".into(),
            Weights::Huber => "robust least squares (Huber), weighted by joint".into(),
        };
        estimate.logs = logs;
        let mut used = options.clone();
        if used.signal.order > 0 {
            used.signal.cutoff.get_or_insert(observation.cutoff);
        }
        estimate.options = Some(used);
        estimate.cutoff = observation.cutoff;
        if options.covariance {
            let row = |i: usize| (0..model.p()).map(|j| solution.variance * solution.inverse[(i, j)]).collect();
            estimate.covariance = (0..model.p()).map(row).collect();
        }
        Ok(Fit { estimate, observation, solution, weights })
    }
}

/// Of a joint's residual, and a joint's residual of its torque, above which another joint's motion in it is worth a
/// sentence. Measured robots whose transmission is known stay below 0.25 of the first; a TX40 without the coupling
/// of its wrist has 0.84.
const TALK: f64 = 0.5;
const TALK_RESIDUAL: f64 = 0.02;

/// Sentences on joints whose residual another joint's motion explains.
fn coupled(joints: &[JointResidual], talk: &[CrossTalk]) -> Vec<String> {
    let loud = talk.iter().filter(|t| t.share > TALK && joints[t.joint].relative > TALK_RESIDUAL);
    let sentence = |t: &CrossTalk| {
        let (joint, of) = (&joints[t.joint], &joints[t.of].coordinate);
        format!(
            "what is left of the torque of {} ({:.0} % of it) moves with {of}, which explains {:.0} % of that: a motor that \
             turns with both joints has inertia and friction that the model does not (transmission: couplings)",
            joint.coordinate,
            100.0 * joint.relative,
            100.0 * t.share
        )
    };
    loud.map(sentence).collect()
}

/// The states of a log, checked against the regressor: one record for each part between gaps of its clock.
pub fn states(regressor: &dyn Regressor, log: &Log, options: &Options) -> Result<Vec<States>, Error> {
    let states = states_or_none(regressor, log, options)?;
    if states.is_empty() {
        let cutoff = options.signal.cutoff.map_or(String::new(), |hz| format!(" (cut-off {hz} Hz)"));
        let message = format!(
            "no sample is left of {} between the ends, the gaps and the window: the filter{cutoff} takes three periods of \
             its cut-off at each end",
            log.len()
        );
        return Err(Error::at(&log.name, 0, message));
    }
    Ok(states)
}

/// As `states`; none where nothing is left.
pub(crate) fn states_or_none(regressor: &dyn Regressor, log: &Log, options: &Options) -> Result<Vec<States>, Error> {
    if log.report.gaps == 0 {
        let states = states_of(regressor, log, options)?;
        return Ok(if states.is_empty() { Vec::new() } else { vec![states] });
    }
    let segments = log.segments();
    // One cut-off for all parts: that of the fastest.
    let mut options = options.clone();
    if options.signal.order > 0 && options.signal.cutoff.is_none() {
        let mut fastest: Option<FrequencyContent> = None;
        for part in &segments {
            let (content, period) = options.transmission.apply(part)?.content(&options.signal)?;
            fastest = Some(match fastest {
                None => content,
                Some(fastest) => fastest.faster(content, period),
            });
        }
        options.signal.cutoff = fastest.map(|f| f.cutoff);
    }
    let mut records = Vec::new();
    for part in &segments {
        let states = states_of(regressor, part, &options)?;
        if !states.is_empty() {
            records.push(states);
        }
    }
    Ok(records)
}

/// No signal of a robot, in no unit; squares of larger numbers leave the range of numbers.
const ABSURD: f64 = 1e100;

/// The states of a log without gaps; none where nothing is left between the ends and the window.
fn states_of(regressor: &dyn Regressor, log: &Log, options: &Options) -> Result<States, Error> {
    let n = regressor.coordinates().len();
    if log.coordinates.len() != n {
        let message = format!("the log has {} joints, the robot has {n} coordinates", log.coordinates.len());
        return Err(Error::at(&log.name, 0, message));
    }
    let mut signal = options.signal.clone();
    if !options.friction.iter().any(|term| term.is_dry()) {
        signal.standstill.get_or_insert(0.0);
    }
    let states = options.transmission.apply(log)?.states(&signal)?;
    let finite = [&states.q, &states.dq, &states.ddq, &states.tau].iter().all(|x| x.iter().all(|x| x.abs() < ABSURD));
    if !finite {
        return Err(Error::at(
            &log.name,
            0,
            "the signals leave the range of numbers; look for absurd values in the log",
        ));
    }
    Ok(states)
}

/// Solves with the weights asked for; also returns the weights.
pub fn fit(joints: &[Triangle], weights: Weights) -> (Solution, Vec<f64>) {
    let mut w = vec![1.0; joints.len()];
    let mut solution = solve(&weighted(joints, &w));
    if weights != Weights::None {
        for _ in 0..REWEIGHTINGS {
            w = joints.iter().map(|joint| inverse_std(joint, &solution.x)).collect();
            solution = solve(&weighted(joints, &w));
        }
    }
    (solution, w)
}

/// 1 / root mean square of the residual; a joint without rows or without residual counts as it is.
fn inverse_std(joint: &Triangle, x: &[f64]) -> f64 {
    let (total, residual) = joint.squares(x);
    // A residual at the level of rounding would give the joint all the weight there is.
    let floor = 1e-20 * total;
    if joint.rows == 0 || total == 0.0 { 1.0 } else { (joint.rows as f64 / residual.max(floor)).sqrt() }
}

/// The estimate of a solution: values, uncertainty, residuals, remarks.
fn report(model: &Model, joints: &[Triangle], observation: &Observation, solution: &Solution) -> Estimate {
    let parameter = |(c, parameter): (usize, &crate::observation::Parameter)| {
        let mut out = Identified { name: parameter.name.clone(), unit: parameter.unit.into(), ..Identified::default() };
        if !solution.determined[c] {
            return Identified { status: Status::NotIdentifiable, ..out };
        }
        let sigma = (solution.variance * solution.inverse[(c, c)]).sqrt();
        (out.value, out.sigma) = (Some(solution.x[c]), Some(sigma));
        out.relative_sigma = Some(100.0 * sigma / solution.x[c].abs());
        if 2.0 * sigma >= solution.x[c].abs() {
            out.status = Status::NotSignificant;
        }
        out
    };
    let squares: Vec<(f64, f64)> = joints.iter().map(|t| t.squares(&solution.x)).collect();
    let residual = |(j, &(total, residual)): (usize, &(f64, f64))| JointResidual {
        coordinate: model.regressor.coordinates()[j].clone(),
        rms: (residual / joints[j].rows.max(1) as f64).sqrt(),
        relative: relative(total, residual),
        rows: joints[j].rows,
        ..JointResidual::default()
    };
    let (total, left) = squares.iter().fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    Estimate {
        parameters: model.parameters.iter().enumerate().map(parameter).collect(),
        joints: squares.iter().enumerate().map(residual).collect(),
        total: relative(total, left),
        condition_number: solution.condition_number,
        rank: solution.rank,
        rows: joints.iter().map(|t| t.rows).sum(),
        remarks: crate::remark::remarks(model, observation, solution),
        ..Estimate::default()
    }
}

/// Puts the robust standard deviations beside the white ones; the larger of the two counts.
fn widen(estimate: &mut Estimate, sigma: &[f64]) {
    for (parameter, &robust) in estimate.parameters.iter_mut().zip(sigma) {
        let (Some(value), Some(white)) = (parameter.value, parameter.sigma) else { continue };
        parameter.robust_sigma = Some(robust);
        let sigma = white.max(robust);
        parameter.relative_sigma = Some(100.0 * sigma / value.abs());
        parameter.status = if 2.0 * sigma >= value.abs() { Status::NotSignificant } else { Status::Identified };
    }
}

/// |residual| / |total| from squares; 0 of nothing.
pub fn relative(total: f64, residual: f64) -> f64 {
    if total > 0.0 { (residual / total).sqrt() } else { 0.0 }
}
