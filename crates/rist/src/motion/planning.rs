//! Plans experiments: chooses the motions that identify the parameters of a model best.
//!
//! A plan is a set of experiments. Candidates are kinds of motion (which joint swings, which joints move along) at the
//! configurations of a grid. The experiments are chosen among the candidates such that the determinant of their information is
//! largest. If the proof of a chosen experiment fails, it is removed, and the choice is repeated.

use claims::significant;
use experiments::excitation::limits::AskedLimits;
use experiments::motion::sample_count::check_samples;
use experiments::plan::candidates::{Candidate, CandidateGrid, MotionLimits, permitted_candidates};
use experiments::plan::exchange::{ExchangeSettings, SearchEffort};
use experiments::plan::exciting_trajectory::ExcitingTrajectory;
use experiments::plan::motion_count::{bytes_of_choice, count_of_kinds};
use experiments::plan::proof_search;
use experiments::plan::ranges::check_limits;
use experiments::simulate::defaults::motion_limits;
use experiments::simulate::dynamics::RegressorDynamics;
use experiments::simulate::setup::SimulationSetup;
use numerics::interruption::Interruption;

pub use experiments::plan::experiment_plan::ExperimentPlan;

pub use crate::request::PlanRequest;

use crate::describe::model::Model;
use crate::error::Error;
use crate::motion::checking::Checked;
use crate::motion::checking_trajectories::CourseCheck;
use crate::motion::exciting::{PROOF_AFTER_INTERRUPTION, refuse_what_is_owed};
use crate::motion::free_memory::free_bytes;
use crate::motion::plan_permission::PlanPermission;
use crate::request::{CheckRequest, Request};

/// A plan, with its assumptions and the proofs of its experiments.
pub struct Planned {
    /// The chosen experiments, and the information that these experiments are expected to give.
    pub plan: ExperimentPlan,
    /// Sentences on assumptions about values that the description lacks.
    pub notes: Vec<String>,
    /// For each experiment, its name and its proved limits.
    pub checked: Vec<(String, Checked)>,
}

/// CPU time, s, to check the limits of one motion and compute its regression rows, divided by (coordinates x base parameters),
/// for a rough forecast. Measured on two cores of an AMD EPYC (2026-11-26): for a chain of 14 joints, 4.6e-6 with 60
/// configurations and 5.6e-6 with 20; for a UR5, whose plan takes only seconds, 7.5e-6 with 60 configurations and 9.8e-6 with
/// 200.
const S_PER_ROWS: f64 = 5e-6;
/// CPU time, s, to choose among the motions, divided by (motions x coordinates x base parameters x starts x experiments).
/// Measured: 4.4e-8 on a chain of 14 joints, less on a UR5.
const S_PER_CHOICE: f64 = 4e-8;
/// CPU time above which a forecast is printed, s.
const FORECAST_TIME_S: f64 = 60.0;
/// Memory above which the forecast names the memory, bytes.
const FORECAST_MEMORY_BYTES: f64 = 1e9;

/// A forecast of the number of motions and of the time of a plan; `None` if the plan takes less than a minute of CPU time.
///
/// Fails if the choice needs more memory than the machine has free (if this is known).
pub fn cost_forecast(model: &Model, request: &PlanRequest) -> Result<Option<String>, Error> {
    cost_forecast_within(model, request, free_bytes())
}

