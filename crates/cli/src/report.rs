//! `rist report`: writes an HTML page from artefacts and, for an estimate, from its logs.
//!
//! Artefacts are results that other commands write as files: plan, motion, estimate, validation. The logs are read again to
//! draw torques and residuals (plot data).

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use clap::Args;
use rist::fit::validation::PlotData;
use rist::fit::verdict::Verdict;
use rist::motion::exciting::ExcitingMotion;
use rist::motion::motion_plot_data::{MotionPlotData, ShownMotion, checked_motion, found_motion, motion_of_file};
use rist::page::{Origin, PageRequest};
use rist::request::ReportFiles;
use rist::request::spelling::Audience;
use rist::{Estimate, ExperimentPlan, LogSource, Model, ModelOptions, Validation};

use crate::artefact::{make_directory, read_text, write_file};
use crate::failure::Failure;
use crate::flags::Flags;
use crate::terminal::at_work;
use rist::output::check_output;

/// Write plan, motion, estimate and validation as one self-contained HTML page
///
/// If you give the model of an estimate from logs, the logs are read again. The page then has torques, residuals, their
/// spectrum, friction and limits, and the rules and meanings of the parameters. If you give the model of a motion, the
/// limits of the motion are proved again, and its torques and the path of its tip are drawn. If you give the model of a
/// plan, the plan is proved again too. Without a model, the page repeats the statements of the file, and says so.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    files: Flags<ReportFiles>,

    /// The page to write
    #[arg(long, value_name = "FILE", default_value = "report.html")]
    out: PathBuf,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let files: ReportFiles = arguments.files.read()?;
    check_parts(&files)?;
    let shown = [&files.plan, &files.motion, &files.estimate, &files.validation];
    // Input files, which the page must not overwrite.
    let of_user = shown.into_iter().chain([&files.model, &files.against]);
    let mut inputs: Vec<&Path> = of_user.flatten().chain(&files.log).map(PathBuf::as_path).collect();
    check_output(&arguments.out, &inputs)?;
    let plan = artefact(&files.plan, ExperimentPlan::from_yaml)?;
    let estimate = artefact(&files.estimate, Estimate::from_yaml)?;
    let against = against(&files, estimate.as_ref())?;
    let validation = artefact(&files.validation, Validation::from_yaml)?;
    let model = match &files.model {
        Some(path) => Some(read_model(path, &files, estimate.as_ref())?),
        None => None,
    };
    // For an estimate from samples of logs, plots of the logs are drawn. For an estimate from experiments of a plan, only the
    // verdict is shown.
    let drawn = match (&model, &estimate) {
        (Some(model), Some(estimate)) if estimate.options.is_some() => drawn(&files, model, estimate)?,
        (_, Some(estimate)) => {
            let predicted = validation.as_ref().map(|validation| validation.total);
            Drawn { verdict: Some(rist::fit::verdict::predicted_verdict(estimate, predicted)), plot_data: None }
        }
        _ => Drawn { verdict: None, plot_data: None },
    };
    let motion = match &files.motion {
        Some(path) => Some(read_motion(path, model.as_ref())?),
        None => None,
    };
    let plan_proof = match (&model, &plan, &files.plan) {
        (Some(model), Some(plan), Some(path)) => {
            at_work(format_args!("proving {}", path.display()));
            Some(rist::plan_proof(model, path, plan)?)
        }
        _ => None,
    };
    let command = command();
    let (page, pictures) = rist::page::page(&PageRequest {
        model: model.as_ref(),
        plan: plan.as_ref(),
        plan_proof: plan_proof.as_ref(),
        motion: motion.as_ref().map(|(artefact, plot_data)| ShownMotion { artefact, plot_data }),
        estimate: estimate.as_ref(),
        against: against.as_ref().map(|(name, other)| (name.as_str(), other)),
        plot_data: drawn.plot_data.as_ref(),
        validation: validation.as_ref(),
        verdict: drawn.verdict.as_ref(),
        origin: origin(files.date.as_deref(), &command),
        reader: Audience::Program,
    });
    inputs.extend(estimate.iter().flat_map(|e| &e.logs).map(Path::new));
    if let Some(directory) = &files.svg {
        make_directory(directory)?;
        for (name, svg) in &pictures {
            write_file(&directory.join(name), svg)?;
        }
    }
    Ok(write_file(&arguments.out, &page)?)
}

/// Fails if the page would be empty, or if a file is missing that another file needs.
fn check_parts(files: &ReportFiles) -> Result<(), Failure> {
    let shown = [&files.plan, &files.motion, &files.estimate, &files.validation];
    if shown.iter().all(|file| file.is_none()) {
        return Err(Failure::new(
            "a page shows a [plan], a [motion], an [estimate] or a [validation]; give one or more",
        ));
    }
    if files.against.is_some() && files.estimate.is_none() {
        return Err(Failure::new("[against] needs the estimate that it is held against: [estimate]"));
    }
    if files.model.is_none() && !files.log.is_empty() {
        return Err(Failure::new("[log] needs the description that it is drawn with: [model]"));
    }
    Ok(())
}

/// The second estimate for a comparison, and the name of its file. Fails if the two estimates are of different models, because
/// their parameters cannot be compared then.
fn against(files: &ReportFiles, estimate: Option<&Estimate>) -> Result<Option<(String, Estimate)>, Failure> {
    let Some((other, path)) = artefact(&files.against, Estimate::from_yaml)?.zip(files.against.as_ref()) else {
        return Ok(None);
    };
    let name = path.display().to_string();
    if let (Some(estimate), Some(file)) = (estimate, &files.estimate) {
        rist::page::check_comparable([&file.display().to_string(), &name], [estimate, &other])?;
    }
    Ok(Some((name, other)))
}

