//! `rist check`: proves whether a motion keeps its limits, between samples too.
//!
//! Input: a motion, a plan of experiments, or points from another program. Output: the certificate (for each limit, a proven
//! bound of the motion) and the requirements that the certificate does not cover.

use std::path::PathBuf;

use clap::Args;
use rist::request::{CheckRequest, PointsFiles};
use rist::{Checked, CheckedFile, Model, PlayedFile, ProofCheck, certificate_text, origins_text};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::{ModelArguments, is_prismatic};
use crate::terminal::{self, at_work, print_result};

/// Prove the limits of a motion or a plan again, also of a motion of another program
///
/// From the file of a motion, rist uses the coefficients, and those limits that are tighter than the limits of the
/// description and of --limits. A limit that only this file contains is reported as an assumption. Position, velocity,
/// acceleration and jerk are always proved. Torque and power are proved if they are limited, with the inertial parameters
/// of the description or of --after. The distances between the robot's own links and to the floor are proved if a URDF has
/// their collision geometry. Walls and boxes are proved too. The last line says what is violated, proven, assumed and not
/// checked. Exit code 1: something is violated or not proven, or a check that --limits asks for is not possible.
///
/// A table such as CSV (time, positions, and velocities and accelerations if there are any) and a JointTrajectory in YAML
/// or JSON (also of MoveIt) are checked against the limits of the description and of --limits. Between the points, the
/// motion follows from --interpolation. Of a plan of `rist plan`, each experiment is proved in this way, and the efficiency
/// that the proof of the plan guarantees is computed again.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// A motion of `rist excite`, a plan of `rist plan`, a table of points or a JointTrajectory
    motion: PathBuf,

    #[command(flatten)]
    request: Flags<CheckRequest>,

    #[command(flatten)]
    points: Flags<PointsFiles>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = arguments.model.derive()?;
    let file = &arguments.motion;
    let content = PlayedFile::read(&model, file)?;
    let request = arguments.request.read()?;
    let PointsFiles { interpolation } = arguments.points.read()?;
    at_work(format_args!("proving the limits of {}", file.display()));
    let checked = content.check(&model, file, interpolation, &request)?;
    match (&checked.worth, &checked.parts[..]) {
        (None, [(_, one)]) => print_one(&model, one)?,
        (worth, _) => print_plan(&checked, worth.as_ref())?,
    }
    match &checked.faults()[..] {
        [] => Ok(()),
        faults => Err(Failure::verdict(format_args!("{}: {}", file.display(), faults.join("; ")))),
    }
}

/// The result of a check as JSON: the certificate, and requirements that it does not cover.
pub(crate) fn value(checked: &Checked) -> Result<Value, serde_json::Error> {
    let claims = checked.claims();
    Ok(json!({
        "proven": checked.is_proven(),
        "notes": checked.notes,
        "certificate": serde_json::to_value(&checked.certificate)?,
        "limits": serde_json::to_value(&checked.origins)?,
        "claims": serde_json::to_value(claims.claims())?,
        "standing": serde_json::to_value(claims.standing())?,
        "margins": serde_json::to_value(&checked.margins)?,
        "floor": checked.floor,
        "lowest": serde_json::to_value(&checked.lowest)?,
    }))
}

fn print_one(model: &Model, checked: &Checked) -> Result<(), Failure> {
    let claims = checked.claims();
    let mut text =
        terminal::notes(&checked.notes) + &certificate_text(&checked.certificate, &|name| is_prismatic(model, name));
    text += &claims.left_out_text();
    text += &format!("\nwhere the limits stand:\n{}", origins_text(&checked.origins));
    text += &format!("\nmargins:\n{}\n{claims}\n", checked.margins.text());
    print_result(text, || value(checked))
}

/// Prints one line per experiment, the requirements that the proofs do not cover, and the D-efficiency that the proof of the
/// plan guarantees.
fn print_plan(file: &CheckedFile, worth: Option<&ProofCheck>) -> Result<(), Failure> {
    let mut text = String::new();
    for (name, checked) in &file.parts {
        text += &format!("{name}: {}\n", checked.claims());
    }
    let first = file.parts.first().map(|(_, checked)| checked);
    if let Some(first) = first {
        text += &format!("\nwhere the limits stand:\n{}", origins_text(&first.origins));
    }
    // All experiments have the same notes, so the notes on the file and on the first experiment are enough.
    let of_first = first.map_or(&[][..], |checked| &checked.notes);
    let notes: Vec<String> = file.notes.iter().chain(of_first).cloned().collect();
    let sentence = worth.map_or("", |worth| &worth.sentence);
    print_result(format_args!("{}{text}\n{sentence}\n", terminal::notes(&notes)), || {
        let of = |(name, checked): &(String, Checked)| Ok::<_, serde_json::Error>((name.clone(), value(checked)?));
        let experiments = file.parts.iter().map(of).collect::<Result<serde_json::Map<_, _>, _>>()?;
        let (found, is_kept) = worth.map_or((None, true), |worth| (worth.found, worth.is_kept));
        Ok(json!({"notes": notes, "experiments": experiments, "d_efficiency_at_least": found, "proven_again": is_kept}))
    })
}
