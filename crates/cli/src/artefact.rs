//! Reads and writes the artefacts of the commands: plans, motions, estimates and others.
//!
//! An artefact is a result that one command writes as a file and another command reads: a plan (experiments), an exciting
//! motion, an estimate (identified parameters with standard deviations). Each file states the model with which it was made, and
//! reading fails if this is another model. Outputs are written completely or not at all, and never over an input.

use std::path::{Path, PathBuf};

use rist::fit::validation::{TorqueSeries, series_to_csv, series_to_parquet};
use rist::gate::opened;
use rist::output::{check_output, is_same};
pub(crate) use rist::read_text;
use rist::{ArtefactKind, Estimate, ExcitingMotion, ExperimentPlan, Model};

use crate::failure::Failure;
use crate::interrupt::undivided;
use crate::model::ModelArguments;

/// Creates a directory if it does not exist. Fails if the parent directory does not exist, because a missing parent is probably
/// a typing error.
pub(crate) fn make_directory(path: &Path) -> Result<(), Failure> {
    if path.is_dir() {
        return Ok(());
    }
    check_output(path, &[])?;
    std::fs::create_dir(path).map_err(|e| Failure::new(format_args!("{}: {e}", path.display())))
}

/// Reads an estimate and derives its model. The model is read with the options of the estimate, unless flags replace them.
/// Fails if the estimate was made with another model.
pub(crate) fn read_estimate(path: &Path, arguments: &ModelArguments) -> Result<(Estimate, Model), Failure> {
    let estimate = Estimate::from_yaml(&path.display().to_string(), &read_text(path)?)?;
    let model = model_of(&estimate, path, arguments)?;
    Ok((estimate, model))
}

/// Derives the model of the estimate in the file `path`. The model is read with the options of the estimate, unless flags
/// replace them. Fails if the estimate was made with another model.
pub(crate) fn model_of(estimate: &Estimate, path: &Path, arguments: &ModelArguments) -> Result<Model, Failure> {
    let model = arguments.derive_as(estimate.description.as_ref())?;
    model.check_estimate(path, estimate)?;
    Ok(model)
}

/// Reads a plan. Fails if the plan was made with another model.
pub(crate) fn read_plan(path: &Path, model: &Model) -> Result<ExperimentPlan, Failure> {
    let plan = ExperimentPlan::from_yaml(&path.display().to_string(), &read_text(path)?)?;
    model.check(path, &plan.model)?;
    Ok(plan)
}

/// The content of a file with torques over time: Parquet if the extension is .parquet, otherwise CSV.
pub(crate) fn series_text(out: &Path, series: &[TorqueSeries], coordinates: &[String]) -> Result<Vec<u8>, Failure> {
    match out.extension().is_some_and(|end| end.eq_ignore_ascii_case("parquet")) {
        true => Ok(series_to_parquet(series, coordinates)?),
        false => Ok(series_to_csv(series, coordinates).into_bytes()),
    }
}

/// A file that `rist simulate` takes.
pub(crate) enum MotionFile {
    /// A plan of `rist plan`.
    Plan(Box<ExperimentPlan>),
    /// A motion of `rist excite`.
    Motion(Box<ExcitingMotion>),
}

/// Reads a plan or a motion. Fails if the file was made with another model.
pub(crate) fn read_motions(path: &Path, model: &Model) -> Result<MotionFile, Failure> {
    let (file, text) = (path.display().to_string(), read_text(path)?);
    // Files of earlier versions do not state their kind. A motion has the key `period_s`, and a plan does not have this key.
    let is_motion = ArtefactKind::of(&text)
        .map_or(text.lines().any(|line| line.starts_with("period_s:")), |kind| kind == ArtefactKind::Motion);
    if !is_motion {
        return Ok(MotionFile::Plan(Box::new(read_plan(path, model)?)));
    }
    let motion = ExcitingMotion::from_yaml(&file, &text)?;
    model.check(path, &motion.model)?;
    motion.motion(&file)?;
    Ok(MotionFile::Motion(Box::new(motion)))
}

/// Writes a file completely or not at all, and never overwrites a file that the program read.
pub(crate) fn write_file(out: &Path, content: impl AsRef<[u8]>) -> Result<(), rist::Error> {
    let read = opened::all();
    let inputs: Vec<&Path> = read.iter().map(PathBuf::as_path).collect();
    undivided(|| rist::output::write_file(out, content, &inputs))
}

/// Fails if an output is also an input, or if two outputs are the same file.
pub(crate) fn check_outputs<'a>(
    outputs: impl IntoIterator<Item = &'a PathBuf>,
    inputs: &[&Path],
) -> Result<(), Failure> {
    let mut written: Vec<&Path> = Vec::new();
    for out in outputs {
        check_output(out, inputs)?;
        if written.iter().any(|other| is_same(out, other)) {
            return Err(Failure::new(format_args!("{}: two outputs have this name", out.display())));
        }
        written.push(out);
    }
    Ok(())
}
