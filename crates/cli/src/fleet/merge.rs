//! `rist merge`: adds several sums of logs to one.
//!
//! A sum contains the regression rows of logs in triangular form (R of QR decompositions); `rist accumulate` makes it.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::artefact::write_file;
use crate::failure::Failure;
use crate::fleet::accumulate::print_account;
use crate::fleet::read_sums;
use rist::output::check_output;

/// Merge sums of rist accumulate: the same as the sums of all logs, in any order
#[derive(Args)]
pub(crate) struct Arguments {
    /// Files of sums to merge
    #[arg(required = true, value_name = "PART.tri")]
    parts: Vec<PathBuf>,

    /// File of sums to write
    #[arg(long, value_name = "FILE.tri")]
    out: PathBuf,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let inputs: Vec<&Path> = arguments.parts.iter().map(PathBuf::as_path).collect();
    check_output(&arguments.out, &inputs)?;
    let (first, others) = arguments.parts.split_first().ok_or_else(|| Failure::new("no part is given"))?;
    let mut all = read_sums(first)?;
    for path in others {
        let part = read_sums(path)?;
        all.merge(&part).map_err(|e| {
            Failure::new(format_args!("{} cannot be added to {}: {e}", path.display(), first.display()))
        })?;
    }
    write_file(&arguments.out, &all.to_bytes()?)?;
    print_account(&all)
}
