//! `rist identify --method ls` and `essential`: identifies parameters from samples of logs.
//!
//! Steps: read the logs, check them against the description (log check), fit the parameters, predict logs that were not fitted,
//! judge the estimate (verdict), write the requested files. `ls` is weighted least squares with all parameters, `essential`
//! with the smallest set of parameters that has nearly the same residual.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use rist::fit::load::Load;
use rist::fit::samples::{Identification, identify_essential, identify_loaded};
use rist::fit::verdict::Verdict;
use rist::fit::verdict_of_logs::JudgedIdentification;
use rist::request::{BodiesFiles, IdentifyRequest, Method};
use rist::{ColumnNames, Inertial, LogSource, Model, Residuals, Validation};
use serde_json::{Value, json};

use super::arguments::Arguments;
use crate::artefact::{check_outputs, read_text, series_text, write_file};
use crate::doctor::findings;
use crate::failure::Failure;
use crate::flags::FlagValues;
use crate::report::page_of;
use crate::terminal::{at_work, note, print_result};
use crate::verdict::{self, refused};
use rist::output::check_given_once;

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (asked, given) = (&arguments.asked, &arguments.asked.given);
    let files: BodiesFiles = given.read()?;
    // Fails if a flag is given without another flag that it needs.
    needs(given, "date", "report")?;
    needs(given, "into", "write_mjcf")?;
    needs(given, "loaded_link", "loaded")?;
    let model = arguments.model.derive()?;
    let mut request: IdentifyRequest = given.read()?;
    // Simulators accept only physically possible bodies. So physically possible bodies are required if a file for a simulator
    // is written.
    let writes = files.write_urdf.is_some() || files.write_mjcf.is_some();
    request.consistent |= writes;
    check_paths(arguments, &files)?;
    if request.samples.arm.is_none() {
        rist::proposed_arm(&model.robot).iter().for_each(note);
    }
    let mut text;
    (request.samples, text) = request.samples.with_arm(&model.robot, arguments.logs.first().map(PathBuf::as_path))?;
    let columns = request.samples.options().columns;
    let mut opened = Opened { columns: &columns, before: String::new() };
    let logs = opened.logs(&model, &arguments.logs, &mut text)?;
    let loaded = opened.logs(&model, &files.samples.loaded, &mut text)?;
    let others = opened.logs(&model, &files.samples.validate, &mut text)?;
    // Only now are all files that belong to the logs known, for example the files of a recording. So the paths are checked
    // again.
    check_paths(arguments, &files)?;
    at_work("identifying");
    let mut found = match asked.method {
        Method::Essential => identify_essential(&model, &logs, &loaded, &request.samples)?,
        _ => identify_loaded(&model, &logs, &loaded, &request)?,
    };

    text.push_str(&chosen(&found));
    at_work("predicting what was not fitted");
    let JudgedIdentification { predictions, validation, verdict, is_withheld } =
        found.verdict_of_logs(&model, &others, files.anyway)?;
    text.push_str(&predictions_and_verdict(&predictions, &found, &verdict));
    let model = found.used(&model);
    let simulators = if is_withheld { Vec::new() } else { for_simulators(&files, model, arguments, &found)? };
    let estimate = &found.estimate;
    print_result(text, || as_json(&found, validation.as_ref(), &verdict))?;

    at_work("writing");
    for (out, text) in simulators {
        write_file(out, text)?;
    }
    if let Some(out) = &arguments.out {
        write_file(out, estimate.to_yaml()?)?;
    }
    if let Some(out) = &files.samples.report {
        let page = page_of(model, estimate, &logs, validation.as_ref(), &verdict, files.samples.date.as_deref())?;
        write_file(out, page)?;
    }
    if let Some(out) = &files.samples.series {
        let series = rist::fit::validation::predicted_torques(model, estimate, &logs)?;
        write_file(out, series_text(out, &series, model.regressor().coordinates())?)?;
    }
    refused(&verdict, is_withheld && writes)
}

/// Text of the predictions, the findings of the log check, and the verdict.
fn predictions_and_verdict(predictions: &[(String, Residuals)], found: &Identification, verdict: &Verdict) -> String {
    let mut text = String::new();
    for (log, validation) in predictions {
        let _ = write!(text, "\n{log}, not fitted:\n{validation}");
    }
    for finding in &found.log_check.findings {
        let _ = writeln!(text, "{finding}");
    }
    text + &format!("\n{verdict}")
}

/// The result of `rist identify` as JSON, for --json.
fn as_json(
    found: &Identification,
    validation: Option<&Validation>,
    verdict: &Verdict,
) -> Result<Value, serde_json::Error> {
    Ok(json!({
        "estimate": serde_json::to_value(&found.estimate)?,
        "delay_s": found.decided.delay.as_ref().map(|delay| delay.seconds),
        "load": found.load.as_ref().map(load_as_json),
        "validation": serde_json::to_value(validation)?,
        "findings": findings(&found.log_check.findings),
        "verdict": verdict::as_json(verdict),
    }))
}

