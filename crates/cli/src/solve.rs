//! `rist solve`: sums -> an estimate.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::artefact::{read_sums, write_file};
use crate::failure::Failure;
use crate::terminal::print_result;
use crate::verdict::{as_json, refused};
use rist::output::check_output;

/// Solve sums of rist accumulate: the estimate that rist identify makes of the same logs
#[derive(Args)]
pub(crate) struct Arguments {
    /// The sums
    #[arg(value_name = "FILE.tri")]
    sums: PathBuf,

    /// Write the estimate as YAML, for rist validate and rist report
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let inputs = [arguments.sums.as_path()];
    arguments.out.iter().try_for_each(|out| check_output(out, &inputs))?;
    let file = arguments.sums.display();
    let estimate = read_sums(&arguments.sums)?.solve().map_err(|e| Failure::new(format_args!("{file}: {e}")))?;
    let verdict = rist::verdict::estimate_verdict(&estimate);
    print_result(format_args!("{estimate}\n{verdict}"), || {
        Ok(json!({"estimate": serde_json::to_value(&estimate)?, "verdict": as_json(&verdict)}))
    })?;
    if let Some(out) = &arguments.out {
        write_file(out, &estimate.to_yaml()?)?;
    }
    refused(&verdict, false)
}
