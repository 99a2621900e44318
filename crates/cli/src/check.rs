//! `rist check`: a model and a motion -> whether the motion keeps its limits, between samples too.

use std::path::PathBuf;

use clap::Args;
use identification::experiments::excitation::artefact::{ExcitingMotion, certificate_text, proven_text};
use identification::experiments::excitation::held_limits::origins_text;
use serde_json::json;

use crate::artefact::{read_limits, read_text};
use crate::failure::Failure;
use crate::model::ModelArguments;
use crate::terminal::{self, at_work, print_result};

/// Prove anew that an exciting motion keeps its limits
///
/// From the motion and the model alone: the limits the motion was made with, no looser than those of the description. It is
/// said of each limit where it stands: one that neither the description nor --limits has is what the motion's file says.
/// Position, velocity, acceleration and jerk always; torque and power where they are limited and the description has
/// inertial parameters, or the motion was made after an identification; distances of the robot's own links where a URDF has their
/// collision geometry; the floors, walls and boxes that the motion was made with. Exit code 1: a limit is broken, or not
/// proven to be kept.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The motion of `rist excite`
    motion: PathBuf,

    /// Hold it to your own limits too, as of `rist excite --limits`; what this file does not give is not assumed
    #[arg(long, value_name = "FILE")]
    limits: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = arguments.model.derive()?;
    let file = &arguments.motion;
    let motion = ExcitingMotion::from_yaml(&file.display().to_string(), &read_text(file)?)?;
    let asked = arguments.limits.as_deref().map(read_limits).transpose()?;
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
