//! `rist accumulate`: adds logs up to sums (normal equations in triangular form), which later steps use instead of the logs.
//!
//! A sum contains, for each joint, triangular matrices R of QR decompositions of the regression rows. So sums need little
//! memory, and the sums of several logs can be added.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use fleet::{AccumulateRequest, Accumulator};
use serde_json::json;

use crate::artefact::write_file;
use crate::failure::Failure;
use crate::flags::Flags;
use crate::fleet::read_sums;
use crate::model::ModelArguments;
use crate::terminal::{at_work, print_result};
use rist::output::{check_given_once, check_output};

/// Reduce logs to a small file of sums, for rist merge, rist solve and rist compare
///
/// Sums contain what a fit needs of the logs, without their rows. The logs are read as by rist identify. All sums that will
/// be merged need the same cut-off. Give --cutoff, or take all settings of other sums with --like. Without both, the
/// cut-off follows from the motion of all logs given here, and these logs are then read twice.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// Logs in any format of rist identify
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,

    /// File of sums to write
    #[arg(long, value_name = "FILE.tri")]
    out: PathBuf,

    /// Take the settings of this file of sums: columns, cut-off, friction, transmission, gains, weights
    #[arg(long, value_name = "FILE.tri", conflicts_with_all = ["cutoff", "order", "decimate", "delay", "friction", "weights", "options", "gain"])]
    like: Option<PathBuf>,

    #[command(flatten)]
    request: Flags<AccumulateRequest>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let logs = &arguments.logs;
    check_given_once(logs.iter().map(PathBuf::as_path))?;
    let others = [&arguments.model.model].into_iter().chain(&arguments.like);
    let read = logs.iter().chain(others).map(PathBuf::as_path);
    let inputs: Vec<&Path> = read.chain(arguments.request.files()).collect();
    check_output(&arguments.out, &inputs)?;
    let request = arguments.request.read()?;
    let report_progress = || at_work(format_args!("adding {} logs up", logs.len()));
    let sums = match &arguments.like {
        Some(path) => {
            let like = read_sums(path)?;
            let model = arguments.model.derive_as(like.settings().description.as_ref())?;
            fleet::sums::check_sums(&model, &like)
                .map_err(|e| Failure::new(format_args!("{}: {e}", path.display())))?;
            report_progress();
            fleet::sums::accumulate_like(&model, logs, &request, like.settings().options.clone())?
        }
        None => {
            let model = arguments.model.derive()?;
            report_progress();
            fleet::accumulate(&model, logs, &request)?
        }
    };
    write_file(&arguments.out, &sums.to_bytes()?)?;
    print_account(&sums)
}

/// Prints a summary of the sums: the logs, the rows, the settings.
pub(crate) fn print_account(sums: &Accumulator) -> Result<(), Failure> {
    print_result(account(sums), || {
        let failed: Vec<_> = sums.failed().iter().map(|f| json!({"name": f.name, "reason": f.reason})).collect();
        Ok(json!({
            "model": sums.settings().model.name,
            "columns": sums.settings().columns.len(),
            "cutoff_hz": sums.settings().options.signal.cutoff,
            "logs": serde_json::to_value(sums.logs())?,
            "left_out": failed,
        }))
    })
}

fn account(sums: &Accumulator) -> String {
    let (settings, logs) = (sums.settings(), sums.logs());
    let mut text = String::new();
    let width = logs.iter().map(|log| log.name.chars().count()).max().unwrap_or(0).max(3);
    // Writing to a String cannot fail.
    let _ = writeln!(text, "{:<width$}  {:>10}  {:>10}  {:>10}", "log", "rows", "usable", "samples");
    for log in &logs {
        let _ = writeln!(text, "{:<width$}  {:>10}  {:>10}  {:>10}", log.name, log.rows, log.kept, log.samples);
    }
    for failed in sums.failed() {
        let _ = writeln!(text, "left out: {}: {}", failed.name, failed.reason);
    }
    let cutoff = settings.options.signal.cutoff.map_or("no filter".into(), |hz| format!("cut-off {hz:.2} Hz"));
    let count = match logs.len() {
        1 => "1 log".into(),
        count => format!("{count} logs"),
    };
    let columns = settings.columns.len();
    let _ = writeln!(text, "{}: {count}, {columns} columns, {cutoff}", settings.model.name);
    text
}
