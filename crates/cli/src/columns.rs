//! `rist columns`: proposes which column of a log is which signal, as lines for the file of options.
//!
//! Input: a log and a description, which gives the names of the joints. Each printed line has its reason. If a signal is
//! missing, the exit code is 1.

use std::path::PathBuf;

use clap::Args;

use crate::failure::Failure;
use crate::model::ModelArguments;
use crate::terminal::print_lines;

/// Propose which column of a log is which signal, as lines for the file of --options
///
/// Each line comes with its reason. Exit code 1: a signal is not found.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The log
    #[arg(value_name = "LOG")]
    log: PathBuf,

    /// Rows per second (Hz) of a log without a clock [default: from the velocities, if the log has them]
    #[arg(long, value_name = "HZ", value_parser = positive)]
    rate: Option<f64>,

    /// A hobby arm or its servo: so101, koch, wx250s, vx300s, openmanipulator-x, xm430-w350 and others. Units, zeros and
    /// gains of this arm complete the proposal. The form of the positions may follow the name: so101:degrees, :normalised,
    /// :counts or :radians
    #[arg(long, value_name = "ARM[:FORM]")]
    arm: Option<String>,
}

fn positive(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0).ok_or("a positive number of Hz is expected".into())
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let found =
        rist::propose_columns(&arguments.model.read()?, &arguments.log, arguments.rate, arguments.arm.as_deref())?;
    print_lines(&found, || Ok(found.to_json()))?;
    match found.is_whole() {
        true => Ok(()),
        false => Err(Failure::verdict("some signals are not found".to_string())),
    }
}
