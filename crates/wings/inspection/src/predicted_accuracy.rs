//! Predicts the result of an identification from a motion or a log: identifiable parameters, their accuracy, and uses of the
//! torques.
//!
//! The regression rows are computed as by an identification with default settings. No torque is needed, because the standard
//! deviations follow from the motion and the expected noise ([`experiments::excitation::visibility`]).

use std::path::Path;

use experiments::excitation::limits::{CoordinateLimits, motion_limits};
use experiments::excitation::polynomial_trajectory::PolynomialTrajectory;
use experiments::excitation::trajectory::Trajectory;
use experiments::excitation::visibility::{
    JointNoise, SeenStates, TorqueForecast, Visibility, VisibleParameter, fill_row, visibility_of,
};
use experiments::motion::point_trajectory::{Interpolation, PointTrajectory};
use identification::signals::preparation::{Preparation, states};
use linear_model::linear_model::Model as LinearModel;
use logs::{ColumnNames, Columns, Log, Table};
use numerics::interval::Interval;
use random::Random;

use rist::request::Request;
use rist::wings::{nominal_values, torque_noise};
use rist::{Error, Model, PlayedFile};

use crate::request::VisibilityRequest;

/// The predicted result of an identification.
pub struct PredictedAccuracy {
    /// Predictions for the parameters, in the order of the model.
    pub parameters: Vec<VisibleParameter>,
    /// Condition number of the regressor. Only columns count that motions within the limits can separate.
    pub condition_number: f64,
    /// Number of samples in one repetition of the motion.
    pub samples: usize,
    /// For each use of the torques, the predicted standard deviation of the torques.
    pub purposes: Vec<JointForecast>,
    /// For each joint with weak parameters, a sentence on a motion that would determine more parameters.
    pub to_add: Vec<String>,
    /// Assumptions of the prediction, in sentences.
    pub notes: Vec<String>,
}

/// The predicted uncertainty of the torques for one use (for example gravity compensation). Only the joint with the largest
/// uncertainty is given.
pub struct JointForecast {
    /// Name of the use of the torques.
    pub purpose: &'static str,
    /// Name of the joint with the largest uncertainty.
    pub coordinate: String,
    /// Rms, over the states, of the standard deviation of the torque, N m (N). `None` if the torque depends on a parameter that
    /// is not identifiable.
    pub deviation: Option<f64>,
    /// `deviation` divided by the rms of the nominal torque (from the parameters in the description). `None` if there is no
    /// nominal torque.
    pub share: Option<f64>,
}

/// Number of random states per use. With this number, the rms has a relative error of about a tenth.
const STATES_PER_PURPOSE: u64 = 200;
/// Seed of the random states.
const SEED: u64 = 40;
/// Largest number of parameters that are listed by name.
const MAX_NAMED: usize = 4;

/// For each sample and each coordinate: position, velocity and acceleration.
type Instants = Vec<Vec<[f64; 3]>>;