/// Text of the chosen delay, the chosen friction terms, and the estimate.
fn chosen(found: &Identification) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    if let Some(delay) = &found.decided.delay {
        let (seconds, with, without) = (delay.seconds, delay.residual, delay.residual_without);
        let _ = writeln!(text, "delay {seconds:.4} s: residual {} {with:.4}, without it {without:.4}", delay.rows());
    }
    if let Some(selection) = &found.decided.friction {
        let _ = writeln!(text, "friction, by blocked cross-validation (* chosen):\n{selection}");
    }
    if let Some(terms) = &found.decided.joint_terms {
        let _ = writeln!(text, "{terms}");
    }
    let _ = write!(text, "{}", found.estimate);
    if let Some(load) = &found.load {
        let _ = write!(text, "{load}");
    }
    text
}

/// An identified load as JSON, with parameters by name.
fn load_as_json(load: &Load) -> Value {
    let one = |i: usize| json!({"value": load.parameters[i], "sigma": load.sigma[i], "determined": load.determined[i]});
    let parameters: serde_json::Map<_, _> =
        Inertial::BODY.iter().enumerate().map(|(i, inertial)| (inertial.letters().to_string(), one(i))).collect();
    let body = load.body().map(|body| {
        let [xx, xy, xz, yy, yz, zz] = body.inertia;
        let inertia = json!({"xx": xx, "xy": xy, "xz": xz, "yy": yy, "yz": yz, "zz": zz});
        json!({"mass": body.mass, "centre_of_mass": body.centre, "inertia": inertia})
    });
    json!({"link": load.link, "whole": load.is_whole, "parameters": parameters, "mass_interval": load.mass_interval(), "about_centre_of_mass": body})
}

/// The requested files for simulators, each with its text. Prints notes on values that a format cannot express.
fn for_simulators<'a>(
    files: &'a BodiesFiles,
    model: &Model,
    arguments: &Arguments,
    found: &Identification,
) -> Result<Vec<(&'a PathBuf, String)>, Failure> {
    let mut written = Vec::new();
    let Some(bodies) = &found.bodies else { return Ok(written) };
    if let Some(out) = &files.write_mjcf {
        // Without the option `into`, an MJCF description is itself the model that gets the bodies. From other formats, a new
        // MuJoCo model is made.
        let into = match &files.into {
            Some(file) => Some((file.display().to_string(), read_text(file)?)),
            None => {
                let (path, options) = (&arguments.model.model, arguments.model.options()?);
                let own = rist::own_mjcf(model, &rist::text_of(path)?, &options)?;
                own.map(|text| (path.display().to_string(), text))
            }
        };
        let into = into.as_ref().map(|(file, text)| (file.as_str(), text.as_str()));
        let mjcf = rist::write_mjcf(model, bodies, &found.estimate, into)?;
        mjcf.notes.iter().for_each(note);
        written.push((out, mjcf.text));
    }
    if let Some(out) = &files.write_urdf {
        let (path, options) = (&arguments.model.model, arguments.model.options()?);
        // The bodies are written into the text of the URDF, so the macros of a xacro must be expanded first.
        let text = rist::describe::description::without_macros(&read_text(path)?, path, &options)?;
        let urdf = rist::write_urdf(model, &text, bodies, &found.estimate)?;
        urdf.notes.iter().for_each(note);
        written.push((out, urdf.text));
    }
    Ok(written)
}

/// Opens logs and reports which column is which signal. The report is repeated only if it differs from the report on the previous
/// log.
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

/// Fails if the flag `name` is given without the flag `of`, which it needs.
fn needs(given: &FlagValues, name: &str, of: &str) -> Result<(), Failure> {
    let is_given = |wanted: &str| given.names().any(|name| name == wanted);
    match is_given(name) && !is_given(of) {
        true => Err(Failure::new(format_args!("[{name}] says something of [{of}], which is not asked for"))),
        false => Ok(()),
    }
}

/// All files that this command reads.
fn inputs<'a>(arguments: &'a Arguments, files: &'a BodiesFiles) -> Vec<&'a Path> {
    let logs = [&arguments.logs, &files.samples.validate, &files.samples.loaded].into_iter().flatten();
    let read = logs.chain([&arguments.model.model]).chain(&files.into).map(PathBuf::as_path);
    read.chain(arguments.asked.given.files()).collect()
}

/// Fails if an output is also an input, if two outputs are the same file, or if a log is given twice, for example as fitted and
/// as validation log.
fn check_paths(arguments: &Arguments, files: &BodiesFiles) -> Result<(), Failure> {
    let read = inputs(arguments, files);
    check_given_once(read.iter().copied())?;
    let samples = &files.samples;
    let outputs = [&arguments.out, &files.write_urdf, &files.write_mjcf, &samples.report, &samples.series];
    check_outputs(outputs.into_iter().flatten(), &read)
}
