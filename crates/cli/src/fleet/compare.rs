//! `rist compare`: finds parameters that differ between a reference and other robots, from their sums.
//!
//! A sum contains the regression rows of logs in triangular form (R of QR decompositions); `rist accumulate` makes it.

use std::path::{Path, PathBuf};

use clap::Args;
use fleet::{Accumulator, CompareRequest};

use crate::artefact::write_file;
use crate::failure::Failure;
use crate::flags::Flags;
use crate::fleet::read_sums;
use crate::terminal::print_result;
use rist::output::check_output;

/// Find parameters that changed between sums: of two robots, or of two days of one robot
///
/// Exit code 1: something changed.
#[derive(Args)]
pub(crate) struct Arguments {
    /// File of sums with which the other files are compared
    #[arg(value_name = "REFERENCE.tri")]
    reference: PathBuf,

    /// Files of sums of the robots
    #[arg(required = true, value_name = "ROBOT.tri")]
    robots: Vec<PathBuf>,

    #[command(flatten)]
    request: Flags<CompareRequest>,

    /// Write the comparison as YAML
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let inputs: Vec<&Path> = arguments.robots.iter().chain([&arguments.reference]).map(PathBuf::as_path).collect();
    arguments.out.iter().try_for_each(|out| check_output(out, &inputs))?;
    let reference = read_sums(&arguments.reference)?;
    let robots = arguments.robots.iter().map(|path| read_sums(path)).collect::<Result<Vec<Accumulator>, _>>()?;
    let name = |path: &PathBuf| path.display().to_string();
    let names: Vec<String> = arguments.robots.iter().map(name).collect();
    let named: Vec<(&str, &Accumulator)> = names.iter().map(String::as_str).zip(&robots).collect();
    let asked = arguments.request.read()?;
    let found = fleet::compare((&name(&arguments.reference), &reference), &named, asked.of, asked.fdr)?;
    print_result(&found, || serde_json::to_value(&found))?;
    if let Some(out) = &arguments.out {
        write_file(out, &found.to_yaml()?)?;
    }
    match found.changed() {
        0 => Ok(()),
        1 => Err(Failure::verdict("1 changed")),
        changed => Err(Failure::verdict(format_args!("{changed} changed"))),
    }
}
