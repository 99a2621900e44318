//! Simulates the experiments of a plan, or an exciting motion, and returns their logs.
//!
//! The robot is simulated in closed loop, with friction, noise and drive gains. A record is the result of one motion: sampled
//! positions and torques (or currents). Validation motions are further random motions, with which an estimate can be tested.
//! The truth is the true parameters, written as an estimate.

use claims::significant;
use experiments::excitation::limits::{AskedLimits, LimitKind};
use experiments::excitation::motion;
use experiments::motion::point_to_point::{ValidationMotion, validation_trajectory};
use experiments::motion::record::Record;
use experiments::motion::reference_motion::Reference;
use experiments::motion::sample_count::check_samples;
use experiments::plan::candidates::MotionLimits;
use experiments::plan::exciting_trajectory::ExcitingTrajectory;
use experiments::plan::ranges::check_limits;
use experiments::simulate::closed_loop::Stop;
use experiments::simulate::dynamics::{Dynamics, inverse_dynamics};
use experiments::simulate::setup::{self, MAX_CONTROL_PERIOD_S, SimulatedMotion, SimulationSetup};
use expr::Tape;
use identification::estimate::identified::Identified;
use linear_model::artefact::Checksum;
use linear_model::parameter::{BaseParameter, FrictionParameter, Parameter, ParameterId};
use logs::Effort;
use numerics::interruption::Interruption;
use processor::{in_order, threads};
use random::Random;

use crate::describe::adapters::tape_dynamics::dynamics as dynamics_of;
pub use crate::request::SimulateRequest;
use identification::estimate::artefact::Estimate;

use crate::describe::model::Model;
use crate::error::Error;
use crate::motion::exciting::ExcitingMotion;
use crate::motion::planning::ExperimentPlan;
use crate::request::Request;

/// The motions to simulate.
#[derive(Clone, Copy, Debug)]
pub enum Motions<'a> {
    /// The experiments of a plan.
    Planned(&'a ExperimentPlan),
    /// One motion of all joints.
    Exciting(&'a ExcitingMotion),
}

impl<'a> From<&'a ExperimentPlan> for Motions<'a> {
    fn from(plan: &'a ExperimentPlan) -> Motions<'a> {
        Motions::Planned(plan)
    }
}

impl<'a> From<&'a ExcitingMotion> for Motions<'a> {
    fn from(motion: &'a ExcitingMotion) -> Motions<'a> {
        Motions::Exciting(motion)
    }
}

impl Motions<'_> {
    /// The checksum of the file with the motions.
    fn model_checksum(&self) -> Checksum {
        match self {
            Motions::Planned(plan) => plan.checksum,
            Motions::Exciting(motion) => motion.checksum,
        }
    }

    /// Sample time of the logs, s.
    fn sample_time(&self) -> f64 {
        match self {
            Motions::Planned(plan) => plan.sample_time_s,
            Motions::Exciting(motion) => 1.0 / motion.rate_hz,
        }
    }

    /// The trajectories of the motions, each with its name.
    fn paths(&self) -> Result<Vec<(&str, SimulatedPath)>, Error> {
        match self {
            Motions::Planned(plan) => {
                let names = plan.experiments.iter().map(|e| e.name.as_str());
                Ok(names.zip(plan.trajectories("plan")?.into_iter().map(SimulatedPath::Planned)).collect())
            }
            Motions::Exciting(motion) => {
                let motion = motion.motion("motion")?;
                // The controller takes one more sample after the motion ends. At a low sample rate, this sample is long after
                // the end.
                let (rate, seconds) =
                    (motion.rate.max(1.0 / MAX_CONTROL_PERIOD_S), motion.duration() + 1.0 / motion.rate);
                check_samples(seconds * rate).map_err(|e| Error::new(format_args!("motion: at {rate} Hz {e}")))?;
                Ok(vec![("motion", SimulatedPath::Exciting(motion))])
            }
        }
    }
}

impl SimulateRequest {
    /// Whether the simulated logs hold torques or currents. If no drive gain is known, the logs hold torques, because torques
    /// can be identified without gains.
    pub fn effort(&self, model: &Model) -> Effort {
        let is_without_gains = self.gain.is_empty() && model.drive_gains().iter().all(Option::is_none);
        if is_without_gains { Effort::Torque } else { Effort::Current }
    }
}

/// The result of a simulation.
pub struct Simulated {
    /// The true values: parameters, friction and gains with which the logs were simulated.
    pub truth: Estimate,
    /// The true values with the load; `None` without a load.
    pub loaded_truth: Option<Estimate>,
    /// Sentences on assumptions about values that the description lacks.
    pub notes: Vec<String>,
}

