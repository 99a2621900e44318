//! `rist check`: a model and a motion -> whether the motion keeps its limits, between samples too.

use std::path::PathBuf;

use clap::Args;
use rist::origins_text;
use rist::request::CheckRequest;
use rist::{ExcitingMotion, certificate_text, proven_text};
use serde_json::json;

use crate::artefact::read_text;
use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::terminal::{self, at_work, print_result};

/// Prove anew that an exciting motion keeps its limits
///
/// The proof needs the motion and the model alone. The limits are those that the motion was made with, but no looser
/// than those of the description. The output says where each limit comes from. A limit that neither the description nor
/// --limits has is taken from the motion's file. Position, velocity, acceleration and jerk are always proved. Torque
/// and power are proved where they are limited and the description has inertial parameters, or the motion was made
/// after an identification. Distances of the robot's own links are proved where a URDF has their collision geometry.
/// The floors, walls and boxes that the motion was made with are proved too. Exit code 1: a limit is broken, or not
/// proven to be kept.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The motion of `rist excite`
    motion: PathBuf,

    #[command(flatten)]
    request: Flags<CheckRequest>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = arguments.model.derive()?;
    let file = &arguments.motion;
    let motion = ExcitingMotion::from_yaml(&file.display().to_string(), &read_text(file)?)?;
    let asked = arguments.request.read()?.limits;
    at_work(format_args!("proving the limits of {}", file.display()));
    let checked = rist::check(&model, file, &motion, asked.as_ref())?;
    let mut text = terminal::notes(&checked.notes) + &certificate_text(&checked.certificate);
    text += &format!("\nwhere the limits stand:\n{}", origins_text(&checked.origins));
    if checked.is_proven() {
        text += &format!("\n{}\n", proven_text(&checked.certificate));
    }
    let (is_proven, notes) = (checked.is_proven(), &checked.notes);
    print_result(text, || {
        let certificate = serde_json::to_value(&checked.certificate)?;
        let limits = serde_json::to_value(&checked.origins)?;
        Ok(json!({"proven": is_proven, "notes": notes, "certificate": certificate, "limits": limits}))
    })?;
    if is_proven {
        return Ok(());
    }
    let faults: Vec<String> = checked.faults().map(|row| row.to_string()).collect();
    Err(Failure::verdict(format_args!("{}: {}", file.display(), faults.join("; "))))
}
