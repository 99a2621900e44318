//! `rist play`: writes a motion for a controller, with paths from the robot's pose and back.
//!
//! Three segments are played: the path from the robot's pose to the start of the motion, the motion (possibly slowed down), and
//! the path back. A file is written only if the limits are proved for all three segments.

use std::path::{Path, PathBuf};

use clap::Args;
use rist::ExcitingMotion;
use rist::request::PlayRequest;
use serde_json::json;

use crate::artefact::{check_outputs, read_text, write_file};
use crate::check::value;
use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::terminal::{self, print_result};

/// Write a motion for a controller, with the ways to its start and back, also slower
///
/// The motion at --speed, and the straight ways to its first pose and back, are proved as by rist check. A file is written
/// only if the proof finds no violation. None of the formats has been tried on its controller. A file of URScript says so
/// too.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// A motion of `rist excite`
    motion: PathBuf,

    #[command(flatten)]
    request: Flags<PlayRequest>,

    /// File to write for the controller
    #[arg(long, value_name = "FILE")]
    out: PathBuf,

    /// Write the header line of a log, with column names that rist identify knows
    #[arg(long, value_name = "FILE")]
    template: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = arguments.model.derive()?;
    let own = [arguments.model.model.as_path(), arguments.motion.as_path()];
    let inputs: Vec<&Path> = own.into_iter().chain(arguments.request.files()).collect();
    check_outputs([&arguments.out].into_iter().chain(&arguments.template), &inputs)?;
    let file = &arguments.motion;
    let motion = ExcitingMotion::from_yaml(&file.display().to_string(), &read_text(file)?)?;
    let staged = rist::staged_play(&model, file, &motion, &arguments.request.read()?)?;
    let mut text = terminal::notes(&staged.notes);
    for (part, checked) in &staged.parts {
        text += &format!("{part}: {}\n", checked.claims());
    }
    print_result(text, || {
        let of =
            |(part, checked): &(&str, rist::Checked)| Ok::<_, serde_json::Error>((part.to_string(), value(checked)?));
        let parts = staged.parts.iter().map(of).collect::<Result<serde_json::Map<_, _>, _>>()?;
        Ok(json!({"notes": staged.notes, "parts": parts}))
    })?;
    // The result is printed first. The file is written only if all segments are proved.
    let faults: Vec<String> = staged
        .parts
        .iter()
        .flat_map(|(part, checked)| checked.faults().into_iter().map(move |fault| format!("{part}: {fault}")))
        .collect();
    if !faults.is_empty() {
        return Err(Failure::verdict(format_args!("{}: {}; nothing is written", file.display(), faults.join("; "))));
    }
    write_file(&arguments.out, &staged.text)?;
    match &arguments.template {
        Some(template) => Ok(write_file(template, &staged.template)?),
        None => Ok(()),
    }
}
