//! `rist identify --method ls`: samples of logs -> parameters.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use identification::estimate::options::Options;
use identification::estimate::residuals::Residuals;
use identification::estimators::drive_gains::likelihood::Gain;
use linear_model::friction::terms::FrictionTerm;
use logs::{ColumnNames, LogSource};
use rist::load::Load;
use rist::request::harmonic_request::Delay;
use rist::samples::Identification;
use rist::verdict::{Trust, Verdict};
use rist::{IdentifyRequest, Model, Validation};
use robot::Inertial;
use serde_json::{Value, json};

use super::arguments::{Arguments, Friction, Method};
use crate::artefact::{check_outputs, gain, read_text, series_text};
use crate::doctor::findings;
use crate::failure::Failure;
use crate::report::page_of;
use crate::terminal::{at_work, note, print_result};
use crate::verdict::{self, refused};
use rist::output::{is_same, write_file};

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = arguments.model.derive()?;
    let options = options(arguments, &model)?;
    check_paths(arguments)?;
    let mut text = String::new();
    let mut opened = Opened { columns: &options.columns, before: String::new() };
    let logs = opened.logs(&model, &arguments.logs, &mut text)?;
    let loaded = opened.logs(&model, &arguments.loaded, &mut text)?;
    let others = opened.logs(&model, &arguments.validate, &mut text)?;
    let writes = arguments.write_urdf.is_some() || arguments.write_mjcf.is_some();
    let request = IdentifyRequest {
        gains: arguments.gain.iter().map(|text| expected_gain(text)).collect::<Result<_, _>>()?,
        find_delay: arguments.delay == Some(Delay::Auto),
        find_friction: arguments.friction.as_ref().is_some_and(|words| words.contains(&Friction::Auto)),
        essential: arguments.method == Method::Essential,
        consistent: arguments.consistent || writes,
        loaded: &loaded,
        loaded_link: arguments.loaded_link.clone(),
        options: options.clone(),
    };
    at_work("identifying");
    let mut found = rist::identify(&model, &logs, &request)?;

    text.push_str(&chosen(&found));
    at_work("predicting what was not fitted");
    let predictions = rist::validation::predictions(&model, &found.estimate, &others)?;
    let verdict = found.judge(predictions.iter().map(|(_, p)| p.total).reduce(f64::max));
    text.push_str(&judged(&predictions, &found, &verdict));
    if let Some(bodies) = found.bodies.as_mut().filter(|_| arguments.anyway) {
        bodies.refusal = None;
    }
    let is_withheld = verdict.trust == Trust::No && !arguments.anyway;
    let simulators = if is_withheld { Vec::new() } else { for_simulators(arguments, &model, &found)? };
    let (reference, estimate) = (model.reference.clone(), &found.estimate);
    let validation = (!predictions.is_empty())
        .then(|| Validation::of_logs(reference, &estimate.method, estimate.cutoff, model.regressor(), &predictions));
    print_result(text, || as_json(&found, validation.as_ref(), &verdict))?;

    at_work("writing");
    let read = inputs(arguments);
    for (out, text) in simulators {
        write_file(out, text, &read)?;
    }
    if let Some(out) = &arguments.out {
        write_file(out, estimate.to_yaml()?, &read)?;
    }
    if let Some(out) = &arguments.report {
        let page = page_of(&model, estimate, &logs, validation.as_ref(), &verdict, arguments.date.as_deref())?;
        write_file(out, page, &read)?;
    }
    if let Some(out) = &arguments.series {
        let series = rist::validation::predicted_torques(&model, estimate, &logs)?;
        write_file(out, series_text(out, &series, model.regressor().coordinates())?, &read)?;
    }
    refused(&verdict, is_withheld && writes)
}

/// What was predicted, what the logs have to do with the description, and the verdict.
fn judged(predictions: &[(String, Residuals)], found: &Identification, verdict: &Verdict) -> String {
    let mut text = String::new();
    for (log, validation) in predictions {
        let _ = write!(text, "\n{log}, not fitted:\n{validation}");
    }
    for finding in &found.passport.findings {
        let _ = writeln!(text, "{finding}");
    }
    text + &format!("\n{verdict}")
}

/// What --json prints.
fn as_json(
    found: &Identification,
    validation: Option<&Validation>,
    verdict: &Verdict,
) -> Result<Value, serde_json::Error> {
    Ok(json!({
        "estimate": serde_json::to_value(&found.estimate)?,
        "delay_s": found.delay.as_ref().map(|delay| delay.seconds),
        "load": found.load.as_ref().map(load_as_json),
        "validation": serde_json::to_value(validation)?,
        "findings": findings(&found.passport.findings),
        "verdict": verdict::as_json(verdict),
    }))
}

/// What was chosen, and the estimate.
fn chosen(found: &Identification) -> String {
    let mut text = String::new();
    // A String never fails to grow.
    if let Some(delay) = &found.delay {
        let (seconds, with, without) = (delay.seconds, delay.residual, delay.residual_without);
        let _ = writeln!(text, "delay {seconds:.4} s: residual away from reversals {with:.4}, without it {without:.4}");
    }
    if let Some(selection) = &found.friction {
        let _ = writeln!(text, "friction, by blocked cross-validation (* chosen):\n{selection}");
    }
    let _ = write!(text, "{}", found.estimate);
    if let Some(load) = &found.load {
        let _ = write!(text, "{load}");
    }
    text
}

