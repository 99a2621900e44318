//! `rist check`: a model and a motion -> whether the motion keeps its limits, between samples too.

use std::path::PathBuf;

use clap::Args;
use rist::request::CheckRequest;
use rist::{ExcitingMotion, certificate_text, origins_text};
use serde_json::json;

use crate::artefact::read_text;
use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::terminal::{self, at_work, print_result};

/// Prove anew that an exciting motion keeps its limits
///
/// Of the motion's file the coefficients are taken, and limits where they are tighter than those of the description and
/// of --limits. A limit that stands in the motion's file alone is told as an assumption. Position, velocity, acceleration
/// and jerk are always proved. Torque and power are proved where they are limited, with the inertial parameters of the
/// description or of --after. Distances of the robot's own links and the floor are proved where a URDF has their collision
/// geometry, and so are walls and boxes. The last line says what is broken, proven, assumed and not looked at. Exit code
/// 1: something is broken or not proven, or nobody could look at something that --limits asks for.
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
    let request = arguments.request.read()?;
    at_work(format_args!("proving the limits of {}", file.display()));
    let checked = rist::check(&model, file, &motion, &request)?;
    let ledger = checked.ledger();
    let mut text = terminal::notes(&checked.notes) + &certificate_text(&checked.certificate);
    text += &ledger.left_out_text();
    text += &format!("\nwhere the limits stand:\n{}\n{ledger}\n", origins_text(&checked.origins));
    print_result(text, || {
        Ok(json!({
            "proven": checked.is_proven(),
            "notes": checked.notes,
            "certificate": serde_json::to_value(&checked.certificate)?,
            "limits": serde_json::to_value(&checked.origins)?,
            "claims": serde_json::to_value(ledger.claims())?,
            "standing": serde_json::to_value(ledger.standing())?,
            "floor": checked.floor,
            "lowest": serde_json::to_value(&checked.lowest)?,
        }))
    })?;
    match &checked.faults()[..] {
        [] => Ok(()),
        faults => Err(Failure::verdict(format_args!("{}: {}", file.display(), faults.join("; ")))),
    }
}
