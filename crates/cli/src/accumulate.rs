//! `rist accumulate`: logs and a model -> sums, without which the logs are not needed again.

use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;
use identification::estimate::options::Options;
use identification::estimators::weighted::Weights;
use identification::signals::signal_options::possible_delay;
use linear_model::friction::terms::FrictionTerm;
use rist::fleet::AccumulateRequest;
use rist::{Accumulator, Model};
use serde_json::json;

use crate::artefact::{gains, read_sums};
use crate::failure::Failure;
use crate::identify::{Friction, friction};
use crate::model::ModelArguments;
use crate::terminal::{at_work, print_result};
use rist::output::{check_output, is_same, write_file};

/// Add logs up into sums, which rist merge, rist solve and rist compare take instead of the logs
///
/// The logs are read as rist identify reads them. All parts of one sum need the same cut-off. Give it, or take all
/// settings of the first part with --like. Without either, it follows from the motion of all logs given here, which are
/// then read twice.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The logs, as rist identify takes them
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,

    /// The sums
    #[arg(long, value_name = "FILE.tri")]
    out: PathBuf,

    /// Take the settings of these sums: columns, cut-off, friction, transmission, gains, weights
    #[arg(long, value_name = "FILE.tri", conflicts_with_all = ["cutoff", "order", "decimate", "delay", "friction", "weights", "options", "gain"])]
    like: Option<PathBuf>,

    /// Cut-off of the zero-phase low-pass, Hz [default: by the frequency content of the logs]
    #[arg(long, value_name = "HZ")]
    cutoff: Option<f64>,

    /// Order of the Butterworth filter, 0 for none [default: 4]
    #[arg(long)]
    order: Option<usize>,

    /// Keep every N-th filtered sample [default: ten a period of the cut-off]
    #[arg(long, value_name = "N", value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..))]
    decimate: Option<usize>,

    /// Seconds by which the torques lag the positions [default: 0]; rist identify --delay auto finds it
    #[arg(long, value_name = "SECONDS", value_parser = delay)]
    delay: Option<f64>,

    /// Friction columns a joint, as rist identify takes them, but not auto [default: viscous,coulomb,offset]
    #[arg(long, value_delimiter = ',', value_name = "TERMS", value_parser = friction)]
    friction: Option<Vec<Friction>>,

    /// What rows weigh: none or joint [default: joint]
    #[arg(long, value_parser = weights)]
    weights: Option<Weights>,

    /// Torque per unit of current of every drive, N m/A [default: as the description says]
    #[arg(long, value_name = "COORDINATE=GAIN", value_delimiter = ',')]
    gain: Vec<String>,

    /// YAML with any option of an identification; flags override it
    #[arg(long, value_name = "FILE")]
    options: Option<PathBuf>,

    /// Leave out logs that cannot be used or are not of this robot; the sums say which and why
    #[arg(long)]
    skip_broken: bool,

    /// Take logs in that do not belong to the description (rist doctor)
    #[arg(long)]
    anyway: bool,

    /// Logs that are read at a time [default: as many as there are processors]; the sums are the same
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let logs = &arguments.logs;
    if let Some(i) = (1..logs.len()).find(|&i| logs[..i].iter().any(|other| is_same(&logs[i], other))) {
        return Err(Failure::new(format_args!("{}: given twice; a log counts once", logs[i].display())));
    }
    let others = [&arguments.model.model].into_iter().chain(&arguments.options).chain(&arguments.like);
    let inputs: Vec<&Path> = logs.iter().chain(others).map(PathBuf::as_path).collect();
    check_output(&arguments.out, &inputs)?;
    let (model, options) = model_and_options(arguments)?;
    let request = AccumulateRequest {
        options,
        gains: gains(&arguments.gain, &model)?,
        skip_broken: arguments.skip_broken,
        anyway: arguments.anyway,
        threads: arguments.threads,
    };
    at_work(format_args!("adding {} logs up", logs.len()));
    let sums = rist::accumulate(&model, logs, &request)?;
    write_file(&arguments.out, &sums.to_bytes()?, &inputs)?;
    print_account(&sums)
}

