//! `rist validate`: an estimate and logs it was not made from -> how well it predicts.

use std::path::PathBuf;

use clap::Args;
use identification::estimate::artefact::Estimate;
use identification::estimate::validation::Validation;
use identification::experiments::record::Record;
use identification::spectrum::validate::validate_motions;
use logs::{ColumnNames, Effort, Log, LogSource};

use crate::failure::{Failure, print, write_file};
use crate::identify_samples::predictions;
use crate::model::ModelArguments;
use crate::spectrum::{Subject, read_text};

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

    /// Torque per unit of current of a drive, N m/A [default: of the estimate, of the file, or 1]
    #[arg(long, value_name = "COORDINATE=GAIN", value_delimiter = ',')]
    gain: Vec<String>,

    /// Cut-off of the low-pass on position and torque, Hz [default: 20, or that of the estimate]
    #[arg(long, value_name = "HZ")]
    cutoff: Option<f64>,

    /// Write the validation as YAML
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let subject = Subject::read(&arguments.model)?;
    let regressor = subject.regressor.as_ref();
    let file = arguments.estimate.display().to_string();
    let estimate = Estimate::from_yaml(&file, &read_text(&arguments.estimate)?)?;
    subject.check(&arguments.estimate, &estimate.model, &estimate.fingerprint)?;
    if estimate.options.is_some() {
        return of_samples(arguments, &subject, &estimate);
    }
    let mut records = Vec::new();
    let mut currents = false;
    for path in &motions(&arguments.logs)? {
        let (log, _) = Log::read(path, regressor.coordinates(), &ColumnNames::default())?;
        currents |= log.effort_is == Effort::Current;
        records.push((path.display().to_string(), Record::from_log(&log)?));
    }
    let mut gain = vec![1.0; regressor.coordinates().len()];
    if currents {
        let found = subject.estimated_gains(&estimate).into_iter().zip(subject.drive_gains());
        gain = found.map(|(estimated, of_file)| estimated.or(of_file).unwrap_or(1.0)).collect();
        for text in &arguments.gain {
            let (k, given) = subject.gain_of(text)?;
            gain[k] = given;
        }
    }
    let parameters = subject.parameters(&estimate);
    let method = &estimate.method;
    let cutoff = arguments.cutoff.unwrap_or(20.0);
    let report = validate_motions(&subject.reference, method, regressor, &parameters, &gain, &records, cutoff)?;
    print(&report.to_string())?;
    match &arguments.out {
        Some(out) => write_file(out, &report.to_yaml()?),
        None => Ok(()),
    }
}

/// Predicts logs as the estimate's own were fitted: its signals, its friction.
fn of_samples(arguments: &Arguments, subject: &Subject, estimate: &Estimate) -> Result<(), Failure> {
    if arguments.cutoff.is_some() || !arguments.gain.is_empty() {
        return Err(Failure::new("--cutoff and --gain: an estimate from samples brings those that it was made with"));
    }
    let regressor = subject.regressor.as_ref();
    let names = estimate.options.as_ref().map(|o| o.columns.clone()).unwrap_or_default();
    let open = |path: &PathBuf| LogSource::open(path, regressor.coordinates(), &names).map(|(log, _)| log);
    let logs = arguments.logs.iter().map(open).collect::<Result<Vec<_>, _>>()?;
    let found = predictions(regressor, estimate, &logs)?;
    let (model, method) = (subject.reference.clone(), &estimate.method);
    let validation = Validation::of_logs(model, method, estimate.cutoff, regressor, &found);
    print(&validation.to_string())?;
    match &arguments.out {
        Some(out) => write_file(out, &validation.to_yaml()?),
        None => Ok(()),
    }
}

/// The logs given, and of a directory its validation motions, by name.
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