/// Simulates motions in closed loop, with friction, noise and drive gains. Calls `take` with the name and the record of each
/// motion. Names: the names of the plan's experiments, or `motion`; `v01`, .. for validation motions; `e01_loaded`, .. for
/// experiments with the load.
///
/// Fails if the description has no inertial parameters or impossible inertial parameters, if a limit is out of range, or if
/// `take` fails.
pub fn simulate<'a>(
    model: &Model,
    motions: impl Into<Motions<'a>>,
    request: &SimulateRequest,
    take: &mut dyn FnMut(&str, &Record) -> Result<(), Error>,
) -> Result<Simulated, Error> {
    request.check()?;
    let motions = motions.into();
    let (paths, sample_time, checksum) = (motions.paths()?, motions.sample_time(), motions.model_checksum());
    let refused = |e: String| Error::new(format_args!("{}: {e}", model.path.display()));
    let without_bodies = "no link has inertial parameters; give standard_parameters to simulate with";
    let truth = model.nominal_parameters().ok_or_else(|| refused(without_bodies.into()))?;
    let dynamics = dynamics_of(model, truth.clone());
    let mut setup = SimulationSetup::for_robot(&model.robot, dynamics.as_ref());
    check_limits(model.regressor().coordinates(), &setup.limits).map_err(refused)?;
    check_validation(&setup.limits, sample_time, request.validation).map_err(refused)?;
    model.give_gains(&mut setup.drives.gain, &request.gain)?;
    let feedforward = |estimate| Feedforward::new(model, estimate, &setup.drives.gain);
    let feedforward = request.feedforward.as_ref().map(feedforward).transpose()?;
    let validations: Vec<SimulatedPath> = (0..request.validation).map(SimulatedPath::Validation).collect();
    let motion = |name: String, path, is_loaded| MotionToSimulate { name, path, is_loaded };
    let mut motions: Vec<MotionToSimulate> =
        paths.iter().map(|(name, path)| motion(name.to_string(), path, false)).collect();
    motions.extend(validations.iter().enumerate().map(|(k, path)| motion(format!("v{:02}", k + 1), path, false)));
    let (mut loaded, mut with_load) = (None, None);
    if let Some((_, load)) = &request.load {
        let added = model.added_by(load)?;
        let plus = |x: &[f64]| x.iter().zip(&added).map(|(x, l)| x + l).collect::<Vec<f64>>();
        // The load is known, so the torques of the feedforward include the load.
        let feedforward = feedforward.as_ref().map(|f| Feedforward { parameters: plus(&f.parameters), ..f.clone() });
        with_load = Some(plus(&truth));
        loaded = Some(SimulationSettings {
            model,
            setup: &setup,
            request,
            dynamics: dynamics_of(model, plus(&truth)),
            feedforward,
        });
        motions.extend(paths.iter().map(|(name, path)| motion(format!("{name}_loaded"), path, true)));
    }
    let run = SimulationSettings { model, setup: &setup, request, dynamics, feedforward };
    let groups = simulated_side_by_side(&motions);
    let records = |_, group: &Vec<usize>| {
        let run = loaded.as_ref().filter(|_| motions[group[0]].is_loaded).unwrap_or(&run);
        let reference = |index: &usize| match motions[*index].path {
            SimulatedPath::Planned(trajectory) => trajectory.reference(),
            SimulatedPath::Exciting(motion) => motion.reference(),
            SimulatedPath::Validation(number) => {
                validation_motion(&run.setup.limits, sample_time, request.seed, *number)
            }
        };
        run.records(group, &group.iter().map(reference).collect::<Vec<Reference>>())
    };
    in_order(&groups, threads(), records, |group, records| {
        groups[group].iter().zip(records).try_for_each(|(index, (record, stop))| {
            Interruption::check()?;
            let name = &motions[*index].name;
            take(name, &whole(name, record, stop)?)
        })
    })?;
    let of_feedforward = request.feedforward.as_ref().and_then(|estimate| estimate.checksum.note("[feedforward]"));
    let sentences = checksum.note("the motion").into_iter().chain(of_feedforward);
    let sentences = sentences.chain(paths.iter().flat_map(|(name, path)| beyond_limits(model, name, path)));
    let notes = sentences.chain(setup.notes.iter().cloned()).chain(effort_notes(model, request)).collect();
    let of = |x: &[f64]| truth_of(model, &setup, x, request.effort(model));
    Ok(Simulated { truth: of(&truth), loaded_truth: with_load.as_deref().map(of), notes })
}

/// Excess of a set point over a limit that counts as rounding, as a share of (upper minus lower limit).
const SET_POINT_ROUNDING_SHARE: f64 = 1e-6;

