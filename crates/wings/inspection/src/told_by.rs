//! What a motion or a log would tell: which parameters, how well, and for which purposes.
//!
//! The rows are those of an identification by its defaults, and no torque is needed: deviations follow from the motion and from the
//! noise that is expected ([`experiments::excitation::visibility`]).

use std::path::Path;

use experiments::excitation::course::Course;
use experiments::excitation::limits::{CoordinateLimits, motion_limits};
use experiments::excitation::polynomial_course::PolynomialCourse;
use experiments::excitation::visibility::{
    Foreseen, JointNoise, SeenStates, Visibility, VisibleParameter, fill_row, visibility_of,
};
use experiments::motion::point_trajectory::{Interpolation, PointTrajectory};
use identification::signals::preparation::{Preparation, states};
use linear_model::linear_model::Model as LinearModel;
use logs::{ColumnNames, Columns, Log, Table};
use numerics::interval::Interval;
use random::Random;

use rist::request::Request;
use rist::wings::{described_values, torque_noise};
use rist::{Error, Model, PlayedFile};

use crate::request::VisibilityRequest;

/// What is told.
pub struct ToldBy {
    /// In the order of the model.
    pub parameters: Vec<VisibleParameter>,
    /// Of the columns that are visible within the limits.
    pub condition_number: f64,
    /// Instants of one time.
    pub samples: usize,
    /// How unsure torques will be, by purpose.
    pub purposes: Vec<Outlook>,
    /// What would tell more, joint by joint.
    pub to_add: Vec<String>,
    /// What was assumed.
    pub notes: Vec<String>,
}

/// How unsure the torque of a joint will be, where it is most unsure.
pub struct Outlook {
    /// What torques are wanted for.
    pub purpose: &'static str,
    /// The joint that is most unsure.
    pub coordinate: String,
    /// Root mean square deviation, N m (N); `None` where a parameter that it needs is not told.
    pub deviation: Option<f64>,
    /// That over the root mean square torque of the description, where it has one.
    pub share: Option<f64>,
}

/// States of a purpose: as many tell a root mean square to a tenth.
const STATES_PER_PURPOSE: u64 = 200;
/// Their seed.
const SEED: u64 = 40;
/// Parameters that are named one by one.
const MOST_NAMED: usize = 4;

/// Instants with position, velocity and acceleration of each coordinate.
type States = Vec<Vec<[f64; 3]>>;

/// What a file tells. `interpolation`: of points, as for a check; a table without velocities is differentiated as a log of an
/// identification is, where none is asked for.
///
/// Fails where a number of the request is out of range, where the file is of another model, and where its points do not have what
/// the interpolation needs.
pub fn told_by(
    model: &Model,
    file: &Path,
    content: &PlayedFile,
    interpolation: Option<Interpolation>,
    request: &VisibilityRequest,
) -> Result<ToldBy, Error> {
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
    let values = described_values(model, &linear);
    let (Visibility { mut parameters, condition_number, .. }, foreseen) =
        visibility_of(&linear, &seen, &limits, &noise, &values, &[], &[]);
    for parameter in parameters.iter_mut().filter(|parameter| parameter.is_weak()) {
        parameter.to_blame.get_or_insert("little motion".into());
    }
    let purposes = Foresight { model, linear: &linear, limits: &limits, foreseen: &foreseen }.purposes(&states);
    let to_add = to_add(&linear, &parameters, &states, &limits);
    Ok(ToldBy { parameters, condition_number, samples: states.len(), purposes, to_add, notes })
}

