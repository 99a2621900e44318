//! `rist identify --method rist|rist-mh`: the logs of a plan -> parameters.

use std::path::{Path, PathBuf};

use identification::estimate::options::Options;
use identification::spectrum::identify::SpectralMethod;
use logs::ColumnNames;
use rist::Estimate;
use rist::experiments::ExperimentLogs;
use rist::request::harmonic_request::HarmonicRequest;
use serde_json::json;

use super::arguments::Arguments;
use crate::artefact::{gains, read_load, read_plan};
use crate::failure::Failure;
use crate::terminal::{at_work, print_result};
use crate::verdict::{as_json, refused};
use rist::output::{check_output, write_file};

pub fn run(arguments: &Arguments, plan: &Path, method: SpectralMethod) -> Result<(), Failure> {
    let [directory] = arguments.logs.as_slice() else {
        return Err(Failure::new("--plan takes one directory of logs"));
    };
    let of_user =
        [&arguments.model.model].into_iter().chain(&arguments.plan).chain(&arguments.load).chain(&arguments.options);
    let inputs: Vec<&Path> = of_user.map(PathBuf::as_path).collect();
    arguments.out.iter().try_for_each(|out| check_output(out, &inputs))?;
    let columns = match &arguments.options {
        Some(path) => columns(path)?,
        None => Default::default(),
    };
    let model = arguments.model.derive()?;
    let plan = read_plan(plan, &model)?;
    let load = arguments.load.as_ref().map(|file| Ok::<_, Failure>((file.clone(), read_load(file)?))).transpose()?;
    let gains = gains(&arguments.gain, &model)?;
    let options = request(arguments).options(&model)?;
    let logs = ExperimentLogs { directory, plan: &plan, columns, gains, load, options };
    at_work(format_args!("identifying from {}", directory.display()));
    let estimate = rist::identify_experiments(&model, &logs, method)?;
    told(arguments, &estimate, inputs)
}

/// Prints an estimate of experiments with its verdict, and writes it; `inputs`: what was read beside the logs.
pub(super) fn told<'a>(
    arguments: &Arguments,
    estimate: &'a Estimate,
    mut inputs: Vec<&'a Path>,
) -> Result<(), Failure> {
    let verdict = rist::verdict::estimate_verdict(estimate);
    print_result(format_args!("{estimate}\n{verdict}"), || {
        Ok(json!({"estimate": serde_json::to_value(estimate)?, "verdict": as_json(&verdict)}))
    })?;
    if let Some(out) = &arguments.out {
        inputs.extend(estimate.logs.iter().map(Path::new));
        write_file(out, &estimate.to_yaml()?, &inputs)?;
    }
    refused(&verdict, false)
}

/// The columns of an options file, which has nothing else for experiments.
fn columns(path: &Path) -> Result<ColumnNames, Failure> {
    let given = Options::read(path)?;
    let columns = given.columns.clone();
    match given == (Options { columns: given.columns.clone(), ..Options::default() }) {
        true => Ok(columns),
        false => {
            Err(Failure::new(format_args!("{}: the experiments of a plan take no options but columns", path.display())))
        }
    }
}

/// What is asked of RIST-MH; the paper's rows have neither band nor effects.
fn request(arguments: &Arguments) -> HarmonicRequest {
    HarmonicRequest {
        cutoff: arguments.cutoff,
        delay: arguments.delay,
        ripple: arguments.ripple.clone(),
        elastic: arguments.elastic.clone(),
        play: arguments.play.clone(),
    }
}