/// The forecast for a machine with `free` bytes of free memory; `None` if this number is unknown.
fn cost_forecast_within(model: &Model, request: &PlanRequest, free: Option<f64>) -> Result<Option<String>, Error> {
    let (n, p) = (model.regressor().coordinates().len(), model.regressor().parameters().len());
    let has_gravity = grid_of(model, request).gravity;
    let kinds = count_of_kinds(n, has_gravity);
    // There are at most as many configurations as points of the grid.
    let points = request.steps.checked_pow(u32::try_from(n).unwrap_or(u32::MAX)).unwrap_or(usize::MAX);
    let configurations = request.configurations.min(points);
    let motions = kinds.saturating_mul(configurations);
    let bytes = bytes_of_choice(n, p, has_gravity, configurations);
    let choices = (request.starts * request.experiments) as f64;
    let seconds = (S_PER_ROWS + S_PER_CHOICE * choices) * (n * p) as f64 * motions as f64;
    let what = format!("{kinds} kinds of motion about {configurations} configurations are {motions} motions");
    let remedy = "lower [configurations] or [starts], or hold joints still in a description with fewer of them";
    let gigabytes = |bytes: f64| format!("{} GB", significant(bytes / 1e9, 2));
    if let Some(free) = free.filter(|free| bytes > *free) {
        let (needs, has) = (gigabytes(bytes), gigabytes(free));
        let path = model.path.display();
        return Err(Error::new(format_args!(
            "{path}: {what}, which take {needs} of memory, and {has} are free: {remedy}"
        )));
    }
    let memory =
        if bytes > FORECAST_MEMORY_BYTES { format!(" and {} of memory", gigabytes(bytes)) } else { String::new() };
    let minutes = (seconds / 60.0).ceil();
    Ok((seconds > FORECAST_TIME_S)
        .then(|| format!("{what}: the plan takes about {minutes:.0} minutes of CPU time{memory}; {remedy}")))
}

/// Largest number of times that a plan is chosen. Each choice omits the experiments whose proof failed before.
const LARGEST_NUMBER_OF_CHOICES: usize = 10;

/// Chooses the experiments with the largest determinant (or the smallest condition number) of their information. Each
/// experiment keeps the limits of the description and of the request on torques and bodies, and these limits are proved.
/// `progress`: number of finished starts, number of all starts, best value.
///
/// Fails if a number of the request or a limit of the description is out of range, if the limits exclude every motion, or if a
/// requirement of the request cannot be checked. If the user interrupts the search, it returns the best plan found.
pub fn plan(
    model: &Model,
    request: &PlanRequest,
    progress: &(dyn Fn(usize, usize, f64) + Sync),
) -> Result<Planned, Error> {
    check(request)?;
    if request.nodes > 0 {
        proof_search::registered().map_err(|why| Error::new(format_args!("[nodes={}]: {why}", request.nodes)))?;
    }
    cost_forecast(model, request)?;
    let of_check = CheckRequest { limits: request.limits.clone(), ..CheckRequest::default() };
    let held = CourseCheck::of_plans(model, &of_check)?;
    refuse_what_is_owed(model, &held.left_out())?;
    // The limits of candidates are checked only at instants. Later, the proof also checks the limits between instants.
    let Candidates { mut candidates, mut notes, noise } = candidates_of(model, request, &held)?;
    let threads = processor::threads();
    let search = SearchEffort {
        starts: request.starts,
        threads,
        seed: request.seed,
        nodes: request.nodes,
        ..SearchEffort::default()
    };
    let choice = ExchangeSettings { count: request.experiments, criterion: request.criterion, search };
    let mut left_out = 0;
    for _ in 0..LARGEST_NUMBER_OF_CHOICES {
        let (robot, regressor) = (model.reference.clone(), model.regressor());
        let plan = ExperimentPlan::choose(robot, regressor, &candidates, &noise, &choice, progress);
        if Interruption::take() {
            if plan.experiments.is_empty() {
                return Err(Error::new("interrupted before there was a plan"));
            }
            notes.push("the search was interrupted: this is the best plan up to there".into());
            Interruption::here().raise_within(PROOF_AFTER_INTERRUPTION);
        }
        let experiments = plan.trajectories("the plan")?;
        let proofs: Vec<Checked> = experiments.iter().map(|experiment| held.experiment(experiment)).collect();
        Interruption::check()?;
        // Experiments whose proof fails are removed from the candidates, and the choice is repeated.
        let failed: Vec<&ExcitingTrajectory> =
            experiments.iter().zip(&proofs).filter(|(_, proof)| !proof.is_proven()).map(|(e, _)| e).collect();
        if failed.is_empty() {
            if left_out > 0 {
                notes.push(format!("experiments left out since a limit is not kept between instants: {left_out}"));
            }
            let checked = plan.experiments.iter().map(|e| e.name.clone()).zip(proofs).collect();
            return Ok(Planned { plan, notes, checked });
        }
        let before = candidates.len();
        candidates.retain(|candidate| !failed.contains(&&candidate.trajectory));
        left_out += before - candidates.len();
        if candidates.is_empty() {
            break;
        }
    }
    Err(no_motion(model))
}

