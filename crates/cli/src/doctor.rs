//! `rist doctor`: what a log and a description have to do with each other, before anything is fitted.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use identification::estimate::options::Options;

use crate::failure::{Failure, print};
use crate::model::ModelArguments;

/// Look for what is wrong with logs: units, signs, zeros, swapped columns, delays, another robot
///
/// The torque of each joint is held against what the description computes for its motion. Exit code 1 where something
/// is wrong.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The logs, as rist identify reads them
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,

    /// YAML with any option of an identification
    #[arg(long, value_name = "FILE")]
    options: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = arguments.model.derive()?;
    let options = match &arguments.options {
        Some(path) => Options::read(path)?,
        None => Options::default(),
    };
    let (mut text, mut wrong) = (String::new(), 0);
    for path in &arguments.logs {
        let (log, columns) = model.open_log(path, &options.columns)?;
        let report = log.report().to_string();
        let passport = rist::examine(&model, &[log], &options)?;
        wrong += passport.findings.len();
        // A String never fails to grow.
        let _ = writeln!(text, "{}\n{columns}{report}\n{passport}", path.display());
        for finding in &passport.findings {
            let _ = writeln!(text, "{finding}");
        }
        for untold in &passport.untold {
            let _ = writeln!(text, "{untold}");
        }
        if passport.findings.is_empty() {
            let _ = writeln!(text, "nothing wrong is seen");
        }
    }
    print(&text)?;
    match wrong {
        0 => Ok(()),
        1 => Err(Failure::verdict("1 finding")),
        _ => Err(Failure::verdict(format_args!("{wrong} findings"))),
    }
}
