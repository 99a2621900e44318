//! `rist report`: artefacts, and logs where an estimate was made from some -> one page and its pictures.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};
use experiments::plan::experiment_plan::ExperimentPlan;
use identification::estimate::artefact::Estimate;
use identification::estimate::validation::Validation;
use rist::exciting::ExcitingMotion;
use rist::motion_portrait::{MotionPortrait, ShownMotion, checked_motion, found_motion, motion_of_file};
use rist::page::{Origin, PageRequest};
use rist::request::spelling::Reader;
use rist::validation::Portrait;
use rist::verdict::Verdict;
use rist::{LogSource, Model, ModelOptions};

use crate::artefact::{make_directory, read_text};
use crate::failure::Failure;
use crate::terminal::at_work;
use rist::output::{check_output, write_file};

/// Write plan, motion, estimate and validation as one self-contained HTML page
///
/// With the model of an estimate from logs, the logs are read once more: torques, residuals, their spectrum, friction and
/// limits are drawn, and parameters have their rules and meanings. With the model of a motion its limits are proved once
/// more, and its torques and the path of its tip are drawn.
#[derive(Args)]
#[command(group = ArgGroup::new("artefacts").args(["plan", "motion", "estimate", "validation"]).multiple(true).required(true))]
pub struct Arguments {
    /// The plan of rist plan
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,

    /// The motion of rist excite
    #[arg(long, value_name = "FILE")]
    motion: Option<PathBuf>,

    /// The estimate of rist identify or rist solve
    #[arg(long, value_name = "FILE")]
    estimate: Option<PathBuf>,

    /// The validation of rist validate
    #[arg(long, value_name = "FILE")]
    validation: Option<PathBuf>,

    /// The description that the estimate, or the motion, was made with
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,

    /// Logs to draw [default: those that the estimate was made from]
    #[arg(long, value_name = "LOG", requires = "model")]
    log: Vec<PathBuf>,

    /// The date on the page, in any form
    #[arg(long)]
    date: Option<String>,

    /// The page
    #[arg(long, value_name = "FILE", default_value = "report.html")]
    out: PathBuf,

    /// Write the pictures as SVG into this directory too
    #[arg(long, value_name = "DIRECTORY")]
    svg: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let name = |path: &PathBuf| path.display().to_string();
    let of_user = [&arguments.plan, &arguments.motion, &arguments.estimate, &arguments.validation, &arguments.model];
    let mut inputs: Vec<&Path> = of_user.into_iter().flatten().chain(&arguments.log).map(PathBuf::as_path).collect();
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
    let model = match &arguments.model {
        Some(path) => Some(read_model(path, arguments, estimate.as_ref())?),
        None => None,
    };
    let drawn = match (&model, &estimate) {
        (Some(model), Some(estimate)) if estimate.options.is_some() => drawn(arguments, model, estimate)?,
        (_, Some(estimate)) => {
            let predicted = validation.as_ref().map(|validation| validation.total);
            Drawn { verdict: Some(rist::verdict::predicted_verdict(estimate, predicted)), portrait: None }
        }
        _ => Drawn { verdict: None, portrait: None },
    };
    let motion = match &arguments.motion {
        Some(path) => Some(read_motion(path, model.as_ref())?),
        None => None,
    };
    let command = command();
    let (page, pictures) = rist::page::page(&PageRequest {
        model: model.as_ref(),
        plan: plan.as_ref(),
        motion: motion.as_ref().map(|(artefact, portrait)| ShownMotion { artefact, portrait }),
        estimate: estimate.as_ref(),
        portrait: drawn.portrait.as_ref(),
        validation: validation.as_ref(),
        verdict: drawn.verdict.as_ref(),
        origin: origin(arguments.date.as_deref(), &command),
        reader: Reader::Program,
    });
    inputs.extend(estimate.iter().flat_map(|e| &e.logs).map(Path::new));
    if let Some(directory) = &arguments.svg {
        make_directory(directory)?;
        for (name, svg) in &pictures {
            write_file(&directory.join(name), svg, &inputs)?;
        }
    }
    Ok(write_file(&arguments.out, &page, &inputs)?)
}

