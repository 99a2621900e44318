//! `rist simulate`: simulates a plan or a motion, and writes logs.
//!
//! The motions are simulated in closed loop, with friction, noise and drive gains. Output: one log per motion (a record), and
//! the true parameters as an estimate.

use std::path::{Path, PathBuf};

use clap::Args;
use rist::Record;
use rist::motion::simulation::{Motions, SimulateRequest};
use serde_json::json;

use crate::artefact::{MotionFile, check_outputs, make_directory, model_of, read_motions, write_file};
use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::terminal::{self, at_work, print_result};

/// Simulate a plan or an exciting motion in closed loop, with friction and noise
///
/// Writes one log per experiment (or motion.csv), logs of other motions for validation, and truth.yaml with the true
/// parameters and friction. With --load, also writes logs with this load, and truth_loaded.yaml with the true parameters of
/// the robot with the load. The logs contain currents, or torques if no drive gain is known.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The plan of `rist plan`, or the motion of `rist excite`
    #[arg(value_name = "PLAN|MOTION")]
    motions: PathBuf,

    /// Directory for the logs
    #[arg(long, value_name = "DIRECTORY", default_value = "logs")]
    out: PathBuf,

    #[command(flatten)]
    request: Flags<SimulateRequest>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let request = arguments.request.read()?;
    let model = match &request.feedforward {
        Some(estimate) => model_of(estimate, arguments.request.file("feedforward"), &arguments.model)?,
        None => arguments.model.derive()?,
    };
    let file = read_motions(&arguments.motions, &model)?;
    let of_user = [&arguments.model.model, &arguments.motions].into_iter().map(PathBuf::as_path);
    let inputs: Vec<&Path> = of_user.chain(arguments.request.files()).collect();
    make_directory(&arguments.out)?;
    let [truth, loaded_truth] = ["truth.yaml", "truth_loaded.yaml"].map(|name| arguments.out.join(name));
    check_outputs([&truth, &loaded_truth], &inputs)?;
    let coordinates = model.regressor().coordinates();
    let (motions, count) = match &file {
        MotionFile::Plan(plan) => (Motions::from(plan.as_ref()), format!("{} experiments", plan.experiments.len())),
        MotionFile::Motion(motion) => (Motions::from(motion.as_ref()), "1 motion".into()),
    };
    let effort = request.effort(&model);
    let mut written = Vec::new();
    // Each record is written as soon as the simulation of its motion ends.
    let mut write = |name: &str, record: &Record| {
        let (text, file) = (record.to_csv(coordinates, effort), arguments.out.join(format!("{name}.csv")));
        at_work(format_args!("simulating: {} is written", file.display()));
        write_file(&file, &text)?;
        written.push(file.display().to_string());
        Ok(())
    };
    at_work("simulating");
    let found = rist::simulate(&model, motions, &request, &mut write)?;
    write_file(&truth, &found.truth.to_yaml()?)?;
    if let Some(loaded) = &found.loaded_truth {
        write_file(&loaded_truth, &loaded.to_yaml()?)?;
    }
    let loaded_truth = found.loaded_truth.as_ref().map(|_| loaded_truth.display().to_string());
    let (truth, notes) = (truth.display().to_string(), &found.notes);
    let lines = terminal::notes(notes);
    let with_load = if request.load.is_some() { ", as many with the load," } else { "" };
    let (validation, out) = (request.validation, arguments.out.display());
    print_result(format_args!("{lines}{count}{with_load} and {validation} validation motions in {out}\n"), || {
        Ok(json!({"notes": notes, "logs": written, "truth": truth, "truth_loaded": loaded_truth}))
    })
}
