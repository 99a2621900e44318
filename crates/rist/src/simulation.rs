//! Simulates the experiments of a plan: the logs that they would give.

use identification::algebra::random::Random;
use identification::estimate::identified::Identified;
use identification::experiments::candidates::MotionLimits;
use identification::experiments::exciting_trajectory::Reference;
use identification::experiments::point_to_point::{ValidationMotion, validation_trajectory};
use identification::experiments::ranges::{check_limits, check_samples};
use identification::experiments::record::Record;
use identification::model::known_load::KnownLoad;
use identification::model::parameter::{BaseParameter, Parameter, ParameterId};
use identification::simulate::closed_loop::Stop;
use identification::simulate::dynamics::{RegressorDynamics, inverse_dynamics};
use identification::simulate::setup::SimulationSetup;

use crate::error::Error;
use crate::model::Model;
use crate::{Estimate, ExperimentPlan};

/// How the experiments of a plan are simulated.
#[derive(Clone, Debug)]
pub struct SimulateRequest {
    /// Number of motions for validation, which the plan does not have.
    pub validation_motions: usize,
    /// Drive gains, by coordinate, N m/A; others as the description says, or 1.
    pub gains: Vec<(String, f64)>,
    /// Every experiment is done again with this load.
    pub load: Option<KnownLoad>,
    /// An estimate whose torques the controller adds.
    pub feedforward: Option<Estimate>,
    /// Seed of the noise.
    pub seed: u64,
    /// Neither noise nor rounding of the sensors.
    pub noise_free: bool,
}

impl Default for SimulateRequest {
    fn default() -> SimulateRequest {
        let (gains, load, feedforward) = (Vec::new(), None, None);
        SimulateRequest { validation_motions: 10, gains, load, feedforward, seed: 1, noise_free: false }
    }
}

/// The outcome of a simulation.
pub struct Simulated {
    /// The parameters and gains behind the logs.
    pub truth: Estimate,
    /// Sentences on what the description does not say and was assumed.
    pub notes: Vec<String>,
}

/// Simulates the experiments of a plan in closed loop, with friction, noise and drive gains; hands over each record
/// with its name: those of the plan, `v01`, .. for validation, `e01_loaded`, .. with the load.
///
/// Fails where the description has no inertial parameters or impossible ones, where a limit is out of range, and where
/// `take` does.
pub fn simulate(
    model: &Model,
    plan: &ExperimentPlan,
    request: &SimulateRequest,
    take: &mut dyn FnMut(&str, &Record) -> Result<(), Error>,
) -> Result<Simulated, Error> {
    let trajectories = plan.trajectories("plan")?;
    let Some(truth) = model.described_parameters() else {
        return Err(Error::new(format_args!(
            "{}: no link has inertial parameters; give standard_parameters to simulate with",
            model.path.display()
        )));
    };
    let dynamics = RegressorDynamics::new(model.regressor(), truth.clone());
    let mut setup = SimulationSetup::for_robot(&model.robot, &dynamics);
    let refused = |e: String| Error::new(format_args!("{}: {e}", model.path.display()));
    check_limits(model.regressor().coordinates(), &setup.limits).map_err(refused)?;
    check_validation(&setup.limits, plan.sample_time_s, request.validation_motions).map_err(refused)?;
    for (coordinate, gain) in &request.gains {
        setup.drives.gain[model.coordinate(coordinate)?] = *gain;
    }
    let feedforward = request.feedforward.as_ref().map(|e| Feedforward::new(model, e, &setup.drives.gain));
    let mut feedforward = feedforward.transpose()?;
    let mut run = Run { model, setup: &setup, request, index: 0, take };
    for (e, t) in plan.experiments.iter().zip(&trajectories) {
        run.motion(&e.name, &dynamics, &t.reference(), feedforward.as_ref())?;
    }
    for v in 0..request.validation_motions {
        let reference = validation_motion(&setup.limits, plan.sample_time_s, request.seed, v);
        run.motion(&format!("v{:02}", v + 1), &dynamics, &reference, feedforward.as_ref())?;
    }
    if let Some(load) = &request.load {
        let added = model.added_by(load)?;
        let plus = |x: &[f64]| x.iter().zip(&added).map(|(x, l)| x + l).collect::<Vec<f64>>();
        let loaded = RegressorDynamics::new(model.regressor(), plus(&truth));
        // The load is known: the feedforward carries it.
        feedforward.iter_mut().for_each(|f| f.parameters = plus(&f.parameters));
        for (e, t) in plan.experiments.iter().zip(&trajectories) {
            run.motion(&format!("{}_loaded", e.name), &loaded, &t.reference(), feedforward.as_ref())?;
        }
    }
    Ok(Simulated { truth: truth_of(model, &setup, &truth), notes: setup.notes })
}

