//! `rist identify --method rist|rist-mh`: the logs of a plan -> parameters.

use std::path::Path;

use identification::estimate::options::Options;
use identification::spectrum::identify::SpectralMethod;
use rist::ExperimentLogs;

use super::arguments::Arguments;
use crate::artefact::{gains, read_load, read_plan};
use crate::failure::{Failure, print, write_file};
use crate::verdict::refused;

pub fn run(arguments: &Arguments, plan: &Path, method: SpectralMethod) -> Result<(), Failure> {
    let [directory] = arguments.logs.as_slice() else {
        return Err(Failure::new("--plan takes one directory of logs"));
    };
    let columns = match &arguments.options {
        Some(path) => Options::read(path)?.columns,
        None => Default::default(),
    };
    let model = arguments.model.derive()?;
    let plan = read_plan(plan, &model)?;
    let load = arguments.load.as_ref().map(|file| Ok::<_, Failure>((file.clone(), read_load(file)?))).transpose()?;
    let gains = gains(&arguments.gain, &model)?;
    let estimate =
        rist::identify_experiments(&model, &ExperimentLogs { directory, plan: &plan, columns, gains, load }, method)?;
    let verdict = rist::estimate_verdict(&estimate);
    print(&format!("{estimate}\n{verdict}"))?;
    if let Some(out) = &arguments.out {
        write_file(out, &estimate.to_yaml()?)?;
    }
    refused(&verdict, false)
}
