//! `rist report`: artefacts -> one page and its pictures.

use std::path::{Path, PathBuf};

use clap::Args;
use identification::estimate::artefact::Estimate;
use identification::estimate::validation::Validation;
use identification::experiments::experiment_plan::ExperimentPlan;
use identification::write::html::{parameter_picture, report, torque_picture};

use crate::artefact::{make_directory, read_text};
use crate::failure::Failure;
use rist::{check_output, write_file};

/// Write plan, estimate and validation as one self-contained HTML page
#[derive(Args)]
pub struct Arguments {
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,

    #[arg(long, value_name = "FILE")]
    estimate: Option<PathBuf>,

    #[arg(long, value_name = "FILE")]
    validation: Option<PathBuf>,

    /// The page
    #[arg(long, value_name = "FILE", default_value = "report.html")]
    out: PathBuf,

    /// Write the pictures as SVG into this directory too
    #[arg(long, value_name = "DIRECTORY")]
    svg: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let name = |path: &PathBuf| path.display().to_string();
    let of_user = [&arguments.plan, &arguments.estimate, &arguments.validation];
    let inputs: Vec<&Path> = of_user.into_iter().flatten().map(PathBuf::as_path).collect();
    check_output(&arguments.out, &inputs)?;
    let plan = match &arguments.plan {
        Some(path) => Some(ExperimentPlan::from_yaml(&name(path), &read_text(path)?)?),
        None => None,
    };
    let estimate = match &arguments.estimate {
        Some(path) => Some(Estimate::from_yaml(&name(path), &read_text(path)?)?),
        None => None,
    };
    let validation = match &arguments.validation {
        Some(path) => Some(Validation::from_yaml(&name(path), &read_text(path)?)?),
        None => None,
    };
    if let Some(directory) = &arguments.svg {
        make_directory(directory)?;
        if let Some(estimate) = &estimate {
            write_file(&directory.join("parameters.svg"), &parameter_picture(estimate), &inputs)?;
        }
        for picture in validation.iter().flat_map(|v| &v.pictures) {
            let file = directory.join(format!("torque_{}.svg", picture.coordinate));
            write_file(&file, &torque_picture(picture), &inputs)?;
        }
    }
    Ok(write_file(&arguments.out, &report(plan.as_ref(), estimate.as_ref(), validation.as_ref()), &inputs)?)
}
