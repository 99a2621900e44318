//! From a model to the experiments that identify it best.

use experiments::motion::sample_count::check_samples;
use experiments::plan::candidates::{Candidate, CandidateGrid, candidates};
use experiments::plan::exchange::Search;
use experiments::plan::ranges::check_limits;
use experiments::simulate::defaults::motion_limits;
use experiments::simulate::dynamics::RegressorDynamics;
use experiments::simulate::setup::SimulationSetup;
use numerics::interruption::Interruption;

pub use experiments::plan::experiment_plan::ExperimentPlan;

pub use crate::request::PlanRequest;

use crate::error::Error;
use crate::model::Model;
use crate::request::Request;

/// A plan, and the assumptions behind it.
pub struct Planned {
    /// The chosen experiments with their expected information.
    pub plan: ExperimentPlan,
    /// Sentences on what the description does not say.
    pub notes: Vec<String>,
}

/// Chooses the experiments with the greatest determinant (or the least condition number) of their information.
/// `progress`: starts done, starts, best value.
///
/// Fails where a number of the request or a limit of the description is out of range, and where the limits leave no
/// motion. If it is interrupted during the search, it gives the best plan found.
pub fn plan(
    model: &Model,
    request: &PlanRequest,
    progress: &(dyn Fn(usize, usize, f64) + Sync),
) -> Result<Planned, Error> {
    let Candidates { candidates, mut notes, noise } = candidates_of(model, request)?;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let search =
        Search { starts: request.starts, threads, seed: request.seed, nodes: request.nodes, ..Search::default() };
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
    if Interruption::take() {
        if plan.experiments.is_empty() {
            return Err(Error::new("interrupted before there was a plan"));
        }
        notes.push("the search was interrupted: this is the best plan up to there".into());
    }
    Ok(Planned { plan, notes })
}

/// The motions to choose from.
struct Candidates {
    candidates: Vec<Candidate>,
    /// The assumptions behind them.
    notes: Vec<String>,
    /// Noise of a torque sample, N m (N), one per coordinate.
    noise: Vec<f64>,
}

fn candidates_of(model: &Model, request: &PlanRequest) -> Result<Candidates, Error> {
    check(request)?;
    let (limits, mut notes) = motion_limits(&model.robot);
    check_limits(model.regressor().coordinates(), &limits)
        .map_err(|e| Error::new(format_args!("{}: {e}", model.path.display())))?;
    // Torque noise is a share of the effort, which needs inertial parameters.
    let noise = match model.described_parameters() {
        Some(truth) => {
            let dynamics = RegressorDynamics::new(model.regressor(), truth);
            SimulationSetup::for_robot(&model.robot, &dynamics).sensing.torque_noise
        }
        None => {
            notes.push("no inertial parameters in the file: torque noise of 0.1 N m (N) a sample assumed".into());
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
    Interruption::check()?;
    if candidates.is_empty() {
        return Err(Error::new("the limits leave no motion: widen them in the model, or raise [steps]"));
    }
    Ok(Candidates { candidates, notes, noise })
}

/// Refuses more experiments than anybody runs, and more candidates than a machine holds.
fn check(request: &PlanRequest) -> Result<(), Error> {
    request.check()?;
    check_samples(request.rate * request.duration).map_err(|e| Error::new(format_args!("[rate] and [duration]: {e}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rates and counts that no controller has are refused before anything is computed.
    #[test]
    fn numbers_out_of_range_are_refused() {
        check(&PlanRequest::default()).unwrap();
        for (request, said) in [
            (PlanRequest { rate: 1e300, ..PlanRequest::default() }, "[rate]"),
            (PlanRequest { rate: f64::NAN, ..PlanRequest::default() }, "[rate]"),
            (PlanRequest { duration: 0.0, ..PlanRequest::default() }, "[duration]"),
            (PlanRequest { experiments: usize::MAX, ..PlanRequest::default() }, "[experiments]"),
            (PlanRequest { steps: 0, ..PlanRequest::default() }, "[steps]"),
            (PlanRequest { nodes: 1_000_001, ..PlanRequest::default() }, "[nodes]"),
            (PlanRequest { rate: 2e4, duration: 3000.0, ..PlanRequest::default() }, "samples"),
        ] {
            let refused = check(&request).unwrap_err().to_string();
            assert!(refused.contains(said), "{refused}");
        }
    }
}
