//! `rist plan`: a model -> the experiments that identify it best.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use identification::experiments::candidates::{CandidateGrid, candidates};
use identification::experiments::exchange::{Criterion, Search};
use identification::experiments::experiment_plan::ExperimentPlan;
use identification::experiments::profile::Profile;
use identification::experiments::trajectory_file::{TrajectoryFormat, trajectory_file};
use identification::simulate::dynamics::RegressorDynamics;
use identification::simulate::setup::{SimulationSetup, motion_limits};

use crate::failure::{Failure, print, write_file};
use crate::model::ModelArguments;
use crate::spectrum::{Subject, make_directory};

/// Plan the exciting experiments of identification by spectrum analysis
///
/// Chooses, from every kind of motion about a grid of configurations, the set with the greatest determinant (or
/// the least condition number) of its information, and says how far from the best possible it can be.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// Number of experiments
    #[arg(long, short = 'n', default_value_t = 8)]
    experiments: usize,

    #[arg(long, value_enum, default_value_t = CriterionWord::Determinant)]
    criterion: CriterionWord,

    #[arg(long, value_enum, default_value_t = ProfileWord::BangBang)]
    profile: ProfileWord,

    /// Configurations a coordinate
    #[arg(long, default_value_t = 5)]
    steps: usize,

    /// At most this many configurations a kind of motion
    #[arg(long, default_value_t = 60)]
    configurations: usize,

    /// Seconds recorded in one experiment
    #[arg(long, default_value_t = 4.0)]
    duration: f64,

    /// Sample rate of the controller, Hz
    #[arg(long, default_value_t = 1000.0)]
    rate: f64,

    /// Starts of the search
    #[arg(long, default_value_t = 12)]
    starts: usize,

    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// Write the plan as YAML
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Write each motion for a controller to play into this directory
    #[arg(long, value_name = "DIRECTORY")]
    trajectories: Option<PathBuf>,

    #[arg(long, value_enum, default_value_t = FormatWord::Csv)]
    format: FormatWord,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum CriterionWord {
    Determinant,
    Condition,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ProfileWord {
    BangBang,
    Smooth,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FormatWord {
    Csv,
    RosYaml,
    RosJson,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let positive = |x: f64, what: &str| match x.is_finite() && x > 0.0 {
        true => Ok(x),
        false => Err(Failure::new(format_args!("{what} must be a positive number, not {x}"))),
    };
    let rate = positive(arguments.rate, "--rate")?;
    let duration = positive(arguments.duration, "--duration")?;
    let subject = Subject::read(&arguments.model)?;
    let regressor = subject.regressor.as_ref();
    let (limits, mut notes) = motion_limits(&subject.robot);
    let noise = match subject.truth() {
        Some(truth) => {
            let dynamics = RegressorDynamics::new(regressor, truth);
            SimulationSetup::for_robot(&subject.robot, &dynamics).sensing.torque_noise
        }
        None => {
            notes.push("no inertial parameters in the file: torque noise of 0.1 N m assumed".into());
            vec![0.1; limits.len()]
        }
    };
    let grid = CandidateGrid {
        profile: match arguments.profile {
            ProfileWord::BangBang => Profile::BangBang,
            ProfileWord::Smooth => Profile::Smooth,
        },
        steps: arguments.steps,
        configurations: arguments.configurations,
        duration,
        sample_time: 1.0 / rate,
        gravity: subject.robot.gravity_number() != [0.0; 3],
        seed: arguments.seed,
    };
    let candidates = candidates(&grid, &limits, regressor, &noise);
    if candidates.is_empty() {
        return Err(Failure::new("the limits leave no motion: widen them in the model, or raise --steps"));
    }
    let criterion = match arguments.criterion {
        CriterionWord::Determinant => Criterion::Determinant,
        CriterionWord::Condition => Criterion::FrobeniusCondition,
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let search = Search { starts: arguments.starts.max(1), threads, seed: arguments.seed, ..Search::default() };
    let progress = |done: usize, all: usize, best: f64| eprintln!("start {done} of {all}, best {best:.3}");
    let reference = subject.reference.clone();
    let plan = ExperimentPlan::choose(
        reference,
        regressor,
        &candidates,
        &noise,
        arguments.experiments,
        criterion,
        &search,
        &progress,
    );
    let notes: String = notes.iter().map(|n| format!("note: {n}\n")).collect();
    print(&format!("{notes}{plan}"))?;
    if let Some(directory) = &arguments.trajectories {
        make_directory(directory)?;
        let (format, end) = match arguments.format {
            FormatWord::Csv => (TrajectoryFormat::Csv, "csv"),
            FormatWord::RosYaml => (TrajectoryFormat::RosYaml, "yaml"),
            FormatWord::RosJson => (TrajectoryFormat::RosJson, "json"),
        };
        for (e, t) in plan.experiments.iter().zip(plan.trajectories("plan")?) {
            let text = trajectory_file(&t.reference(), &plan.coordinates, rate, format);
            write_file(&directory.join(format!("{}.{end}", e.name)), &text)?;
        }
    }
    match &arguments.out {
        Some(out) => write_file(out, &plan.to_yaml()?),
        None => Ok(()),
    }
}
