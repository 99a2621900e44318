//! `rist calibrate`: errors of the geometry, zeros and compliances from measured poses, points and distances.
//!
//! Without a table of measurements, the command lists the base geometric parameters, or chooses postures that should be
//! measured. The calibration itself is in the package `calibration`.

use std::path::{Path, PathBuf};

use calibration::{CalibrateRequest, Calibrated, Calibration, calibrate, calibrate_model, calibrated_urdf};
use calibration::{calibrated_yaml, design, inspected, ur_kinematics, zeros_table};
use clap::Args;
use rist::fit::verdict::Trust;
use rist::output::check_output;
use rist::page::Origin;
use rist::request::spelling::{Audience, spelled};
use rist::{AngleSnapping, ModelOptions, Robot, parse_robot, text_of};

use crate::artefact::{read_estimate, write_file};
use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::report::{command, origin};
use crate::terminal::{at_work, note, print_result};

/// Calibrate the geometry of a robot from measured poses, points or distances
///
/// Each row of the table is a posture: joint positions, and x y z with qx qy qz qw or roll pitch yaw, or points x1 y1 z1 x2
/// .., or a distance. The frames of base, tool and markers are unknown and are fitted too. Without a table, the command
/// lists the base geometric parameters, or chooses postures to measure (--design). Exit code 1: the result is not to be
/// trusted.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// Table with joint positions and measurements of postures
    #[arg(value_name = "POSTURES")]
    postures: Option<PathBuf>,

    #[command(flatten)]
    request: Flags<CalibrateRequest>,

    /// Estimate from which the torques that bend the joints are computed, for --what stiffness
    #[arg(long, value_name = "FILE")]
    estimate: Option<PathBuf>,

    /// Write the calibration as JSON, or the chosen postures as CSV
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Write the calibrated origins into a copy of the URDF
    #[arg(long, value_name = "FILE")]
    write_urdf: Option<PathBuf>,

    /// Write the calibrated table into a copy of the YAML description
    #[arg(long, value_name = "FILE")]
    write_yaml: Option<PathBuf>,

    /// Write the kinematics of a UR robot, a YAML for ur_description
    #[arg(long, value_name = "FILE")]
    write_ur: Option<PathBuf>,

    /// Write the zeros of the joints as a table
    #[arg(long, value_name = "FILE")]
    write_zeros: Option<PathBuf>,

    /// Write an HTML page with the verdict, the errors before and after, and the calibrated parameters
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,

    /// The date on the page of --report, in any form
    #[arg(long, requires = "report")]
    date: Option<String>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let request = arguments.request.read()?;
    let Some(path) = &arguments.postures else { return without_table(arguments, &request) };
    let of_user = [&arguments.model.model, path].into_iter().chain(&arguments.estimate);
    let inputs: Vec<&Path> = of_user.map(PathBuf::as_path).collect();
    let Arguments { out, write_urdf, write_yaml, write_ur, write_zeros, report, .. } = arguments;
    let mut outputs = [out, write_urdf, write_yaml, write_ur, write_zeros, report].into_iter().flatten();
    outputs.try_for_each(|out| check_output(out, &inputs))?;
    let (robot, found) = calibrated(arguments, path, &request)?;
    print_result(&found, || Ok(found.to_json()))?;
    if let Some(out) = out {
        write_file(out, format!("{:#}\n", found.to_json()))?;
    }
    if let Some(out) = write_zeros {
        write_file(out, zeros_table(&found, found.level()))?;
    }
    if let Some(out) = report {
        let (command, path) = (command(), arguments.model.model.display().to_string());
        let origin = Origin { model: Some(&path), ..origin(arguments.date.as_deref(), &command) };
        write_file(out, spelled(&found.page(&robot, &origin), Audience::Program))?;
    }
    write_descriptions(arguments, &request, &robot, &found)?;
    match found.verdict.trust {
        Trust::No => Err(Failure::verdict(format_args!("not to be trusted: {}", found.verdict.reasons.join("; ")))),
        Trust::WithCare | Trust::Yes => Ok(()),
    }
}

/// Lists the base parameters, or chooses postures.
fn without_table(arguments: &Arguments, request: &CalibrateRequest) -> Result<(), Failure> {
    let robot = arguments.model.read_with_values()?;
    let Some(count) = request.design else {
        let (text, json) = inspected(&robot, request)?;
        return print_result(text, || Ok(json));
    };
    let model = arguments.model.model.as_path();
    arguments.out.iter().try_for_each(|out| check_output(out, &[model]))?;
    at_work(format_args!("choosing postures of {}", model.display()));
    let found = design(&robot, model.parent().unwrap_or(Path::new("")), request, count)?;
    print_result(&found, || Ok(found.to_json()))?;
    Ok(arguments.out.iter().try_for_each(|out| write_file(out, found.to_csv()))?)
}

/// Writes the calibrated geometry in the forms that are asked for.
fn write_descriptions(
    arguments: &Arguments,
    request: &CalibrateRequest,
    robot: &Robot,
    found: &Calibration,
) -> Result<(), Failure> {
    let Arguments { write_urdf, write_yaml, write_ur, .. } = arguments;
    if [write_urdf, write_yaml, write_ur].into_iter().all(Option::is_none) {
        return Ok(());
    }
    let (model, level) = (&arguments.model.model, found.level());
    let (text, file) = (text_of(model)?, model.display().to_string());
    if let Some(out) = write_yaml {
        // The written text is read again as a test. This test must not round calibrated angles near a multiple of pi/12.
        let options = ModelOptions { angles: AngleSnapping::AsGiven, ..arguments.model.options()? };
        let read = |text: &str| parse_robot(text, model, &options);
        write_file(out, calibrated_yaml(&text, &file, &read, robot, found, level)?)?;
    }
    if write_urdf.is_some() || write_ur.is_some() {
        // The kinematics of a UR are computed from the calibrated URDF, so both outputs need this URDF.
        let urdf = calibrated_urdf(&text, &file, robot, found, level)?;
        write_ur.iter().try_for_each(|out| write_file(out, ur_kinematics(&urdf, &file, robot)?))?;
        write_urdf.iter().try_for_each(|out| write_file(out, &urdf))?;
    }
    if write_urdf.is_some() || write_yaml.is_some() {
        note("read it with [angles=as-given]: otherwise angles near a quarter turn are rounded");
    }
    if request.what == Calibrated::Stiffness {
        note("a description has no compliances: the zeros alone are written");
    }
    Ok(())
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
