//! `rist lint`: searches a description for frequent mistakes in inertial parameters.

use std::path::Path;

use clap::Args;
use rist::describe::linting::counted;

use crate::failure::Failure;
use crate::model::ModelArguments;
use crate::terminal::print_result;

/// Look for classic mistakes in a description's inertial parameters
///
/// Exit code 1 where there is one.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let directory = arguments.model.model.parent().unwrap_or(Path::new(""));
    let found = rist::lint_with_meshes(&arguments.model.read()?, directory);
    print_result(&found, || Ok(found.to_json()))?;
    match found.findings.len() {
        0 => Ok(()),
        n => Err(Failure::verdict(counted(n, "finding"))),
    }
}
