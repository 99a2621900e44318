//! `rist derive`: writes functions of a robot as formulas: as plain text, LaTeX, SymPy or MATLAB.

use std::path::PathBuf;

use clap::Args;
use formulas::DeriveRequest;
use rist::request::Request;
use rist::request::spelling::flags;

use crate::artefact::write_file;
use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::terminal::{at_work, print};

/// Write functions of a robot as formulas, for readers or for a computer algebra system
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    #[command(flatten)]
    request: Flags<DeriveRequest>,

    /// File to write [default: standard output]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let path = arguments.model.model.display().to_string();
    let (options, request) = (arguments.model.options()?, arguments.request.read()?);
    let made_by = format!("rist derive {path}{}{}", flags(&options.given()), flags(&request.given()));
    let robot = arguments.model.read()?;
    at_work(format_args!("deriving the formulas of {path}"));
    let refused = |e| Failure::new(format_args!("{path}: {e}"));
    let text = formulas::derive(&robot, &request, &made_by, options.any_size).map_err(refused)?;
    match &arguments.out {
        None => print(&text),
        Some(out) => Ok(write_file(out, &text)?),
    }
}
