//! `rist simulate`: a model and a plan -> the logs its experiments would give.

use std::path::{Path, PathBuf};

use clap::Args;
use identification::algebra::random::Random;
use identification::estimate::artefact::{Estimate, Identified};
use identification::experiments::exciting_trajectory::Reference;
use identification::experiments::experiment_plan::ExperimentPlan;
use identification::experiments::point_to_point::{ValidationMotion, validation_trajectory};
use identification::simulate::closed_loop::Stop;
use identification::simulate::dynamics::{Dynamics, RegressorDynamics, inverse_dynamics};
use identification::simulate::setup::SimulationSetup;
use logs::Effort;

use crate::failure::{Failure, print, write_file};
use crate::model::ModelArguments;
use crate::spectrum::{Subject, make_directory, read_text};

/// Simulate the experiments of a plan, in closed loop, with friction, noise and drive gains
///
/// Writes a log an experiment, validation logs of motions the plan does not have, and truth.yaml with the
/// parameters behind them.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The plan
    plan: PathBuf,

    /// Directory of the logs
    #[arg(long, value_name = "DIRECTORY", default_value = "logs")]
    out: PathBuf,

    /// Number of validation motions
    #[arg(long, default_value_t = 10)]
    validation: usize,

    /// Torque per unit of current of a drive, N m/A [default: as the file says, or 1]
    #[arg(long, value_name = "COORDINATE=GAIN", value_delimiter = ',')]
    gain: Vec<String>,

    /// A known load (as of `rist identify`): every experiment is done again with it, e01_loaded.csv, ..
    #[arg(long, value_name = "FILE")]
    load: Option<PathBuf>,

    /// An estimate whose torques (inverse dynamics, no friction) the controller adds: identify -> feedforward -> repeat
    #[arg(long, value_name = "FILE")]
    feedforward: Option<PathBuf>,

    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// Neither noise nor rounding of the sensors
    #[arg(long)]
    noise_free: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let subject = Subject::read(&arguments.model)?;
    let file = arguments.plan.display().to_string();
    let plan = ExperimentPlan::from_yaml(&file, &read_text(&arguments.plan)?)?;
    subject.check(&arguments.plan, &plan.model.name, &plan.model.fingerprint)?;
    let trajectories = plan.trajectories(&file)?;
    let Some(truth) = subject.truth() else {
        return Err(Failure::new(format_args!(
            "{}: no link has inertial parameters; give standard_parameters to simulate with",
            arguments.model.model.display()
        )));
    };
    let dynamics = RegressorDynamics::new(subject.regressor.as_ref(), truth.clone());
    let mut setup = SimulationSetup::for_robot(&subject.robot, &dynamics);
    for text in &arguments.gain {
        let (k, gain) = subject.gain_of(text)?;
        setup.drives.gain[k] = gain;
    }
    make_directory(&arguments.out)?;
    let coordinates = subject.regressor.coordinates();
    let mut index = 0;
    let mut feedforward = match &arguments.feedforward {
        Some(file) => Some(Feedforward::read(&subject, file, &setup.drives.gain)?),
        None => None,
    };
    let mut write = |name: &str,
                     dynamics: &dyn Dynamics,
                     reference: &Reference,
                     feedforward: &Option<Feedforward>|
     -> Result<(), Failure> {
        let noise = (!arguments.noise_free).then_some((arguments.seed, index));
        index += 1;
        let added = feedforward.as_ref().map(|f| f.torques(&subject, reference));
        let (record, stop) = setup.record(dynamics, reference, added.as_deref(), noise);
        if let Stop::NotPhysical { time } = stop {
            return Err(Failure::new(format_args!(
                "{name}: the simulation breaks down at {time:.3} s: the inertial parameters of the file are not \
                 physical, or the robot cannot follow"
            )));
        }
        write_file(&arguments.out.join(format!("{name}.csv")), &record.to_csv(coordinates, Effort::Current))
    };
    for (e, t) in plan.experiments.iter().zip(&trajectories) {
        write(&e.name, &dynamics, &t.reference(), &feedforward)?;
    }
    let of = |f: &dyn Fn(&identification::experiments::candidates::MotionLimits) -> f64| {
        setup.limits.iter().map(f).collect::<Vec<f64>>()
    };
    let position: Vec<(f64, f64)> = setup.limits.iter().map(|l| l.position).collect();
    let (velocity, acceleration) = (of(&|l| l.velocity), of(&|l| l.acceleration));
    for v in 0..arguments.validation {
        let mut random = Random::stream(arguments.seed ^ 0x76, v as u64);
        let motion = ValidationMotion::default();
        let reference =
            validation_trajectory(&motion, &position, &velocity, &acceleration, plan.sample_time_s, &mut random);
        write(&format!("v{:02}", v + 1), &dynamics, &reference, &feedforward)?;
    }
    if let Some(file) = &arguments.load {
        let (_, added) = subject.load(file)?;
        let plus = |x: &[f64]| x.iter().zip(&added).map(|(x, l)| x + l).collect::<Vec<f64>>();
        let loaded = RegressorDynamics::new(subject.regressor.as_ref(), plus(&truth));
        // The load is known: the feedforward carries it.
        feedforward.iter_mut().for_each(|f| f.parameters = plus(&f.parameters));
        for (e, t) in plan.experiments.iter().zip(&trajectories) {
            write(&format!("{}_loaded", e.name), &loaded, &t.reference(), &feedforward)?;
        }
    }
    write_file(&arguments.out.join("truth.yaml"), &truth_of(&subject, &setup, &truth).to_yaml()?)?;
    let notes: String = setup.notes.iter().map(|n| format!("note: {n}\n")).collect();
    let (mut count, all) = (trajectories.len().to_string(), arguments.validation);
    if arguments.load.is_some() {
        count += " experiments, as many with the load,";
    } else {
        count += " experiments";
    }
    print(&format!("{notes}{count} and {all} validation motions in {}\n", arguments.out.display()))
}

