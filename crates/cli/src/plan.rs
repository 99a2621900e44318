//! `rist plan`: plans experiments that identify the parameters of a model best.
//!
//! Input: a description. Output: a plan, that is a list of experiments (one motion each) in YAML. All motions of a plan are
//! proved to keep their limits.

use std::path::{Path, PathBuf};

use clap::Args;
use rist::request::{PlanRequest, TrajectoryFiles};
use rist::{Checked, trajectory_file};
use serde_json::json;

use crate::artefact::{make_directory, write_file};
use crate::check::value;
use crate::failure::Failure;
use crate::flags::Flags;
use crate::interrupt::interruptible;
use crate::model::ModelArguments;
use crate::terminal::{self, print_result, progress};
use rist::output::check_output;

/// Plan exciting experiments for identification by spectrum analysis
///
/// The candidates are all kinds of motion about a grid of configurations. The plan is the best set of candidates that was
/// found: the determinant of its information matrix is greatest (or the condition number is least). The plan says how far
/// it can be from the best possible set. If the torques or the bodies of a motion do not keep the limits, the motion is
/// left out or made slower. The limits of the chosen motions are proved as by rist check, and the last line says what is
/// proven, assumed and not checked.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    #[command(flatten)]
    request: Flags<PlanRequest>,

    /// Write the plan as YAML
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    #[command(flatten)]
    files: Flags<TrajectoryFiles>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let request = arguments.request.read()?;
    let inputs: Vec<&Path> = [arguments.model.model.as_path()].into_iter().chain(arguments.request.files()).collect();
    // The output file is checked before the search starts.
    arguments.out.iter().try_for_each(|out| check_output(out, &inputs))?;
    let model = arguments.model.derive()?;
    // If the choice will take minutes, a forecast is printed.
    if let Some(long) = rist::motion::planning::cost_forecast(&model, &request)? {
        terminal::note(long);
    }
    let report_progress =
        |done: usize, all: usize, best: f64| progress(format_args!("start {done} of {all}, best {best:.3}"));
    let rist::motion::planning::Planned { plan, notes, checked } =
        interruptible(|| rist::plan(&model, &request, &report_progress))??;
    // The lines of all experiments differ only in the lowest point. So one line is printed for all: the line of the experiment
    // with the lowest point.
    let height = |checked: &Checked| checked.lowest.as_ref().map_or(f64::INFINITY, |lowest| lowest.z_m);
    let lowest = checked.iter().map(|(_, checked)| checked).min_by(|a, b| height(a).total_cmp(&height(b)));
    let last = lowest.map_or(String::new(), |checked| format!("\nevery experiment: {}\n", checked.claims()));
    print_result(format_args!("{}{plan}{last}", terminal::notes(&notes)), || {
        let of = |(name, checked): &(String, Checked)| Ok::<_, serde_json::Error>((name.clone(), value(checked)?));
        let experiments = checked.iter().map(of).collect::<Result<serde_json::Map<_, _>, _>>()?;
        Ok(json!({"notes": notes, "plan": serde_json::to_value(&plan)?, "experiments": experiments}))
    })?;
    let files: TrajectoryFiles = arguments.files.read()?;
    if let Some(directory) = &files.trajectories {
        make_directory(directory)?;
        for (e, t) in plan.experiments.iter().zip(plan.trajectories("plan")?) {
            let text = trajectory_file(&t.reference(), &plan.coordinates, request.rate, files.format);
            write_file(&directory.join(format!("{}.{}", e.name, files.format.extension())), &text)?;
        }
    }
    match &arguments.out {
        Some(out) => Ok(write_file(out, &plan.to_yaml()?)?),
        None => Ok(()),
    }
}
