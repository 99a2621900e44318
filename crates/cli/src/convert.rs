//! `rist convert`: writes a description in another format, or its parameters in another convention.
//!
//! A convention defines the frame and the point to which inertial parameters refer, for example the link frame or the centre of
//! mass.

use std::path::PathBuf;

use clap::Args;
use rist::request::{ConvertRequest, DescriptionFormat};

use crate::artefact::write_file;
use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::terminal::{note, print};

/// Write a robot's description in another format, and list what that format lacks
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    #[command(flatten)]
    request: Flags<ConvertRequest>,

    /// File to write [default: standard output]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = &arguments.model;
    let write = |text: &str| match &arguments.out {
        Some(out) => Ok(write_file(out, text)?),
        None => print(text),
    };
    let format = match arguments.request.read()? {
        ConvertRequest { to: Some(_), parameters: Some(_) } => {
            return Err(Failure::new("[to] and [parameters] are two outputs; ask for one"));
        }
        ConvertRequest { parameters: Some(convention), .. } => {
            return write(&rist::inertial_table(&model.read()?, convention));
        }
        ConvertRequest { to: None, .. } => {
            return Err(Failure::new(
                "say what to write: [to=urdf], or [parameters=pinocchio] for the parameters alone",
            ));
        }
        ConvertRequest { to: Some(format), .. } => format,
    };
    let robot = match format {
        DescriptionFormat::Par | DescriptionFormat::Yaml => model.read()?,
        // A URDF contains only numbers, so every symbol needs a value.
        DescriptionFormat::Urdf => model.read_with_values()?,
    };
    let converted = rist::convert(&robot, format)?;
    write(&converted.text)?;
    converted.notes.iter().for_each(note);
    let file = model.model.display();
    converted.differences.iter().for_each(|difference| note(format_args!("{file}: {difference}")));
    Ok(())
}
