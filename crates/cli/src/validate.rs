//! `rist validate`: computes the prediction errors of an estimate on logs that were not fitted.
//!
//! For an estimate from the experiments of a plan, the logs are motions that `rist simulate` writes (v01.csv, ..). Such motions
//! are read later than other logs, because another method predicts them.

use std::path::{Path, PathBuf};

use clap::Args;
use rist::LogSource;
use rist::fit::validation::is_fitted;
use rist::request::ValidateRequest;
use serde_json::json;

use crate::artefact::{read_estimate, series_text, write_file};
use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::report::page_of;
use crate::terminal::{at_work, note, print_result};
use crate::verdict::{as_json, refused};
use rist::output::check_output;

/// Compare measured and predicted torques on logs that were not fitted
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The estimate to validate
    estimate: PathBuf,

    /// Logs from which the estimate was not made, or directories of rist simulate (their logs v*.csv)
    #[arg(required = true)]
    logs: Vec<PathBuf>,

    #[command(flatten)]
    request: Flags<ValidateRequest>,

    /// Write the validation as YAML
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Write measured and predicted torques as CSV, or as Parquet (FILE.parquet); only for an estimate from logs
    #[arg(long, value_name = "FILE")]
    series: Option<PathBuf>,

    /// Write an HTML page with verdict, torques, residuals, friction and parameters
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,

    /// The date on the page of --report, in any form
    #[arg(long, requires = "report")]
    date: Option<String>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let of_user = [&arguments.model.model, &arguments.estimate].into_iter().chain(&arguments.logs);
    let inputs: Vec<&Path> = of_user.map(PathBuf::as_path).collect();
    let mut outputs = [&arguments.out, &arguments.series, &arguments.report].into_iter().flatten();
    outputs.try_for_each(|out| check_output(out, &inputs))?;
    let (estimate, model) = read_estimate(&arguments.estimate, &arguments.model)?;
    let motions = motions(&arguments.logs)?;
    let fitted: Vec<&PathBuf> = motions.iter().filter(|log| is_fitted(&estimate, log)).collect();
    for log in &fitted {
        note(format_args!("{}: the estimate was fitted to it; its error there is no validation", log.display()));
    }
    let options = estimate.options.as_ref();
    if options.is_none() && arguments.series.is_some() {
        return Err(Failure::new("[series]: for an estimate from logs; this one is of experiments"));
    }
    if options.is_some() && arguments.request.names().next().is_some() {
        let message = "[cutoff] and [gain]: an estimate from samples brings those that it was made with";
        return Err(Failure::new(message));
    }
    let open = |path: &PathBuf| {
        at_work(format_args!("reading {}", path.display()));
        options.map(|options| model.open_log(path, &options.columns).map(|(log, _)| log)).transpose()
    };
    // The list is empty for an estimate of experiments. The motions for such an estimate are read later.
    let logs: Vec<LogSource> = motions.iter().filter_map(|path| open(path).transpose()).collect::<Result<_, _>>()?;
    at_work("validating");
    let validation = match options {
        Some(_) => rist::validate(&model, &estimate, &logs)?,
        None => {
            let request = arguments.request.read()?;
            rist::fit::validation::validate_experiments(&model, &estimate, &motions, &request)?
        }
    };
    let verdict =
        rist::fit::verdict::validation_verdict(&model, &estimate, &logs, validation.total, fitted.is_empty())?;
    print_result(format_args!("{validation}\n{verdict}"), || {
        Ok(json!({"validation": serde_json::to_value(&validation)?, "verdict": as_json(&verdict)}))
    })?;
    at_work("writing");
    if let Some(out) = &arguments.out {
        write_file(out, &validation.to_yaml()?)?;
    }
    if let Some(out) = &arguments.series {
        let series = rist::fit::validation::predicted_torques(&model, &estimate, &logs)?;
        write_file(out, series_text(out, &series, model.regressor().coordinates())?)?;
    }
    if let Some(out) = &arguments.report {
        let page = page_of(&model, &estimate, &logs, Some(&validation), &verdict, arguments.date.as_deref())?;
        write_file(out, page)?;
    }
    refused(&verdict, false)
}

/// The given logs. A directory is replaced by its validation motions (v*.csv), sorted by name.
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