/// The states over which an identification sums, and the times that they come.
fn states_of(
    model: &Model,
    file: &Path,
    content: &PlayedFile,
    interpolation: Option<Interpolation>,
    rate: f64,
    limits: &[CoordinateLimits],
    notes: &mut Vec<String>,
) -> Result<(States, usize), Error> {
    let name = file.display().to_string();
    let refused = |what: String| Error::new(format_args!("{name}: {what}"));
    let names = model.regressor().coordinates();
    match content {
        PlayedFile::Motion(motion) => {
            model.check(file, &motion.model)?;
            let motion = motion.motion(&name)?;
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
            let points = (**points).clone().of_coordinates(names, &|k| limits[k].locked).map_err(refused)?;
            let interpolation = points.interpolation(interpolation).map_err(refused)?;
            notes.push(format!("between its points it is taken as {}", interpolation.word()));
            let course = PolynomialCourse::through(&points, interpolation);
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

/// The states of positions alone, as an identification has them by its defaults.
fn filtered(model: &Model, name: &str, points: &PointTrajectory) -> Result<States, Error> {
    let names = model.regressor().coordinates();
    let n = names.len();
    // A log has torques; none of them counts here.
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

/// What is foreseen of the torques of a model within limits.
struct Foresight<'a> {
    model: &'a Model,
    linear: &'a LinearModel<'a>,
    limits: &'a [CoordinateLimits],
    foreseen: &'a Foreseen,
}

impl Foresight<'_> {
    /// How unsure torques will be: standing, along the motion, and anywhere within the limits.
    fn purposes(&self, states: &States) -> Vec<Outlook> {
        let mut random = Random::new(SEED);
        let mut drawn = |moves: bool| -> Vec<[f64; 3]> {
            let of = |l: &CoordinateLimits| {
                let q = l.locked.unwrap_or_else(|| random.between(l.position.0, l.position.1));
                let mut rate = |most: f64| if moves && l.locked.is_none() { random.between(-most, most) } else { 0.0 };
                [q, rate(l.velocity), rate(l.acceleration)]
            };
            self.limits.iter().map(of).collect()
        };
        let standing: States = (0..STATES_PER_PURPOSE).map(|_| drawn(false)).collect();
        let anywhere: States = (0..STATES_PER_PURPOSE).map(|_| drawn(true)).collect();
        let step = states.len().div_ceil(STATES_PER_PURPOSE as usize).max(1);
        let seen: States = states.iter().step_by(step).cloned().collect();
        let all = [
            ("gravity compensation", standing, false),
            ("feedforward at the speeds of this motion", seen, true),
            ("feedforward at the speed limits", anywhere, true),
        ];
        all.into_iter().filter_map(|(purpose, states, rubs)| self.outlook(purpose, &states, rubs)).collect()
    }

    /// The joint that is most unsure over states; `rubs`: friction counts.
    fn outlook(&self, purpose: &'static str, states: &[Vec<[f64; 3]>], rubs: bool) -> Option<Outlook> {
        let Foresight { model, linear, limits, foreseen } = *self;
        let (n, base) = (linear.n(), linear.regressor.parameters().len());
        let known = model.described_parameters();
        let (mut y, mut row) = (vec![0.0; n * base], vec![0.0; linear.p()]);
        let mut unsure = vec![Some(0.0); n];
        let mut torque = vec![0.0; n];
        for state in states {
            let of = |d: usize| state.iter().map(|x| x[d]).collect::<Vec<f64>>();
            let (dq, ddq) = (of(1), of(2));
            linear.regressor.fill(&of(0), &dq, &ddq, &mut y);
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
        // One that is not told before all others, then by the share, or by the deviation where there is none.
        let rank = |(_, deviation, share): &(usize, Option<f64>, Option<f64>)| match (deviation, share) {
            (None, _) => f64::INFINITY,
            (Some(deviation), None) => *deviation,
            (_, Some(share)) => *share,
        };
        let moving = (0..n).filter(|&i| limits[i].locked.is_none());
        let (i, deviation, share) = moving.map(one).max_by(|a, b| rank(a).total_cmp(&rank(b)))?;
        Some(Outlook { purpose, coordinate: linear.regressor.coordinates()[i].clone(), deviation, share })
    }
}

/// For each joint behind parameters that are weak or not told: how little of its limits it uses.
fn to_add(
    linear: &LinearModel,
    parameters: &[VisibleParameter],
    states: &States,
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
    // The joint of a parameter that uses least of its acceleration.
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
        let named = names[..names.len().min(MOST_NAMED)].join(", ");
        let more = names.len().saturating_sub(MOST_NAMED);
        let more = if more == 0 { String::new() } else { format!(" and {more} more") };
        format!(
            "{}: it uses {:.0} % of its positions, {:.0} % of its velocity and {:.0} % of its acceleration; more would tell \
             {named}{more}",
            linear.regressor.coordinates()[*k],
            100.0 * turned(*k),
            100.0 * used(*k, 1),
            100.0 * used(*k, 2)
        )
    };
    by_joint.iter().map(sentence).collect()
}