/// The model, and the options of `--like`, or else of the flags over those of a file.
fn model_and_options(arguments: &Arguments) -> Result<(Model, Options), Failure> {
    if let Some(path) = &arguments.like {
        let like = read_sums(path)?;
        let model = arguments.model.derive_as(like.settings().description.as_ref())?;
        rist::fleet::check_sums(&model, &like).map_err(|e| Failure::new(format_args!("{}: {e}", path.display())))?;
        return Ok((model, like.settings().options.clone()));
    }
    let model = arguments.model.derive()?;
    let mut options = match &arguments.options {
        Some(path) => Options::read(path)?,
        None => Options::default(),
    };
    let signal = &mut options.signal;
    signal.cutoff = arguments.cutoff.or(signal.cutoff);
    signal.order = arguments.order.unwrap_or(signal.order);
    signal.decimate = arguments.decimate.or(signal.decimate);
    signal.delay = arguments.delay.unwrap_or(signal.delay);
    options.weights = arguments.weights.unwrap_or(options.weights);
    if let Some(words) = &arguments.friction {
        options.friction = terms(words)?;
    }
    Ok((model, options))
}

/// The terms of friction; auto needs the rows again for each candidate.
fn terms(words: &[Friction]) -> Result<Vec<FrictionTerm>, Failure> {
    if words.contains(&Friction::Auto) {
        return Err(Failure::new(
            "--friction auto: it goes over the rows once for each candidate, and sums have no rows; let rist identify choose \
             it on some of the logs, and give here what it chose",
        ));
    }
    let mut terms = Vec::new();
    for (i, word) in words.iter().enumerate() {
        match word {
            Friction::Term(_) if words[..i].contains(word) => {
                return Err(Failure::new(format_args!("--friction: word {} stands there twice", i + 1)));
            }
            Friction::Term(term) => terms.push(*term),
            Friction::None | Friction::Auto if words.len() > 1 => {
                return Err(Failure::new("--friction: none stands alone"));
            }
            Friction::None | Friction::Auto => {}
        }
    }
    Ok(terms)
}

/// Prints what is in the sums.
pub fn print_account(sums: &Accumulator) -> Result<(), Failure> {
    print_result(account(sums), || {
        let failed: Vec<_> = sums.failed().iter().map(|f| json!({"name": f.name, "reason": f.reason})).collect();
        Ok(json!({
            "model": sums.settings().model.name,
            "columns": sums.settings().columns.len(),
            "cutoff_hz": sums.settings().options.signal.cutoff,
            "logs": serde_json::to_value(sums.logs())?,
            "left_out": failed,
        }))
    })
}

fn account(sums: &Accumulator) -> String {
    let (settings, logs) = (sums.settings(), sums.logs());
    let mut text = String::new();
    let width = logs.iter().map(|log| log.name.chars().count()).max().unwrap_or(0).max(3);
    // A String never fails to grow.
    let _ = writeln!(text, "{:<width$}  {:>10}  {:>10}  {:>10}", "log", "rows", "usable", "samples");
    for log in &logs {
        let _ = writeln!(text, "{:<width$}  {:>10}  {:>10}  {:>10}", log.name, log.rows, log.kept, log.samples);
    }
    for failed in sums.failed() {
        let _ = writeln!(text, "left out: {}: {}", failed.name, failed.reason);
    }
    let cutoff = settings.options.signal.cutoff.map_or("no filter".into(), |hz| format!("cut-off {hz:.2} Hz"));
    let count = match logs.len() {
        1 => "1 log".into(),
        count => format!("{count} logs"),
    };
    let columns = settings.columns.len();
    let _ = writeln!(text, "{}: {count}, {columns} columns, {cutoff}", settings.model.name);
    text
}

fn delay(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) => possible_delay(seconds),
        _ if text == "auto" => {
            Err("the search goes over the rows many times, and sums have no rows: let rist identify \
                                    --delay auto find it on some of the logs, and give it here"
                .into())
        }
        _ => Err("expected seconds".into()),
    }
}

fn weights(text: &str) -> Result<Weights, String> {
    match Weights::of_word(text) {
        Some(weights) if weights.losses().is_empty() => Ok(weights),
        Some(_) => {
            Err("these weights follow from the residual of each row, and sums have no rows: take joint or none, or \
                 identify these logs in one go"
                .into())
        }
        None => Err("expected joint or none".into()),
    }
}
