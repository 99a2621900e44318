//! `rist validate`: an estimate and logs it was not made from -> how well it predicts.

use std::path::{Path, PathBuf};

use clap::Args;
use rist::validation::MOTION_CUTOFF;

use crate::artefact::{gains, read_estimate};
use crate::failure::{Failure, print};
use crate::model::ModelArguments;
use crate::verdict::refused;
use rist::output::{check_output, write_file};

/// Compare measured and predicted torques on motions that were not used
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The estimate
    estimate: PathBuf,

    /// Logs that the estimate was not made from, or directories of rist simulate: their v*.csv
    #[arg(required = true)]
    logs: Vec<PathBuf>,

    /// Torque per unit of current of a drive, N m/A [default: that of the estimate, that of the file, or 1]
    #[arg(long, value_name = "COORDINATE=GAIN", value_delimiter = ',')]
    gain: Vec<String>,

    /// Cut-off of the low-pass on position and torque, Hz [default: 20, or that of the estimate]
    #[arg(long, value_name = "HZ")]
    cutoff: Option<f64>,

    /// Write the validation as YAML
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Write measured and predicted torques as CSV; for an estimate from logs
    #[arg(long, value_name = "FILE")]
    series: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let of_user = [&arguments.model.model, &arguments.estimate].into_iter().chain(&arguments.logs);
    let inputs: Vec<&Path> = of_user.map(PathBuf::as_path).collect();
    arguments.out.iter().chain(&arguments.series).try_for_each(|out| check_output(out, &inputs))?;
    let (estimate, model) = read_estimate(&arguments.estimate, &arguments.model)?;
    let place = |name: &str| std::fs::canonicalize(name).unwrap_or_else(|_| PathBuf::from(name));
    let fitted: Vec<PathBuf> = estimate.logs.iter().map(|name| place(name)).collect();
    let motions = motions(&arguments.logs)?;
    for log in motions.iter().filter(|log| fitted.contains(&place(&log.display().to_string()))) {
        eprintln!("note: {}: the estimate was fitted to it; what it leaves there is no validation", log.display());
    }
    let mut series = None;
    let (validation, verdict) = match &estimate.options {
        Some(options) => {
            if arguments.cutoff.is_some() || !arguments.gain.is_empty() {
                return Err(Failure::new(
                    "--cutoff and --gain: an estimate from samples brings those that it was made with",
                ));
            }
            let open = |path: &PathBuf| model.open_log(path, &options.columns).map(|(log, _)| log);
            let logs = motions.iter().map(open).collect::<Result<Vec<_>, _>>()?;
            let validation = rist::validate(&model, &estimate, &logs)?;
            if arguments.series.is_some() {
                series = Some(rist::validation::series_to_csv(
                    &rist::validation::predicted_torques(&model, &estimate, &logs)?,
                    model.regressor().coordinates(),
                ));
            }
            let verdict = rist::verdict::validation_verdict(&model, &estimate, &logs, validation.total)?;
            (validation, verdict)
        }
        None if arguments.series.is_some() => {
            return Err(Failure::new("--series: for an estimate from logs; this one is of experiments"));
        }
        None => {
            let gains = gains(&arguments.gain, &model)?;
            let cutoff = arguments.cutoff.unwrap_or(MOTION_CUTOFF);
            let validation = rist::validation::validate_experiments(&model, &estimate, &motions, &gains, cutoff)?;
            let verdict = rist::verdict::validation_verdict(&model, &estimate, &[], validation.total)?;
            (validation, verdict)
        }
    };
    print(&format!("{validation}\n{verdict}"))?;
    if let Some(out) = &arguments.out {
        write_file(out, &validation.to_yaml()?, &inputs)?;
    }
    if let (Some(out), Some(series)) = (&arguments.series, &series) {
        write_file(out, series, &inputs)?;
    }
    refused(&verdict, false)
}

/// The logs given; of a directory, its validation motions in the order of their names.
fn motions(given: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut logs = Vec::new();
    for path in given {
        if !path.is_dir() {
            logs.push(path.clone());
            continue;
        }
        let failed = |e: std::io::Error| Failure::new(format_args!("{}: {e}", path.display()));
        let entries = std::fs::read_dir(path).map_err(failed)?;
        let is_motion = |p: &PathBuf| {
            let name = p.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with('v') && name.ends_with(".csv")
        };
        let mut found: Vec<PathBuf> = entries.filter_map(|e| e.ok().map(|e| e.path())).filter(is_motion).collect();
        if found.is_empty() {
            return Err(Failure::new(format_args!("{}: no validation motion (v*.csv) in it", path.display())));
        }
        found.sort();
        logs.append(&mut found);
    }
    Ok(logs)
}