/// What the controller adds to its own torque.
struct Feedforward {
    /// Base parameters of the estimate.
    parameters: Vec<f64>,
    /// True gain over estimated gain, one a coordinate: the controller commands currents, torque over estimated gain.
    factor: Vec<f64>,
}

impl Feedforward {
    fn read(subject: &Subject, file: &Path, gain: &[f64]) -> Result<Feedforward, Failure> {
        let estimate = Estimate::from_yaml(&file.display().to_string(), &read_text(file)?)?;
        subject.check(file, &estimate.model, &estimate.fingerprint)?;
        let estimated = subject.estimated_gains(&estimate);
        let factor = gain.iter().zip(estimated).map(|(k, found)| found.map_or(1.0, |found| k / found)).collect();
        Ok(Feedforward { parameters: subject.parameters(&estimate), factor })
    }

    /// N m, one series a coordinate.
    fn torques(&self, subject: &Subject, reference: &Reference) -> Vec<Vec<f64>> {
        let mut torques = inverse_dynamics(subject.regressor.as_ref(), &self.parameters, reference);
        for (series, factor) in torques.iter_mut().zip(&self.factor) {
            series.iter_mut().for_each(|t| *t *= factor);
        }
        torques
    }
}

/// The values the logs were made with.
fn truth_of(subject: &Subject, setup: &SimulationSetup, truth: &[f64]) -> Estimate {
    let value = |name: String, value: f64| Identified { name, value: Some(value), ..Identified::default() };
    let names = subject.regressor.parameters().iter().cloned();
    let mut parameters: Vec<Identified> = names.zip(truth).map(|(n, x)| value(n, *x)).collect();
    for (c, gain) in subject.regressor.coordinates().iter().zip(&setup.drives.gain) {
        parameters.push(value(format!("drive gain of {c}"), *gain));
    }
    Estimate {
        model: subject.reference.name.clone(),
        fingerprint: subject.reference.fingerprint.clone(),
        method: "simulated with these values".into(),
        parameters,
        ..Estimate::default()
    }
}
