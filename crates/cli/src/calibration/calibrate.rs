//! `rist calibrate`: errors of the geometry, zeros and compliances from measured poses, points and distances.

use std::path::{Path, PathBuf};

use calibration::{CalibrateRequest, Calibrated, Calibration, calibrate, calibrate_model, calibrated_urdf};
use calibration::{inspected, zeros_table};
use clap::Args;
use rist::fit::verdict::Trust;
use rist::output::check_output;
use rist::{Robot, text_of};

use crate::artefact::{read_estimate, write_file};
use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::terminal::{at_work, note, print_result};

/// Calibrate the geometry of a robot from measured poses, points or distances
///
/// One row a posture: joint positions, and x y z with qx qy qz qw or roll pitch yaw, or points x1 y1 z1 x2 .., or a distance.
/// Base, tool and markers are unknown. Without a file it lists the base geometric parameters. Exit code 1 where the result is
/// not to be trusted.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// Joint positions and measurements of postures
    #[arg(value_name = "POSTURES")]
    postures: Option<PathBuf>,

    #[command(flatten)]
    request: Flags<CalibrateRequest>,

    /// Estimate whose torques bend the joints, for --what stiffness
    #[arg(long, value_name = "FILE")]
    estimate: Option<PathBuf>,

    /// Write the calibration as JSON
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Write the calibrated origins into a copy of the URDF
    #[arg(long, value_name = "FILE")]
    write_urdf: Option<PathBuf>,

    /// Write the zeros as a table
    #[arg(long, value_name = "FILE")]
    write_zeros: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let request = arguments.request.read()?;
    let Some(path) = &arguments.postures else {
        let (text, json) = inspected(&arguments.model.read_with_values()?, &request)?;
        return print_result(text, || Ok(json));
    };
    let of_user = [&arguments.model.model, path].into_iter().chain(&arguments.estimate);
    let inputs: Vec<&Path> = of_user.map(PathBuf::as_path).collect();
    let mut outputs = [&arguments.out, &arguments.write_urdf, &arguments.write_zeros].into_iter().flatten();
    outputs.try_for_each(|out| check_output(out, &inputs))?;
    let (robot, found) = calibrated(arguments, path, &request)?;
    print_result(&found, || Ok(found.to_json()))?;
    if let Some(out) = &arguments.out {
        write_file(out, format!("{:#}\n", found.to_json()))?;
    }
    if let Some(out) = &arguments.write_zeros {
        write_file(out, zeros_table(&found, found.level()))?;
    }
    if let Some(out) = &arguments.write_urdf {
        let text = text_of(&arguments.model.model)?;
        let file = arguments.model.model.display().to_string();
        write_file(out, calibrated_urdf(&text, &file, &robot, &found, found.level())?)?;
        note("read it with [angles=as-given]: otherwise angles near a quarter turn are rounded");
        if request.what == Calibrated::Stiffness {
            note("a URDF has no compliances: the zeros alone are written");
        }
        if !request.gears.is_empty() {
            note("a URDF has no scales of joints: they are in the files of [write-zeros] and [out]");
        }
    }
    match found.verdict.trust {
        Trust::No => Err(Failure::verdict(format_args!("not to be trusted: {}", found.verdict.reasons.join("; ")))),
        Trust::WithCare | Trust::Yes => Ok(()),
    }
}

/// Reads the description and calibrates the robot. Only the calibration of stiffness needs torques, and therefore the
/// derivation of the model.
fn calibrated(arguments: &Arguments, path: &Path, request: &CalibrateRequest) -> Result<(Robot, Calibration), Failure> {
    if request.what != Calibrated::Stiffness {
        let robot = arguments.model.read_with_values()?;
        at_work(format_args!("calibrating {}", arguments.model.model.display()));
        let found = calibrate(&robot, path, request, None)?;
        return Ok((robot, found));
    }
    let (estimate, model) = match &arguments.estimate {
        Some(file) => read_estimate(file, &arguments.model).map(|(estimate, model)| (Some(estimate), model))?,
        None => (None, arguments.model.derive()?),
    };
    let found = calibrate_model(&model, estimate.as_ref(), path, request)?;
    Ok((model.robot.clone(), found))
}
