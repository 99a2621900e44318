//! From a model to the experiments that identify it best.

use identification::experiments::candidates::{CandidateGrid, candidates};
use identification::experiments::exchange::{Criterion, Search};
use identification::experiments::profile::Profile;
use identification::simulate::dynamics::RegressorDynamics;
use identification::simulate::setup::{SimulationSetup, motion_limits};

use crate::ExperimentPlan;
use crate::error::Error;
use crate::model::Model;

/// Which experiments are looked for.
#[derive(Clone, Debug)]
pub struct PlanRequest {
    /// Number of experiments.
    pub experiments: usize,
    /// Criterion by which plans are compared.
    pub criterion: Criterion,
    /// How swings change their velocity.
    pub profile: Profile,
    /// Configurations a coordinate.
    pub steps: usize,
    /// At most this many configurations a kind of motion.
    pub configurations: usize,
    /// s recorded in one experiment.
    pub duration: f64,
    /// Hz, of the controller.
    pub rate: f64,
    /// Starts of the search.
    pub starts: usize,
    /// Seed of the random starts.
    pub seed: u64,
}

impl Default for PlanRequest {
    fn default() -> PlanRequest {
        PlanRequest {
            experiments: 8,
            criterion: Criterion::Determinant,
            profile: Profile::BangBang,
            steps: 5,
            configurations: 60,
            duration: 4.0,
            rate: 1000.0,
            starts: 12,
            seed: 1,
        }
    }
}

/// A plan, and what had to be assumed for it.
pub struct Planned {
    /// The chosen experiments with what they promise.
    pub plan: ExperimentPlan,
    /// Sentences on what the description does not say.
    pub notes: Vec<String>,
}

/// Chooses the experiments with the greatest determinant (or the least condition number) of their information.
/// `progress`: starts done, starts, best value.
///
/// Fails where a number of the request is not positive, and where the limits leave no motion.
pub fn plan(
    model: &Model,
    request: &PlanRequest,
    progress: &(dyn Fn(usize, usize, f64) + Sync),
) -> Result<Planned, Error> {
    for (x, what) in [(request.rate, "--rate"), (request.duration, "--duration")] {
        if !(x.is_finite() && x > 0.0) {
            return Err(Error::new(format_args!("{what} must be a positive number, not {x}")));
        }
    }
    let (limits, mut notes) = motion_limits(&model.robot);
    let noise = match model.described_parameters() {
        Some(truth) => {
            let dynamics = RegressorDynamics::new(model.regressor(), truth);
            SimulationSetup::for_robot(&model.robot, &dynamics).sensing.torque_noise
        }
        None => {
            notes.push("no inertial parameters in the file: torque noise of 0.1 N m assumed".into());
            vec![0.1; limits.len()]
        }
    };
    let grid = CandidateGrid {
        profile: request.profile,
        steps: request.steps,
        configurations: request.configurations,
        duration: request.duration,
        sample_time: 1.0 / request.rate,
        gravity: model.robot.gravity_number() != [0.0; 3],
        seed: request.seed,
    };
    let candidates = candidates(&grid, &limits, model.regressor(), &noise);
    if candidates.is_empty() {
        return Err(Error::new("the limits leave no motion: widen them in the model, or raise --steps"));
    }
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let search = Search { starts: request.starts.max(1), threads, seed: request.seed, ..Search::default() };
    let plan = ExperimentPlan::choose(
        model.reference.clone(),
        model.regressor(),
        &candidates,
        &noise,
        request.experiments,
        request.criterion,
        &search,
        progress,
    );
    Ok(Planned { plan, notes })
}
