//! `rist doctor`: checks before a fit whether a log belongs to a description.
//!
//! Output: the findings, each a probable mistake in the log or the description (a unit, a sign, a zero, exchanged columns) with
//! its remedy; then the properties that agree, and the properties that the log cannot determine.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use rist::fit::doctor::claims_of_log;
use rist::fit::verdict::claim_line;
use rist::request::DoctorRequest;
use rist::{Finding, LogCheck};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::terminal::{at_work, note, print_result};

/// Check logs for mistakes: units, signs, zeros, columns, delays, another robot
///
/// The torque of each joint is compared with the torque that the description gives for the motion of the log. Exit code 1:
/// something is wrong.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// Logs in any format of rist identify
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,

    #[command(flatten)]
    request: Flags<DoctorRequest>,
}

/// The log check of one log as JSON. Numbers that the log does not determine are null.
fn as_json(log: &str, log_check: &LogCheck) -> Value {
    let joints = log_check.joints.iter().map(|j| {
        json!({
            "coordinate": j.coordinate,
            "slope": j.slope,
            "share": j.share,
            "explained": j.explained,
            "range": j.range(),
        })
    });
    json!({
        "log": log,
        "joints": joints.collect::<Vec<_>>(),
        "findings": findings(&log_check.findings),
        "claims": claims_of_log(log_check, &[]),
    })
}

/// The findings as JSON, the most serious first.
pub(crate) fn findings(findings: &[Finding]) -> Vec<Value> {
    let one = |f: &Finding| {
        let is_gross = f.fault.is_gross();
        json!({"statement": f.statement(), "joints": f.joints, "gross": is_gross, "evidence": f.evidence, "remedy": f.remedy})
    };
    findings.iter().map(one).collect()
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = arguments.model.derive()?;
    let request = arguments.request.read()?;
    if request.arm.is_none() {
        rist::proposed_arm(&model.robot).iter().for_each(note);
    }
    let (request, mut text) = request.with_arm(&model.robot, arguments.logs.first().map(PathBuf::as_path))?;
    let options = request.options(&model)?;
    let (mut logs, mut wrong) = (Vec::new(), 0);
    for path in &arguments.logs {
        let (log, columns) = model.open_log(path, &options.columns)?;
        let report = log.report().to_string();
        at_work(format_args!("examining {}", path.display()));
        let log_check = rist::examine(&model, &[log], &options)?;
        wrong += log_check.findings.len();
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{}\n{columns}{report}\n{log_check}", path.display());
        for finding in &log_check.findings {
            let _ = writeln!(text, "{finding}");
        }
        let claims = claims_of_log(&log_check, &[]);
        for claim in claims.iter().filter(|claim| !claim.is_contradicted()) {
            let _ = writeln!(text, "{}", claim_line(claim));
        }
        if log_check.findings.is_empty() {
            let _ = writeln!(text, "nothing is contradicted");
        }
        logs.push(as_json(&path.display().to_string(), &log_check));
    }
    print_result(text, || Ok(json!({"logs": logs})))?;
    match wrong {
        0 => Ok(()),
        1 => Err(Failure::verdict("1 finding")),
        _ => Err(Failure::verdict(format_args!("{wrong} findings"))),
    }
}
