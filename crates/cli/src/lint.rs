//! `rist lint`: searches a description for frequent mistakes in bodies and limits, and for differences between left and right.
//!
//! Output: the findings as text or JSON; with `--write`, also the description with repaired bodies. With findings, the exit
//! code is 1.

use std::path::{Path, PathBuf};

use clap::Args;
use rist::describe::linting::counted;

use crate::artefact::write_file;
use crate::failure::Failure;
use crate::model::ModelArguments;
use crate::terminal::{note, print_result};

/// Look for mistakes in a description: bodies, limits, differences of left and right
///
/// Exit code 1: there is a mistake. Notes are not mistakes.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// Total mass of the robot with its base, from the data sheet, kg
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,

    /// Write the description (URDF, MJCF, YAML) with repaired bodies to this file. A body is repaired if only one repair
    /// makes it plausible. Comments and order stay
    #[arg(long, value_name = "FILE")]
    write: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(mass) = arguments.mass.filter(|mass| !(mass.is_finite() && *mass > 0.0)) {
        return Err(Failure::new(format_args!("[mass] is a positive number of kg, found {mass}")));
    }
    let model = &arguments.model.model;
    let directory = model.parent().unwrap_or(Path::new(""));
    let found = rist::lint_with_meshes(&arguments.model.read()?, directory, arguments.mass);
    print_result(&found, || Ok(found.to_json()))?;
    if let Some(out) = arguments.write.as_ref().filter(|_| found.count() > 0) {
        let (text, bodies) = rist::write_repaired(&found, &rist::text_of(model)?, model, &arguments.model.options()?)?;
        write_file(out, &text)?;
        note(format_args!("{}: repaired {}; read it before you use it", out.display(), bodies.join(", ")));
    }
    match found.count() {
        0 => Ok(()),
        n => Err(Failure::verdict(counted(n, "finding"))),
    }
}