/// Predicts the result of an identification from the motion in a file. `interpolation`: how points of a table are interpolated.
/// If `interpolation` is `None`, a table without accelerations is filtered and differentiated like the log of an
/// identification.
///
/// Fails if a number of the request is out of range, if the file belongs to another model, or if its points lack derivatives that
/// the interpolation needs.
pub fn predicted_accuracy(
    model: &Model,
    file: &Path,
    content: &PlayedFile,
    interpolation: Option<Interpolation>,
    request: &VisibilityRequest,
) -> Result<PredictedAccuracy, Error> {
    request.check()?;
    let refused = |what: String| Error::new(format_args!("{}: {what}", model.path.display()));
    let names = model.regressor().coordinates();
    let described: Vec<robot::Limits> = model.robot.coordinates.iter().map(|c| c.limits).collect();
    let is_prismatic = |k: usize| model.regressor().is_prismatic(k);
    let asked = request.limits.clone().unwrap_or_default();
    let (limits, mut notes) = motion_limits(names, is_prismatic, &described, &asked).map_err(refused)?;
    let noise = JointNoise::of_torques(torque_noise(model, request.noise, &mut notes));
    let friction = request.friction_terms()?;
    let linear = LinearModel::new(model.regressor(), &friction, &[]);
    let (states, repetitions) = states_of(model, file, content, interpolation, request.rate, &limits, &mut notes)?;
    let seen = SeenStates { count: states.len(), at: &|i| states[i].clone(), repetitions };
    let values = nominal_values(model, &linear);
    let (Visibility { mut parameters, condition_number, .. }, foreseen) =
        visibility_of(&linear, &seen, &limits, &noise, &values, &[], &[]);
    for parameter in parameters.iter_mut().filter(|parameter| parameter.is_weak()) {
        parameter.to_blame.get_or_insert("little motion".into());
    }
    let purposes = Foresight { model, linear: &linear, limits: &limits, forecast: &foreseen }.purposes(&states);
    let to_add = to_add(&linear, &parameters, &states, &limits);
    Ok(PredictedAccuracy { parameters, condition_number, samples: states.len(), purposes, to_add, notes })
}

/// The states that an identification would use, and the number of repetitions of the motion.
fn states_of(
    model: &Model,
    file: &Path,
    content: &PlayedFile,
    interpolation: Option<Interpolation>,
    rate: f64,
    limits: &[CoordinateLimits],
    notes: &mut Vec<String>,
) -> Result<(Instants, usize), Error> {
    let name = file.display().to_string();
    let refused = |what: String| Error::new(format_args!("{name}: {what}"));
    let names = model.regressor().coordinates();
    match content {
        PlayedFile::Motion(motion) => {
            model.check(file, &motion.model)?;
            let motion = motion.motion(&name)?;
            // One period after the initial blend (the motion from rest to the series). All later periods have the same states.
            let count = (motion.shape.period() * motion.rate).round() as usize;
            let at = |r: usize| {
                let state = motion.at(motion.shape.blend() + r as f64 / motion.rate);
                state.iter().map(|x| [x[0], x[1], x[2]]).collect()
            };
            Ok(((0..count).map(at).collect(), motion.repetitions.max(1)))
        }
        PlayedFile::Plan(plan) => {
            model.check(file, &plan.model)?;
            let mut found = Vec::new();
            for experiment in plan.trajectories(&name)? {
                // Only the samples in the windows of an experiment are used. The windows exclude the time in which the robot
                // settles.
                let reference = experiment.reference();
                let at = |r: usize| {
                    (0..names.len()).map(|k| [reference.q[k][r], reference.dq[k][r], reference.ddq[k][r]]).collect()
                };
                found.extend(reference.windows.iter().flat_map(|window| window.clone()).map(at));
            }
            Ok((found, 1))
        }
        PlayedFile::Table(points) if interpolation.is_none() && points.accelerations().is_none() => {
            Ok((filtered(model, &name, points)?, 1))
        }
        PlayedFile::Points(points) | PlayedFile::Table(points) => {
            // The points are interpolated, and sampled at the rate that the request gives.
            let points = (**points).clone().of_coordinates(names, &|k| limits[k].locked).map_err(refused)?;
            let interpolation = points.interpolation(interpolation).map_err(refused)?;
            notes.push(format!("between its points it is taken as {}", interpolation.word()));
            let course = PolynomialTrajectory::through(&points, interpolation);
            let enclosed = course.enclosed();
            let mut found = Vec::new();
            let mut next = points.times().first().copied().unwrap_or(0.0);
            for (i, stretch) in course.stretches().iter().enumerate() {
                while next < stretch.start + stretch.length {
                    let state = enclosed.on(i, Interval::point(next - stretch.start));
                    found.push(state.iter().map(|x| [0, 1, 2].map(|d| x[d].middle())).collect());
                    next += 1.0 / rate;
                }
            }
            Ok((found, 1))
        }
    }
}