/// Notes on set points beyond the limits of the description. The simulation ignores these limits.
fn beyond_limits(model: &Model, name: &str, path: &SimulatedPath) -> Vec<String> {
    let reference = match path {
        SimulatedPath::Planned(trajectory) => trajectory.reference(),
        SimulatedPath::Exciting(motion) => motion.reference(),
        SimulatedPath::Validation(_) => return vec![],
    };
    let (series, kinds) = ([&reference.q, &reference.dq, &reference.ddq], &LimitKind::KINEMATIC[..3]);
    let of = |(k, coordinate): (usize, &robot::Coordinate)| {
        let described = AskedLimits::of_description(&coordinate.limits);
        let one = |(x, kind): (&&Vec<Vec<f64>>, &LimitKind)| {
            let (low, high) = described.bounds(*kind)?;
            let beyond = |x: f64| (x - high).max(low - x);
            let farthest = x.get(k)?.iter().copied().reduce(|a, b| if beyond(b) > beyond(a) { b } else { a })?;
            // A set point at a limit can exceed this limit by rounding.
            (beyond(farthest) > SET_POINT_ROUNDING_SHARE * (high - low)).then(|| {
                let (unit, bound) =
                    (kind.unit(model.regressor().is_prismatic(k)), if farthest > high { high } else { low });
                let [farthest, bound] = [farthest, bound].map(|x| significant(x, 3));
                format!(
                    "{name}: {kind} of {}: {farthest} {unit} is beyond {bound} of the description (`[:check]`)",
                    coordinate.name
                )
            })
        };
        series.iter().zip(kinds).filter_map(one).collect::<Vec<String>>()
    };
    model.robot.coordinates.iter().enumerate().flat_map(of).collect()
}

/// Sentences on drive gains that the simulation assumes.
fn effort_notes(model: &Model, request: &SimulateRequest) -> Vec<String> {
    if request.effort(model) == Effort::Torque {
        return vec!["no drive gain is known: the logs hold torques ([gain] makes currents of them)".into()];
    }
    let regressor = model.regressor();
    let names = regressor.coordinates().iter().zip(model.drive_gains()).enumerate();
    let assumed = names.filter(|(_, (c, gain))| gain.is_none() && request.gain.iter().all(|(name, _)| name != *c));
    let unit = |k: usize| if regressor.is_prismatic(k) { "N/A" } else { "N m/A" };
    assumed.map(|(k, (c, _))| format!("{c}: no drive gain in the file, 1 {} assumed", unit(k))).collect()
}

/// Fails if a validation motion would have too many samples.
fn check_validation(limits: &[MotionLimits], sample_time: f64, motions: usize) -> Result<(), String> {
    let motion = ValidationMotion::default();
    let longest = |l: &MotionLimits| motion.seconds(l.position.1 - l.position.0, l.velocity, l.acceleration);
    let longest = limits.iter().map(longest).fold(0.0, f64::max);
    let samples = motion.moves as f64 * longest / sample_time;
    let of = |e: String| format!("a motion for validation within these limits: {e} ([validation=0] makes none)");
    if motions > 0 { check_samples(samples).map_err(of) } else { Ok(()) }
}

/// Stream of the random numbers of validation motions. It differs from the stream of the noise, so motions and noise are
/// independent.
const VALIDATION_STREAM: u64 = 0x76;

/// A validation motion between random points, at the limits of the joints. Each `number` gives other points.
fn validation_motion(limits: &[MotionLimits], sample_time: f64, seed: u64, number: usize) -> Reference {
    let of = |f: &dyn Fn(&MotionLimits) -> f64| limits.iter().map(f).collect::<Vec<f64>>();
    let position: Vec<(f64, f64)> = limits.iter().map(|l| l.position).collect();
    let (velocity, acceleration) = (of(&|l| l.velocity), of(&|l| l.acceleration));
    let mut random = Random::stream(seed ^ VALIDATION_STREAM, number as u64);
    let motion = ValidationMotion::default();
    validation_trajectory(&motion, &position, &velocity, &acceleration, sample_time, &mut random)
}

/// Splits motions into groups that are simulated together in SIMD lanes. Each group has motions with the same load, at most one
/// per lane. Motions are given by their indices.
fn simulated_side_by_side(motions: &[MotionToSimulate]) -> Vec<Vec<usize>> {
    let numbers: Vec<usize> = (0..motions.len()).collect();
    let of_one_robot = numbers.chunk_by(|a, b| motions[*a].is_loaded == motions[*b].is_loaded);
    let even = |of_one: &[usize]| of_one.len().div_ceil(of_one.len().div_ceil(Tape::LANES));
    of_one_robot.flat_map(|of_one| of_one.chunks(even(of_one))).map(<[usize]>::to_vec).collect()
}

/// Returns the record of a motion. Fails if the simulation of this motion stopped before the end.
fn whole(name: &str, record: Record, stop: Stop) -> Result<Record, Error> {
    match stop {
        Stop::End => Ok(record),
        Stop::NotPhysical { time } => Err(Error::new(format_args!(
            "{name}: the simulation breaks down at {time:.3} s: the inertial parameters of the file are not physical, or the \
             robot cannot follow"
        ))),
    }
}

