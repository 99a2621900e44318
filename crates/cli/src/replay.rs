//! `rist replay`: runs observer, load and drift over a log.
//!
//! The observer computes the external torque of each joint. From these torques follow contacts, the load that the robot
//! carries, and the drift of friction (the change since the identification). One cycle is one sample of the log.

use std::path::{Path, PathBuf};

use clap::Args;
use rist::output::check_output;
use rist::page::Origin;
use rist::replay::reference_logs;
use rist::request::ReplayRequest;
use rist::request::spelling::Audience;

use crate::artefact::{read_estimate, write_file};
use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::report::{command, origin};
use crate::terminal::{at_work, note, print_result};

/// Find contact, loads and drift of friction in a log, in the same way as on the robot
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The estimate that predicts the torques
    estimate: PathBuf,

    /// The log to replay
    log: PathBuf,

    #[command(flatten)]
    request: Flags<ReplayRequest>,

    /// Write external torque, its limit without contact, contact and load of every cycle as CSV
    #[arg(long, value_name = "FILE")]
    series: Option<PathBuf>,

    /// Write an HTML page with contact, loads, drift and the external torques
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,

    /// The date on the page of --report, in any form
    #[arg(long, requires = "report")]
    date: Option<String>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let request = arguments.request.read()?;
    let of_user = [&arguments.model.model, &arguments.estimate, &arguments.log].into_iter().chain(&request.reference);
    let inputs: Vec<&Path> = of_user.map(PathBuf::as_path).collect();
    arguments.series.iter().chain(&arguments.report).try_for_each(|out| check_output(out, &inputs))?;
    let (estimate, model) = read_estimate(&arguments.estimate, &arguments.model)?;
    // The logs are read with the column names of the fit.
    let columns = estimate.options.as_ref().map(|options| options.columns.clone()).unwrap_or_default();
    let open = |path: &PathBuf| {
        at_work(format_args!("reading {}", path.display()));
        model.open_log(path, &columns).map(|(log, _)| log)
    };
    let log = open(&arguments.log)?;
    let reference = reference_logs(&model, &arguments.estimate, &estimate, &request.reference)?;
    // The limits of contact follow from the noise in the reference logs. If the replayed log is one of them, its contacts may
    // increase these limits.
    if reference.iter().any(|reference| reference.name() == log.name()) {
        note(format_args!("{}: the noise of the observer is measured in it too", arguments.log.display()));
    }
    at_work("replaying");
    let replay = rist::replay(&model, (&arguments.estimate, &estimate), &log, &reference, &request)?;
    print_result(&replay, || Ok(replay.to_json()))?;
    if let Some(out) = &arguments.series {
        write_file(out, replay.to_csv())?;
    }
    if let Some(out) = &arguments.report {
        let command = command();
        let path = model.path.display().to_string();
        let origin = Origin { model: Some(&path), ..origin(arguments.date.as_deref(), &command) };
        write_file(out, replay.page(origin, Audience::Program))?;
    }
    Ok(())
}
