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
    let robot = arguments.model.read()?;
    let module =
        modeling::regressor_module(&robot).map_err(|unclear| Failure::new(format_args!("{path}: {unclear}")))?;
    let text = codegen::rust_file(&module, &format!("rist generate {path}"));
    match &arguments.out {
        None => print(&text),
        Some(out) => {
            write_file(out, &text)?;
            for f in &module.functions {
                let (name, c) = (&f.function.name, f.function.count());
                eprintln!("{}: {name}: {} mul, {} add, {} sin_cos a call", out.display(), c.mul, c.add, c.sin_cos);
            }
            Ok(())
        }
    }
}
