//! `rist solve`: computes an estimate from sums of logs.
//!
//! A sum contains the regression rows of logs in triangular form (R of QR decompositions); `rist accumulate` makes it. The
//! estimate is the one that `rist identify` would compute from the same logs. With the model of the robot, the verdict also
//! states the uncertainty of torques.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::failure::Failure;
use crate::fleet::read_sums;
use crate::verdict::conclude;
use rist::output::check_output;
use rist::{Model, ModelOptions};

/// Compute an estimate from sums: the estimate of rist identify from the same logs
#[derive(Args)]
pub(crate) struct Arguments {
    /// File of sums of rist accumulate or rist merge
    #[arg(value_name = "FILE.tri")]
    sums: PathBuf,

    /// The robot description of the sums. With it, the uncertainty of the torques is computed for each use
    #[arg(long, value_name = "MODEL")]
    model: Option<PathBuf>,

    /// Write the estimate as YAML, for rist validate and rist report
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let inputs: Vec<&Path> = [&arguments.sums].into_iter().chain(&arguments.model).map(PathBuf::as_path).collect();
    arguments.out.iter().try_for_each(|out| check_output(out, &inputs))?;
    let file = arguments.sums.display();
    let sums = read_sums(&arguments.sums)?;
    let (estimate, verdict) = match &arguments.model {
        None => {
            let estimate = sums.solve().map_err(|e| Failure::new(format_args!("{file}: {e}")))?;
            let verdict = rist::fit::verdict::estimate_verdict(&estimate);
            (estimate, verdict)
        }
        Some(path) => {
            let options = sums.settings().description.as_ref().map(ModelOptions::of_description);
            let model = Model::read_with(path, &options.unwrap_or_default())?;
            fleet::sums_verdict(&model, &sums)?
        }
    };
    conclude(&estimate, &verdict, arguments.out.as_deref())
}