/// A motion to be simulated.
struct MotionToSimulate<'a> {
    name: String,
    path: &'a SimulatedPath,
    is_loaded: bool,
}

/// The trajectory of a motion to simulate.
enum SimulatedPath {
    Planned(ExcitingTrajectory),
    Exciting(motion::Motion),
    /// The validation motion with this number.
    Validation(usize),
}

/// Settings that all simulated motions have in common. Only the noise differs between motions.
struct SimulationSettings<'a> {
    model: &'a Model,
    setup: &'a SimulationSetup,
    request: &'a SimulateRequest,
    dynamics: Box<dyn Dynamics + 'a>,
    feedforward: Option<Feedforward>,
}

impl SimulationSettings<'_> {
    /// Simulates the motions with the indices `numbers`, and returns their records.
    fn records(&self, numbers: &[usize], references: &[Reference]) -> Vec<(Record, Stop)> {
        let added = self.feedforward.as_ref().map(|f| |reference: &Reference| f.torques(self.model, reference));
        let feedforward = added.as_ref().map(|f| f as &setup::Feedforward);
        let noise = |number: usize| (!self.request.noise_free).then_some((self.request.seed, number as u64));
        let asked =
            |(number, reference): (&usize, _)| SimulatedMotion { reference, feedforward, noise: noise(*number) };
        let asked: Vec<SimulatedMotion> = numbers.iter().zip(references).map(asked).collect();
        self.setup.records(self.dynamics.as_ref(), &asked)
    }
}

/// Feedforward torques of the simulated controller. They are added to the feedback torques of the controller.
#[derive(Clone)]
struct Feedforward {
    /// Base parameters of the estimate that gives the torques.
    parameters: Vec<f64>,
    /// True drive gain divided by estimated gain, one per coordinate. The controller divides a torque by the estimated gain,
    /// and the drive multiplies the current by the true gain.
    factor: Vec<f64>,
}

impl Feedforward {
    fn new(model: &Model, estimate: &Estimate, gain: &[f64]) -> Result<Feedforward, Error> {
        let estimated = model.estimated_gains(estimate);
        let factor = gain.iter().zip(estimated).map(|(k, found)| found.map_or(1.0, |found| k / found)).collect();
        Ok(Feedforward { parameters: model.values(estimate)?, factor })
    }

    /// Feedforward torques along `reference`, N m (N), one series per coordinate.
    fn torques(&self, model: &Model, reference: &Reference) -> Vec<Vec<f64>> {
        let mut torques = inverse_dynamics(model.regressor(), &self.parameters, reference);
        for (series, factor) in torques.iter_mut().zip(&self.factor) {
            series.iter_mut().for_each(|t| *t *= factor);
        }
        torques
    }
}

/// The true values, with which the logs were simulated, as an estimate.
fn truth_of(model: &Model, setup: &SimulationSetup, truth: &[f64], effort: Effort) -> Estimate {
    let regressor = model.regressor();
    let base = |(base, value): (&BaseParameter, &f64)| {
        let parameter = Parameter::from(base);
        let unit = parameter.unit();
        Identified::given(parameter.id, unit, *value)
    };
    let mut parameters: Vec<Identified> = regressor.parameters().iter().zip(truth).map(base).collect();
    let of_joint = |k: usize, id: ParameterId, value: f64| {
        let unit = id.unit(regressor.is_prismatic(k));
        Identified::given(id, unit, value)
    };
    // As in equation (5) of [Vandanjon, Gautier, Desbats 1995], viscous and Coulomb friction (FV, FS) have a value for each
    // direction of motion.
    for (k, (coordinate, law)) in regressor.coordinates().iter().zip(&setup.friction).enumerate() {
        let by_direction = [
            (FrictionParameter::ViscousForward, law.viscous_positive),
            (FrictionParameter::CoulombForward, law.coulomb_positive),
            (FrictionParameter::ViscousBackward, law.viscous_negative),
            (FrictionParameter::CoulombBackward, law.coulomb_negative),
        ];
        let one = |(parameter, value)| of_joint(k, ParameterId::friction(parameter, coordinate), value);
        parameters.extend(by_direction.map(one));
    }
    let gains = setup.drives.gain.iter().filter(|_| effort == Effort::Current);
    for (k, (coordinate, gain)) in regressor.coordinates().iter().zip(gains).enumerate() {
        parameters.push(of_joint(k, ParameterId::drive_gain(coordinate), *gain));
    }
    Estimate {
        model: model.reference.name.clone(),
        fingerprint: Some(model.reference.fingerprint.clone()),
        description: model.description.clone(),
        method: "simulated with these values".into(),
        parameters,
        ..Estimate::default()
    }
}
