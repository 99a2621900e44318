//! Reads the logs of a fleet of robots, and makes sums of them. Each log is read once, and a few triangles (R of the QR
//! decompositions of its rows) replace the log. Sums are the added triangles of several logs. Sums can be merged, solved for
//! the parameters, and compared.
//!
//! The log check compares a log with the description before it is added.

use std::path::{Path, PathBuf};

use crate::replicate::Replicate;
use crate::settings::Settings;
use identification::estimate::log_check::finding::Fault;
use identification::estimate::options::Options;
use identification::signals::cutoff::MotionEnergy;
use identification::signals::records::{SourceRecords, add_motion};
use linear_model::friction::terms::{FrictionTerm, JointTerm, check_terms};
use logs::LogSource;
use numerics::interruption::Interruption;
use processor::in_order;

pub use crate::accumulator::Accumulator;
pub use crate::comparison::{Compared, Comparison, compare};

use rist::Error;
use rist::describe::model::Model;
use rist::fit::doctor::log_check_of;
use rist::fit::undetermined::with_undetermined;
use rist::request::{ModelOptions, Request};

use crate::request::{AccumulateRequest, SumsRequest};

/// Makes empty sums for a model and a request.
///
/// Fails if the options need the rows twice, or if a gain belongs to no coordinate.
pub fn accumulator(model: &Model, request: &SumsRequest) -> Result<Accumulator, Error> {
    request.check()?;
    accumulator_with(model, request.rows.options_of_sums()?, &request.gain)
}

fn accumulator_with(model: &Model, mut options: Options, gains: &[(String, f64)]) -> Result<Accumulator, Error> {
    check_terms(&options.friction, model.regressor().coordinates().len()).map_err(Error::new)?;
    let grows = |term: &&FrictionTerm| matches!(term, FrictionTerm::At(_, JointTerm::Load));
    if let Some(term) = options.friction.iter().find(grows)
        && options.friction_load.is_empty()
    {
        return Err(Error::new(format_args!(
            "[friction={term}] needs the torques that a first fit predicts, and sums have no rows: give friction_load in the \
             [options], from the estimate that rist identify writes"
        )));
    }
    let mut known = model.drive_gains();
    model.give_gains(&mut known, gains)?;
    if options.transmission.drive_gains.is_none() || !gains.is_empty() {
        options.transmission.drive_gains = known.into_iter().collect();
    }
    let (reference, description) = (model.reference.clone(), model.description.clone());
    let settings = with_undetermined(model, None, |open| {
        Settings::new(model.regressor(), reference, description, &options, open)
    })?;
    Ok(Accumulator::new(settings))
}

/// Adds a log to the sums.
///
/// Fails, and adds nothing, in four cases: the sums belong to another model; the log cannot be used; the sums already contain
/// the log; or the log check (`rist doctor`) finds that the log does not belong to the description. With `anyway`, the log
/// check is skipped.
pub fn update(model: &Model, sums: &mut Accumulator, log: &LogSource, anyway: bool) -> Result<(), Error> {
    check_sums(model, sums)?;
    Ok(sums.add(replicate(model, &sums.settings().options, log, anyway)?)?)
}

/// Fails if the sums were made with another model.
pub fn check_sums(model: &Model, sums: &Accumulator) -> Result<(), Error> {
    let (ours, theirs) = (model.description.as_ref(), sums.settings().description.as_ref());
    model.check_read(Path::new("the sums"), &sums.settings().model, &ModelOptions::differences(ours, theirs))
}

/// Reads logs on several threads and adds them up. The number of threads does not change the result.
///
/// Fails at the first log that cannot be used. With `skip_broken` in the request, such a log is left out, and the result names
/// it. The function then fails only if no log can be used.
pub fn accumulate(model: &Model, logs: &[PathBuf], request: &AccumulateRequest) -> Result<Accumulator, Error> {
    request.check()?;
    accumulate_like(model, logs, request, request.sums.rows.options_of_sums()?)
}