fn no_motion(model: &Model) -> Error {
    Error::new(format_args!(
        "{}: no motion keeps the limits: widen the limits of position, or raise [steps], or [effort_share] where torques are near \
         their limits; for links that may meet, sign the pair in [limits=FILE]: space: accept: [[LINK, LINK, REASON]]",
        model.path.display()
    ))
}

/// The motions from which the experiments are chosen.
struct Candidates {
    candidates: Vec<Candidate>,
    /// Sentences on assumptions about values that the description lacks.
    notes: Vec<String>,
    /// Noise of a torque sample, N m (N), one per coordinate.
    noise: Vec<f64>,
}

/// Time from rest to the largest velocity, s, assumed if a velocity limit but no acceleration limit is given.
const RISE_S: f64 = 0.3;

/// Noise (sigma) of a torque sample if the description has no inertial parameters, N m (N).
const DEFAULT_TORQUE_NOISE: f64 = 0.1;

/// The limits of the motions of a plan, from the description and the user's file. If neither gives a limit, the limit is
/// assumed. Also returns sentences on these assumptions.
fn limits_of(model: &Model, asked: &[AskedLimits]) -> (Vec<MotionLimits>, Vec<String>) {
    let mut robot = model.robot.clone();
    let mut quick = Vec::new();
    for (coordinate, asked) in robot.coordinates.iter_mut().zip(asked) {
        // A locked coordinate gets a range here, so that no note mentions missing limits. The range is replaced below.
        let around = asked.locked.map(|q| (q - 1.0, q + 1.0));
        if asked.acceleration.is_none() && asked.velocity.is_some() {
            quick.push(coordinate.name.clone());
        }
        coordinate.limits = robot::Limits {
            position: around.or(asked.position),
            velocity: asked.velocity,
            acceleration: asked.acceleration.or(asked.velocity.map(|velocity| velocity / RISE_S)),
            effort: asked.effort,
        };
    }
    let (mut limits, mut notes) = motion_limits(&robot);
    for (limits, asked) in limits.iter_mut().zip(asked) {
        limits.position = asked.locked.map_or(limits.position, |q| (q, q));
    }
    if !quick.is_empty() {
        let names = quick.join(", ");
        notes.push(format!("{names}: no greatest acceleration given, the greatest velocity in {RISE_S} s assumed"));
    }
    (limits, notes)
}

fn candidates_of(model: &Model, request: &PlanRequest, held: &CourseCheck) -> Result<Candidates, Error> {
    let (limits, mut notes) = limits_of(model, &held.asked);
    check_limits(model.regressor().coordinates(), &limits)
        .map_err(|e| Error::new(format_args!("{}: {e}", model.path.display())))?;
    // The noise of a torque sample is a share of the largest acceleration torque (mean inertia times acceleration limit), so
    // this noise needs inertial parameters.
    let noise = match model.nominal_parameters() {
        Some(truth) => {
            let dynamics = RegressorDynamics::new(model.regressor(), truth);
            SimulationSetup::for_robot(&model.robot, &dynamics).sensing.torque_noise
        }
        None => {
            notes.push("no inertial parameters in the file: torque noise of 0.1 N m (N) a sample assumed".into());
            vec![DEFAULT_TORQUE_NOISE; limits.len()]
        }
    };
    let grid = grid_of(model, request);
    let permission = PlanPermission::new(model, &held.asked, request.effort_share, &held.known, &held.surroundings);
    let candidates = permitted_candidates(&grid, &limits, model.regressor(), &noise, &permission);
    Interruption::check()?;
    if candidates.is_empty() {
        return Err(no_motion(model));
    }
    Ok(Candidates { candidates, notes, noise })
}

fn grid_of(model: &Model, request: &PlanRequest) -> CandidateGrid {
    CandidateGrid {
        profile: request.profile,
        steps: request.steps,
        configurations: request.configurations,
        duration: request.duration,
        sample_time: 1.0 / request.rate,
        gravity: model.robot.gravity_number() != [0.0; 3],
        seed: request.seed,
    }
}