/// The states of a table that has only positions: filtered and differentiated as in an identification with default settings.
fn filtered(model: &Model, name: &str, points: &PointTrajectory) -> Result<Instants, Error> {
    let names = model.regressor().coordinates();
    let n = names.len();
    // A log must have torques, but their values have no effect here, so they are zero.
    let no_torque = vec![0.0; points.times().len()];
    let mut table = Table { file: name.into(), ..Table::default() };
    let mut push = |header: String, values: &[f64]| {
        table.header.push(header);
        table.columns.push(values.to_vec());
        table.texts.push(None);
    };
    push("t".into(), points.times());
    for (k, name) in names.iter().enumerate() {
        push(format!("q_{name}"), &points.positions()[k]);
        points.velocities().iter().for_each(|velocities| push(format!("dq_{name}"), &velocities[k]));
        push(format!("tau_{name}"), &no_torque);
    }
    let log = Log::from_table(&table, &Columns::find(&table, names, &ColumnNames::default())?)?;
    let records = states(model.regressor(), &log, &Preparation::default())?;
    let of = |record: &linear_model::states::States, i: usize| -> Vec<[f64; 3]> {
        (i * n..(i + 1) * n).map(|at| [record.q[at], record.dq[at], record.ddq[at]]).collect()
    };
    Ok(records.iter().flat_map(|record| (0..record.t.len()).map(move |i| of(record, i))).collect())
}

/// Predicts the uncertainty of torques within limits.
struct Foresight<'a> {
    model: &'a Model,
    linear: &'a LinearModel<'a>,
    limits: &'a [CoordinateLimits],
    forecast: &'a TorqueForecast,
}

impl Foresight<'_> {
    /// The uncertainty of the torques for three uses: gravity compensation (at rest), feedforward along the motion, and
    /// feedforward at any state within the limits.
    fn purposes(&self, states: &Instants) -> Vec<JointForecast> {
        let mut random = Random::new(SEED);
        let mut drawn = |moves: bool| -> Vec<[f64; 3]> {
            let of = |l: &CoordinateLimits| {
                let q = l.locked.unwrap_or_else(|| random.between(l.position.0, l.position.1));
                let mut rate = |most: f64| if moves && l.locked.is_none() { random.between(-most, most) } else { 0.0 };
                [q, rate(l.velocity), rate(l.acceleration)]
            };
            self.limits.iter().map(of).collect()
        };
        let standing: Instants = (0..STATES_PER_PURPOSE).map(|_| drawn(false)).collect();
        let anywhere: Instants = (0..STATES_PER_PURPOSE).map(|_| drawn(true)).collect();
        let step = states.len().div_ceil(STATES_PER_PURPOSE as usize).max(1);
        let seen: Instants = states.iter().step_by(step).cloned().collect();
        let all = [
            ("gravity compensation", standing, false),
            ("feedforward at the speeds of this motion", seen, true),
            ("feedforward at the speed limits", anywhere, true),
        ];
        all.into_iter().filter_map(|(purpose, states, rubs)| self.joint_forecasts(purpose, &states, rubs)).collect()
    }

    /// The torque uncertainty over these states, for the joint where it is largest; `None` if no joint moves. `rubs`: whether
    /// friction is included.
    fn joint_forecasts(&self, purpose: &'static str, states: &[Vec<[f64; 3]>], rubs: bool) -> Option<JointForecast> {
        let Foresight { model, linear, limits, forecast: foreseen } = *self;
        let (n, base) = (linear.n(), linear.regressor.parameters().len());
        let known = model.nominal_parameters();
        let (mut y, mut row) = (vec![0.0; n * base], vec![0.0; linear.p()]);
        let mut unsure = vec![Some(0.0); n];
        let mut torque = vec![0.0; n];
        for state in states {
            let of = |d: usize| state.iter().map(|x| x[d]).collect::<Vec<f64>>();
            let (dq, ddq) = (of(1), of(2));
            linear.regressor.fill(&of(0), &dq, &ddq, &mut y);
            // The variance of the torque y X follows from the predicted covariance of the parameters X; y: row of the regressor.
            // The torque with nominal parameters is summed too, because the relative uncertainty is divided by it.
            for i in (0..n).filter(|&i| limits[i].locked.is_none()) {
                fill_row(linear, i, &y, dq[i], ddq[i], &mut row);
                if !rubs {
                    row[base..].fill(0.0);
                }
                unsure[i] = unsure[i].zip(foreseen.torque_deviation(&row)).map(|(sum, sigma)| sum + sigma * sigma);
                let rigid = known.iter().flat_map(|x| x.iter().zip(&row)).map(|(x, y)| x * y).sum::<f64>();
                torque[i] += rigid * rigid;
            }
        }
        let count = states.len().max(1) as f64;
        let one = |i: usize| {
            let deviation = unsure[i].map(|sum: f64| (sum / count).sqrt());
            let size = Some((torque[i] / count).sqrt()).filter(|size| *size > 0.0);
            (i, deviation, deviation.zip(size).map(|(deviation, size)| deviation / size))
        };
        // The joint that is first in this order is reported. A joint whose torque depends on an unidentifiable parameter comes
        // first. The others are ordered by relative uncertainty or, if there is none, by standard deviation.
        let rank = |(_, deviation, share): &(usize, Option<f64>, Option<f64>)| match (deviation, share) {
            (None, _) => f64::INFINITY,
            (Some(deviation), None) => *deviation,
            (_, Some(share)) => *share,
        };
        let moving = (0..n).filter(|&i| limits[i].locked.is_none());
        let (i, deviation, share) = moving.map(one).max_by(|a, b| rank(a).total_cmp(&rank(b)))?;
        Some(JointForecast { purpose, coordinate: linear.regressor.coordinates()[i].clone(), deviation, share })
    }
}