/// The load as JSON: its parameters by their names.
fn load_as_json(load: &Load) -> Value {
    let one = |i: usize| json!({"value": load.parameters[i], "sigma": load.sigma[i], "determined": load.determined[i]});
    let parameters: serde_json::Map<_, _> =
        Inertial::BODY.iter().enumerate().map(|(i, inertial)| (inertial.letters().to_string(), one(i))).collect();
    json!({"link": load.link, "whole": load.is_whole, "parameters": parameters})
}

/// The texts for simulators that the flags ask for, with their files; prints what a format cannot hold.
fn for_simulators<'a>(
    arguments: &'a Arguments,
    model: &Model,
    found: &Identification,
) -> Result<Vec<(&'a PathBuf, String)>, Failure> {
    let mut written = Vec::new();
    let Some(bodies) = &found.bodies else { return Ok(written) };
    if let Some(out) = &arguments.write_mjcf {
        let into = match &arguments.into {
            Some(file) => Some((file.display().to_string(), read_text(file)?)),
            None => None,
        };
        let into = into.as_ref().map(|(file, text)| (file.as_str(), text.as_str()));
        let mjcf = rist::write_back::steps::write_mjcf(model, bodies, &found.estimate, into)?;
        mjcf.notes.iter().for_each(note);
        written.push((out, mjcf.text));
    }
    if let Some(out) = &arguments.write_urdf {
        let urdf = rist::write_urdf(model, &read_text(&arguments.model.model)?, bodies, &found.estimate)?;
        urdf.notes.iter().for_each(note);
        written.push((out, urdf.text));
    }
    Ok(written)
}

/// Opens logs, and prints what their columns were taken for where that changes.
struct Opened<'a> {
    columns: &'a ColumnNames,
    before: String,
}

impl Opened<'_> {
    fn logs(&mut self, model: &Model, paths: &[PathBuf], text: &mut String) -> Result<Vec<LogSource>, Failure> {
        let mut logs = Vec::new();
        for path in paths {
            at_work(format_args!("reading {}", path.display()));
            let (log, columns) = model.open_log(path, self.columns)?;
            let columns = columns.to_string();
            let _ = writeln!(text, "{}", path.display());
            if columns != self.before {
                text.push_str(&columns);
                self.before = columns;
            }
            let _ = writeln!(text, "{}", log.report());
            logs.push(log);
        }
        Ok(logs)
    }
}

/// `q1=2.393`, or `q5=11+-2`: near 11.
fn expected_gain(text: &str) -> Result<(String, Gain), Failure> {
    let (value, deviation) = text.split_once("+-").map_or((text, None), |(g, d)| (g, Some(d)));
    let (name, value) = gain(value).map_err(Failure::new)?;
    match deviation.map(str::parse::<f64>) {
        None => Ok((name, Gain::Known(value))),
        Some(Ok(deviation)) if deviation > 0.0 && deviation.is_finite() => Ok((name, Gain::Expected(value, deviation))),
        Some(_) => Err(Failure::new(format_args!("`{text}`: a positive deviation is expected behind +-"))),
    }
}

/// What is read.
fn inputs(arguments: &Arguments) -> Vec<&Path> {
    let logs = [&arguments.logs, &arguments.validate, &arguments.loaded].into_iter().flatten();
    logs.chain([&arguments.model.model])
        .chain(&arguments.options)
        .chain(&arguments.into)
        .map(PathBuf::as_path)
        .collect()
}

/// Refuses outputs over inputs or over each other, and a log in two roles.
fn check_paths(arguments: &Arguments) -> Result<(), Failure> {
    let read = inputs(arguments);
    for (i, log) in read.iter().enumerate() {
        if read[..i].iter().any(|other| is_same(log, other)) {
            return Err(Failure::new(format_args!("{}: given twice; a log counts once, in one role", log.display())));
        }
    }
    let outputs = [&arguments.out, &arguments.write_urdf, &arguments.write_mjcf, &arguments.report, &arguments.series];
    check_outputs(outputs.into_iter().flatten(), &read)
}

/// The options of the file, and the flags over them.
pub(super) fn options(arguments: &Arguments, model: &Model) -> Result<Options, Failure> {
    let mut options = match &arguments.options {
        Some(path) => Options::read(path)?,
        None => Options::default(),
    };
    options.model = model.robot.name.clone();
    let signal = &mut options.signal;
    signal.cutoff = arguments.cutoff.or(signal.cutoff);
    signal.order = arguments.order.unwrap_or(signal.order);
    signal.decimate = arguments.decimate.or(signal.decimate);
    if let Some(Delay::Seconds(delay)) = arguments.delay {
        signal.delay = delay;
    }
    options.weights = arguments.weights.unwrap_or(options.weights);
    if let Some(words) = &arguments.friction {
        if words.len() > 1 && words.iter().any(|w| matches!(w, Friction::Auto | Friction::None)) {
            return Err(Failure::new("--friction: auto and none stand alone"));
        }
        let term = |word: &Friction| match word {
            Friction::Term(term) => Some(*term),
            Friction::Auto | Friction::None => None,
        };
        if let Some(i) = (1..words.len()).find(|&i| words[..i].contains(&words[i])) {
            return Err(Failure::new(format_args!("--friction: word {} stands there twice", i + 1)));
        }
        if words.as_slice() != [Friction::Auto] {
            options.friction = words.iter().filter_map(term).collect::<Vec<FrictionTerm>>();
        }
    }
    Ok(options)
}