/// Motions for validation are at most this many.
const MOST_MOTIONS: usize = 1000;

/// Refuses motions for validation that nobody waits for.
fn check_validation(limits: &[MotionLimits], sample_time: f64, motions: usize) -> Result<(), String> {
    if motions > MOST_MOTIONS {
        return Err(format!("{motions} motions for validation are asked for, at most {MOST_MOTIONS} are made"));
    }
    let motion = ValidationMotion::default();
    let longest = |l: &MotionLimits| motion.seconds(l.position.1 - l.position.0, l.velocity, l.acceleration);
    let longest = limits.iter().map(longest).fold(0.0, f64::max);
    let samples = motion.moves as f64 * longest / sample_time;
    let of = |e: String| format!("a motion for validation within these limits: {e} (--validation 0 makes none)");
    if motions > 0 { check_samples(samples).map_err(of) } else { Ok(()) }
}

/// A motion from point to point at the limits, one a number.
fn validation_motion(limits: &[MotionLimits], sample_time: f64, seed: u64, number: usize) -> Reference {
    let of = |f: &dyn Fn(&MotionLimits) -> f64| limits.iter().map(f).collect::<Vec<f64>>();
    let position: Vec<(f64, f64)> = limits.iter().map(|l| l.position).collect();
    let (velocity, acceleration) = (of(&|l| l.velocity), of(&|l| l.acceleration));
    let mut random = Random::stream(seed ^ 0x76, number as u64);
    let motion = ValidationMotion::default();
    validation_trajectory(&motion, &position, &velocity, &acceleration, sample_time, &mut random)
}

/// One motion after the other, each with noise of its own.
struct Run<'a> {
    model: &'a Model,
    setup: &'a SimulationSetup,
    request: &'a SimulateRequest,
    index: u64,
    take: &'a mut dyn FnMut(&str, &Record) -> Result<(), Error>,
}

impl Run<'_> {
    fn motion(
        &mut self,
        name: &str,
        dynamics: &RegressorDynamics,
        reference: &Reference,
        feedforward: Option<&Feedforward>,
    ) -> Result<(), Error> {
        let noise = (!self.request.noise_free).then_some((self.request.seed, self.index));
        self.index += 1;
        let added = feedforward.map(|f| f.torques(self.model, reference));
        let (record, stop) = self.setup.record(dynamics, reference, added.as_deref(), noise);
        if let Stop::NotPhysical { time } = stop {
            return Err(Error::new(format_args!(
                "{name}: the simulation breaks down at {time:.3} s: the inertial parameters of the file are not \
                 physical, or the robot cannot follow"
            )));
        }
        (self.take)(name, &record)
    }
}

/// The feedforward that the controller adds to its own torque.
struct Feedforward {
    /// Base parameters of the estimate.
    parameters: Vec<f64>,
    /// True gain over estimated gain, one a coordinate: the controller commands currents, torque over estimated gain.
    factor: Vec<f64>,
}

impl Feedforward {
    fn new(model: &Model, estimate: &Estimate, gain: &[f64]) -> Result<Feedforward, Error> {
        let estimated = model.estimated_gains(estimate);
        let factor = gain.iter().zip(estimated).map(|(k, found)| found.map_or(1.0, |found| k / found)).collect();
        Ok(Feedforward { parameters: model.values(estimate)?, factor })
    }

    /// N m, one series a coordinate.
    fn torques(&self, model: &Model, reference: &Reference) -> Vec<Vec<f64>> {
        let mut torques = inverse_dynamics(model.regressor(), &self.parameters, reference);
        for (series, factor) in torques.iter_mut().zip(&self.factor) {
            series.iter_mut().for_each(|t| *t *= factor);
        }
        torques
    }
}

/// The values the logs were made with.
fn truth_of(model: &Model, setup: &SimulationSetup, truth: &[f64]) -> Estimate {
    let regressor = model.regressor();
    let base = |(base, value): (&BaseParameter, &f64)| {
        let parameter = Parameter::from(base);
        let unit = parameter.unit();
        Identified::given(parameter.id, unit, *value)
    };
    let mut parameters: Vec<Identified> = regressor.parameters().iter().zip(truth).map(base).collect();
    for (k, (coordinate, gain)) in regressor.coordinates().iter().zip(&setup.drives.gain).enumerate() {
        let id = ParameterId::drive_gain(coordinate);
        let unit = id.unit(regressor.is_prismatic(k));
        parameters.push(Identified::given(id, unit, *gain));
    }
    Estimate {
        model: model.reference.name.clone(),
        fingerprint: model.reference.fingerprint.clone(),
        description: model.description.clone(),
        method: "simulated with these values".into(),
        parameters,
        ..Estimate::default()
    }
}