/// For each joint with weak or unidentifiable parameters, a sentence: which fractions of the joint's limits the motion uses, and
/// which parameters a larger motion would identify.
fn to_add(
    linear: &LinearModel,
    parameters: &[VisibleParameter],
    states: &Instants,
    limits: &[CoordinateLimits],
) -> Vec<String> {
    let used = |k: usize, d: usize| -> f64 {
        let greatest = states.iter().map(|state| state[k][d].abs()).fold(0.0, f64::max);
        greatest / if d == 1 { limits[k].velocity } else { limits[k].acceleration }
    };
    let turned = |k: usize| -> f64 {
        let ends = states
            .iter()
            .map(|state| state[k][0])
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        (ends.1 - ends.0).max(0.0) / (limits[k].position.1 - limits[k].position.0)
    };
    // A parameter may depend on several joints. It is listed under the joint that uses the smallest fraction of its acceleration
    // limit.
    let mut by_joint: Vec<(usize, Vec<String>)> = Vec::new();
    for (parameter, seen) in linear.parameters.iter().zip(parameters).filter(|(_, seen)| seen.remark().is_some()) {
        let slowest = parameter.coordinates.iter().copied().min_by(|&a, &b| used(a, 2).total_cmp(&used(b, 2)));
        let Some(joint) = slowest else { continue };
        match by_joint.iter_mut().find(|(known, _)| *known == joint) {
            Some((_, names)) => names.push(seen.id.to_string()),
            None => by_joint.push((joint, vec![seen.id.to_string()])),
        }
    }
    let sentence = |(k, names): &(usize, Vec<String>)| {
        let named = names[..names.len().min(MAX_NAMED)].join(", ");
        let more = names.len().saturating_sub(MAX_NAMED);
        let more = if more == 0 { String::new() } else { format!(" and {more} more") };
        format!(
            "{}: it uses {:.0} % of its positions, {:.0} % of its velocity and {:.0} % of its acceleration; more would identify {named}{more}",
            linear.regressor.coordinates()[*k],
            100.0 * turned(*k),
            100.0 * used(*k, 1),
            100.0 * used(*k, 2)
        )
    };
    by_joint.iter().map(sentence).collect()
}
