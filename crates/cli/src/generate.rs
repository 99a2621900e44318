//! `rist generate`: a robot's base regressor as one Rust file for a project of the user's own.

use std::path::PathBuf;

use clap::Args;

use crate::failure::{Failure, print, write_file};
use crate::model::ModelArguments;

/// Write a robot's base regressor as one Rust file that needs no other
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// File to write [default: standard output]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let path = arguments.model.model.display().to_string();
    let robot = arguments.model.read_with_values()?;
    let file = codegen::robot_file(&robot, &format!("rist generate {path}"))
        .map_err(|unclear| Failure::new(format_args!("{path}: {unclear}")))?;
    match &arguments.out {
        None => print(&file.text),
        Some(out) => {
            write_file(out, &file.text)?;
            let c = file.count;
            eprintln!("{}: {} mul, {} add, {} sin_cos a call", out.display(), c.mul, c.add, c.sin_cos);
            Ok(())
        }
    }
}
