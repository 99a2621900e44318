//! `rist columns`: proposes which column of a log is which signal, as lines for the file of options.

use std::path::PathBuf;

use clap::Args;

use crate::failure::Failure;
use crate::model::ModelArguments;
use crate::terminal::print_lines;

/// Propose which column of a log is which signal, as lines for the file of --options
///
/// Each line comes with its reason. Exit code 1 where something is missing.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The log
    #[arg(value_name = "LOG")]
    log: PathBuf,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let found = rist::propose_columns(&arguments.model.read()?, &arguments.log)?;
    print_lines(&found, || Ok(found.to_json()))?;
    match found.is_whole() {
        true => Ok(()),
        false => Err(Failure::verdict("some signals are not found".to_string())),
    }
}
