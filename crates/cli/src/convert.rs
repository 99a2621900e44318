//! `rist convert`: a description from one format to another.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use robot::format::{write_par, write_urdf, write_yaml};

use crate::failure::{Failure, print, write_file};
use crate::model::ModelArguments;

/// Write a robot's description in another format, and say what that format cannot carry
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// Format to write
    #[arg(long, value_enum)]
    to: Format,

    /// File to write [default: standard output]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Format {
    Par,
    Yaml,
    Urdf,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (text, notes) = match arguments.to {
        Format::Par => write_par(&arguments.model.read()?),
        Format::Yaml => write_yaml(&arguments.model.read()?),
        // Numbers only: a symbol needs its value.
        Format::Urdf => write_urdf(&arguments.model.read_with_values()?),
    };
    match &arguments.out {
        Some(out) => write_file(out, &text)?,
        None => print(&text)?,
    }
    for note in notes {
        eprintln!("{}: {}", note.subject, note.text);
    }
    Ok(())
}