/// Fails if a number of the request is unusable, or if an experiment has too many samples.
fn check(request: &PlanRequest) -> Result<(), Error> {
    request.check()?;
    check_samples(request.rate * request.duration).map_err(|e| Error::new(format_args!("[rate] and [duration]: {e}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A model of a chain of `n` revolute joints about the axes x, y, z in turn.
    fn chain(n: usize) -> Model {
        let link = |k: usize| {
            format!(
                "<link name='l{k}'><inertial><origin xyz='0.1 0.02 0.1'/><mass value='1'/>\
                 <inertia ixx='0.01' iyy='0.02' izz='0.02' ixy='0' ixz='0' iyz='0'/></inertial></link>"
            )
        };
        let joint = |k: usize| {
            let axis = ["1 0 0", "0 1 0", "0 0 1"][k % 3];
            format!(
                "<joint name='j{k}' type='revolute'><parent link='l{}'/><child link='l{k}'/><origin xyz='0 0 0.2'/>\
                 <axis xyz='{axis}'/><limit lower='-1' upper='1' velocity='1' effort='50'/></joint>",
                k - 1
            )
        };
        let (links, joints): (String, String) = ((0..=n).map(link).collect(), (1..=n).map(joint).collect());
        let text = format!("<robot name='chain'>{links}{joints}</robot>");
        Model::parse(&text, std::path::Path::new("chain.urdf"), &Default::default()).unwrap()
    }

    #[test]
    fn a_long_plan_is_told_before() {
        let (short, long) = (chain(4), chain(12));
        let request = PlanRequest::default();
        assert_eq!(cost_forecast(&short, &request).unwrap(), None);
        let many = PlanRequest { starts: 100, ..request.clone() };
        let forecast = cost_forecast(&long, &many).unwrap().expect("minutes");
        // 167 kinds of motion: 12 for inertia, 12 for gravity, 11 mixed, 12 x 11 with one companion joint.
        assert!(forecast.starts_with("167 kinds of motion about 60 configurations are 10020 motions: "), "{forecast}");
        assert!(forecast.contains(" minutes of CPU time; lower [configurations] or [starts]"), "{forecast}");
        // With one start, computing the rows takes most of the time: 80 CPU s were measured on a chain of 14 joints.
        let few = PlanRequest { starts: 1, ..request.clone() };
        let forecast = cost_forecast(&chain(14), &few).unwrap().expect("minutes");
        assert!(forecast.contains(" 2 minutes of CPU time"), "{forecast}");
        let endless = PlanRequest { configurations: 100_000, ..request };
        let refused = cost_forecast_within(&long, &endless, Some(8e9)).unwrap_err().to_string();
        assert!(refused.contains(" GB of memory, and 8 GB are free: lower [configurations]"), "{refused}");
        // If the free memory is unknown, the forecast gives the memory that the plan needs.
        let forecast = cost_forecast_within(&long, &endless, None).unwrap().expect("hours");
        assert!(forecast.contains(" minutes of CPU time and ") && forecast.contains(" GB of memory; "), "{forecast}");
    }

    #[test]
    fn memory_is_that_of_the_rows() {
        let model = chain(6);
        let request = PlanRequest { configurations: 5, ..PlanRequest::default() };
        let (n, p) = (6, model.regressor().parameters().len());
        let of_check = CheckRequest::default();
        let held = CourseCheck::of_plans(&model, &of_check).unwrap();
        let candidates = candidates_of(&model, &request, &held).unwrap().candidates;
        let rows: usize = candidates.iter().map(|c| c.raw.len() + c.information.len()).sum();
        let estimated = bytes_of_choice(n, p, true, 5);
        let five_copies = 2.5 * (rows * p * size_of::<f64>()) as f64;
        assert!(candidates.len() as f64 > 0.9 * (count_of_kinds(n, true) * 5) as f64, "{}", candidates.len());
        assert!(five_copies <= estimated && estimated < 1.5 * five_copies, "{five_copies} {estimated}");
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        check(&PlanRequest::default()).unwrap();
        for (request, said) in [
            (PlanRequest { rate: f64::NAN, ..PlanRequest::default() }, "[rate]"),
            (PlanRequest { experiments: usize::MAX, ..PlanRequest::default() }, "[experiments]"),
        ] {
            let refused = check(&request).unwrap_err().to_string();
            assert!(refused.contains(said), "{refused}");
        }
    }
}