/// The page of an estimate, with what it makes of logs and of those that it is validated on.
pub fn page_of(
    model: &Model,
    estimate: &Estimate,
    logs: &[LogSource],
    validation: Option<&Validation>,
    verdict: &Verdict,
    date: Option<&str>,
) -> Result<String, Failure> {
    let portrait = rist::validation::portrait(model, estimate, logs)?;
    let command = command();
    let request = PageRequest {
        model: Some(model),
        estimate: Some(estimate),
        portrait: portrait.as_ref(),
        validation,
        verdict: Some(verdict),
        origin: origin(date, &command),
        reader: Reader::Program,
        ..PageRequest::default()
    };
    Ok(rist::page::page(&request).0)
}

/// The page of a motion that was found just now.
pub fn page_of_motion(model: &Model, found: &ExcitingMotion, date: Option<&str>) -> Result<String, Failure> {
    let portrait = found_motion(model, found)?;
    let command = command();
    let request = PageRequest {
        model: Some(model),
        motion: Some(ShownMotion { artefact: found, portrait: &portrait }),
        origin: origin(date, &command),
        reader: Reader::Program,
        ..PageRequest::default()
    };
    Ok(rist::page::page(&request).0)
}

/// A motion, and what is drawn of it; proved once more where its model is there.
fn read_motion(path: &Path, model: Option<&Model>) -> Result<(ExcitingMotion, MotionPortrait), Failure> {
    let artefact = ExcitingMotion::from_yaml(&path.display().to_string(), &read_text(path)?)?;
    let portrait = match model {
        Some(model) => {
            at_work(format_args!("proving the limits of {}", path.display()));
            checked_motion(model, path, &artefact)?
        }
        None => motion_of_file(path, &artefact)?,
    };
    Ok((artefact, portrait))
}

/// Version and command of a page.
fn origin<'a>(date: Option<&'a str>, command: &'a str) -> Origin<'a> {
    Origin { date, version: env!("CARGO_PKG_VERSION"), command, model: None }
}

/// The command as it was typed, for the page.
fn command() -> String {
    let quoted =
        |word: String| match word.is_empty() || word.contains(|c: char| c.is_whitespace() || "'\"$`".contains(c)) {
            true => format!("'{}'", word.replace('\'', "'\\''")),
            false => word,
        };
    let words = std::env::args_os().skip(1).map(|word| quoted(word.to_string_lossy().into_owned()));
    ["rist".to_string()].into_iter().chain(words).collect::<Vec<_>>().join(" ")
}

/// The model, read as it was for the estimate; refused where that was made with another.
fn read_model(path: &Path, arguments: &Arguments, estimate: Option<&Estimate>) -> Result<Model, Failure> {
    let options = estimate.and_then(|e| e.description.as_ref()).map(ModelOptions::of_description);
    let model = Model::read_with(path, &options.unwrap_or_default())?;
    if let (Some(estimate), Some(file)) = (estimate, &arguments.estimate) {
        let made_with = estimate.made_with();
        model.check(file, &made_with)?;
    }
    Ok(model)
}

/// What the logs say.
struct Drawn {
    verdict: Option<Verdict>,
    portrait: Option<Portrait>,
}

fn drawn(arguments: &Arguments, model: &Model, estimate: &Estimate) -> Result<Drawn, Failure> {
    let Some(options) = &estimate.options else {
        return Ok(Drawn { verdict: Some(rist::verdict::estimate_verdict(estimate)), portrait: None });
    };
    let fitted: Vec<PathBuf> = estimate.logs.iter().map(PathBuf::from).collect();
    let is_of_others = !arguments.log.is_empty();
    let paths = if is_of_others { &arguments.log } else { &fitted };
    let open = |path: &PathBuf| match model.open_log(path, &options.columns) {
        Ok((log, _)) => Ok(log),
        Err(e) if is_of_others => Err(Failure::new(e)),
        Err(e) => Err(Failure::new(format_args!(
            "{e}\nthe estimate was made from this log; run in the directory that its path is relative to, or say \
             where it is with --log"
        ))),
    };
    at_work("reading the logs once more");
    let logs: Vec<LogSource> = paths.iter().map(open).collect::<Result<_, _>>()?;
    let verdict = match is_of_others {
        true => {
            let total = rist::validate(model, estimate, &logs)?.total;
            let are_new = !paths.iter().any(|log| rist::validation::is_fitted(estimate, log));
            rist::verdict::validation_verdict(model, estimate, &logs, total, are_new)?
        }
        false => rist::verdict::fitted_verdict(model, estimate, &logs)?,
    };
    Ok(Drawn { verdict: Some(verdict), portrait: rist::validation::portrait(model, estimate, &logs)? })
}