/// Reads logs and adds them up. `options` are used instead of the options in the request.
///
/// Fails like [`accumulate`].
pub fn accumulate_like(
    model: &Model,
    logs: &[PathBuf],
    request: &AccumulateRequest,
    mut options: Options,
) -> Result<Accumulator, Error> {
    // With several logs, the cut-off frequency is chosen from the motion in all of them. With one log, it is chosen when the log
    // is read.
    if logs.len() > 1 && options.signal.order > 0 && options.signal.cutoff.is_none() {
        options.signal.cutoff = common_cutoff(model, logs, &options);
    }
    let mut all = accumulator_with(model, options, &request.sums.gain)?;
    let options = all.settings().options.clone();
    // Logs are first merged in batches, because each merge with the sums iterates over all logs in the sums.
    let mut batch = Accumulator::new(all.settings().clone());
    let threads = request.threads.unwrap_or_else(processor::threads);
    let read = |_: usize, path: &PathBuf| {
        let (log, _) = model.open_log(path, &options.columns)?;
        replicate(model, &options, &log, request.anyway)
    };
    in_order(logs, threads, read, |i, found| {
        Interruption::check()?;
        let name = logs[i].display().to_string();
        match found.and_then(|replicate| Ok(batch.add(replicate)?)) {
            Ok(()) => {}
            Err(e) if request.skip_broken => batch.fail(name, e.to_string()),
            Err(e) => return Err(named(&name, &e)),
        }
        if batch.logs().len() >= LOGS_PER_BATCH {
            let settings = batch.settings().clone();
            all.merge(&std::mem::replace(&mut batch, Accumulator::new(settings)))?;
        }
        Ok(())
    })?;
    all.merge(&batch)?;
    match all.failed().first() {
        Some(failed) if all.replicates().is_empty() => {
            Err(Error::new(format_args!("no log can be used: {}: {}", failed.name, failed.reason)))
        }
        _ => Ok(all),
    }
}

/// Number of logs in a batch. Each batch is merged with the sums of the earlier logs.
const LOGS_PER_BATCH: usize = 64;

/// Adds the name of the log to the error `e`.
fn named(name: &str, e: &Error) -> Error {
    let text = e.to_string();
    let text = if text.starts_with(name) { text } else { format!("{name}: {text}") };
    Error::new(format_args!("{text} ([skip_broken=true] leaves such logs out, and says so)"))
}

/// The common cut-off frequency, from the motion in all logs that can be read. A log that cannot be read is skipped here, and
/// refused later.
fn common_cutoff(model: &Model, logs: &[PathBuf], options: &Options) -> Option<f64> {
    let (preparation, mut energy) = (options.preparation(), MotionEnergy::default());
    for path in logs {
        let mut with = energy.clone();
        let read = model.open_log(path, &options.columns).map(|(log, _)| add_motion(&log, &preparation, &mut with));
        if let Ok(Ok(())) = read {
            energy = with;
        }
    }
    Some(energy.content().cutoff).filter(|hz| *hz > 0.0)
}

/// The triangles (R of QR decompositions) of one log. Unless `anyway` is set, the log check first tests whether the log belongs
/// to the description; the function fails if it does not.
fn replicate(model: &Model, options: &Options, log: &LogSource, anyway: bool) -> Result<Replicate, Error> {
    let name = log.name();
    if log.effort_is().needs_gains() && options.transmission.drive_gains.is_none() {
        return Err(Error::new(format_args!(
            "{name}: it holds {}, and gains that are not known are found from all logs at once: give the gain \
             of every drive ([gain={}=11.5,..]), or identify these logs in one go",
            log.effort_is().words(),
            model.regressor().coordinates().first().map_or("q1", String::as_str)
        )));
    }
    let records = SourceRecords::new(model.regressor(), std::slice::from_ref(log), &options.preparation())?;
    if !anyway {
        let gains = options.transmission.drive_gains.as_deref();
        let mut found = log_check_of(model, std::slice::from_ref(log), &records, gains, options)?;
        // Short logs are accepted, because sums are often made of short logs.
        found.findings.retain(|f| f.fault.is_gross() && !matches!(f.fault, Fault::Short(_)));
        if let Some(finding) = found.findings.first() {
            return Err(Error::new(format_args!("{name}: {finding} ([:doctor] says more; [anyway=true] takes it in)")));
        }
    }
    let linear = options.linear_model(model.regressor());
    Ok(with_undetermined(model, None, |open| Replicate::of(&linear, log, &records, open))?)
}