/// Reads the artefact in a file; `None` if no file is given.
fn artefact<T, E: Into<rist::Error>>(
    file: &Option<PathBuf>,
    read: fn(&str, &str) -> Result<T, E>,
) -> Result<Option<T>, Failure> {
    let Some(path) = file else { return Ok(None) };
    Ok(Some(read(&path.display().to_string(), &read_text(path)?)?))
}

/// The page of an estimate, with predicted logs and validation.
pub(crate) fn page_of(
    model: &Model,
    estimate: &Estimate,
    logs: &[LogSource],
    validation: Option<&Validation>,
    verdict: &Verdict,
    date: Option<&str>,
) -> Result<String, Failure> {
    let plot_data = rist::fit::validation::plot_data(model, estimate, logs)?;
    let command = command();
    let request = PageRequest {
        model: Some(model),
        estimate: Some(estimate),
        plot_data: plot_data.as_ref(),
        validation,
        verdict: Some(verdict),
        origin: origin(date, &command),
        reader: Audience::Program,
        ..PageRequest::default()
    };
    Ok(rist::page::page(&request).0)
}

/// The page of a motion that was just found.
pub(crate) fn page_of_motion(model: &Model, found: &ExcitingMotion, date: Option<&str>) -> Result<String, Failure> {
    let plot_data = found_motion(model, found)?;
    let command = command();
    let request = PageRequest {
        model: Some(model),
        motion: Some(ShownMotion { artefact: found, plot_data: &plot_data }),
        origin: origin(date, &command),
        reader: Audience::Program,
        ..PageRequest::default()
    };
    Ok(rist::page::page(&request).0)
}

/// Reads a motion and its plot data. If the model is given, the limits of the motion are proved again.
fn read_motion(path: &Path, model: Option<&Model>) -> Result<(ExcitingMotion, MotionPlotData), Failure> {
    let artefact = ExcitingMotion::from_yaml(&path.display().to_string(), &read_text(path)?)?;
    let plot_data = match model {
        Some(model) => {
            at_work(format_args!("proving the limits of {}", path.display()));
            checked_motion(model, path, &artefact)?
        }
        None => motion_of_file(path, &artefact)?,
    };
    Ok((artefact, plot_data))
}

/// The date, version and command that are printed on a page.
pub(crate) fn origin<'a>(date: Option<&'a str>, command: &'a str) -> Origin<'a> {
    Origin { date, version: env!("CARGO_PKG_VERSION"), command, model: None }
}

/// The words of the command line, stored at the start of the program.
static COMMAND: OnceLock<Vec<OsString>> = OnceLock::new();

/// Stores the words of the command line, which pages print. The first word is the program's name.
pub(crate) fn set_command(words: &[OsString]) {
    // Only the first call has an effect. It happens at the start of the program.
    let _ = COMMAND.set(words.to_vec());
}

/// The command line that a page prints, quoted for a shell.
pub(crate) fn command() -> String {
    let quoted =
        |word: String| match word.is_empty() || word.contains(|c: char| c.is_whitespace() || "'\"$`".contains(c)) {
            true => format!("'{}'", word.replace('\'', "'\\''")),
            false => word,
        };
    let words = COMMAND.get().into_iter().flatten().skip(1).map(|word| quoted(word.to_string_lossy().into_owned()));
    ["rist".to_string()].into_iter().chain(words).collect::<Vec<_>>().join(" ")
}

/// Reads the model with the reading options of the estimate. Fails if the estimate was made with another model.
fn read_model(path: &Path, files: &ReportFiles, estimate: Option<&Estimate>) -> Result<Model, Failure> {
    let options = estimate.and_then(|e| e.description.as_ref()).map(ModelOptions::of_description);
    let model = Model::read_with(path, &options.unwrap_or_default())?;
    if let (Some(estimate), Some(file)) = (estimate, &files.estimate) {
        model.check_estimate(file, estimate)?;
    }
    Ok(model)
}

/// The verdict on an estimate, and the plot data of its logs.
struct Drawn {
    verdict: Option<Verdict>,
    plot_data: Option<PlotData>,
}

fn drawn(files: &ReportFiles, model: &Model, estimate: &Estimate) -> Result<Drawn, Failure> {
    let Some(options) = &estimate.options else {
        return Ok(Drawn { verdict: Some(rist::fit::verdict::estimate_verdict(estimate)), plot_data: None });
    };
    let fitted: Vec<PathBuf> = estimate.logs.iter().map(PathBuf::from).collect();
    let is_of_others = !files.log.is_empty();
    let paths = if is_of_others { &files.log } else { &fitted };
    let open = |path: &PathBuf| match model.open_log(path, &options.columns) {
        Ok((log, _)) => Ok(log),
        Err(e) if is_of_others => Err(Failure::new(e)),
        Err(e) => Err(Failure::new(format_args!(
            "{e}\nthe estimate was made from this log; run in the directory that its path is relative to, or say \
             where it is with [log]"
        ))),
    };
    at_work("reading the logs once more");
    let logs: Vec<LogSource> = paths.iter().map(open).collect::<Result<_, _>>()?;
    let verdict = match is_of_others {
        true => {
            let total = rist::validate(model, estimate, &logs)?.total;
            let are_new = !paths.iter().any(|log| rist::fit::validation::is_fitted(estimate, log));
            rist::fit::verdict::validation_verdict(model, estimate, &logs, total, are_new)?
        }
        false => rist::fit::verdict::fitted_verdict(model, estimate, &logs)?,
    };
    Ok(Drawn { verdict: Some(verdict), plot_data: rist::fit::validation::plot_data(model, estimate, &logs)? })
}
