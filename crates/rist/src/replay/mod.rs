//! Replays a log: computes the external torque of each joint (observer), the load, and the drift of friction, cycle by cycle,
//! in the same way as a controller could do it while the robot runs.
//!
//! The noise of the observer is measured in logs without contact. These are the logs to which the estimate was fitted, unless
//! the user gives other logs. The noise and the covariance of the estimate give the band of the external torque: the values
//! that occur without contact. The noise and the accepted rate of false alarms give the threshold of contact.

mod alarm_rate;
mod artefact;
mod cycles;
mod directions;
mod friction_in_c;
mod inputs;
mod load_noise;
mod monitor;
mod noise;
mod observers;
mod page;
mod run;
mod sampled;
mod start;
mod wrench;

use std::path::{Path, PathBuf};

use logs::LogSource;

use identification::estimate::artefact::Estimate;

use crate::describe::model::Model;
use crate::error::Error;
use crate::replay::start::Start;
use crate::request::ReplayRequest;

pub use artefact::{CarriedLoad, ContactInterval, EARLY_S, JointReplay, ONE_LOG, Replay, ReplayedCycle};
pub use directions::DIRECTIONS;
pub use monitor::monitor;
pub use sampled::SampledReplay;
pub use wrench::ContactWrench;

/// Replays a log: intervals of contact, loads, drift of friction, and the external torque of every cycle.
///
/// `reference`: logs without contact; if empty, the logs of the estimate. `file`: name of the estimate's file for messages.
///
/// Fails if the verdict of the estimate is no, unless the request says `anyway`; if a log cannot be read; and for an
/// estimate of experiments.
pub fn replay(
    model: &Model,
    (file, estimate): (&Path, &Estimate),
    log: &LogSource,
    reference: &[LogSource],
    request: &ReplayRequest,
) -> Result<Replay, Error> {
    let Start { mut cycles, noise, settings, link } = Start::new(model, (file, estimate), reference, request)?;
    cycles.take_all_samples();
    let settings = run::Settings { period: cycles.mean_period(log)?, ..settings };
    let mut run = run::Run::new(&cycles, noise, log.name(), settings);
    cycles.each(log, &mut |cycle| run.step(cycle))?;
    let mut replay = run.finish();
    for (joint, sigma) in replay.joints.iter_mut().zip(cycles.friction_sigma(estimate)) {
        joint.drift_sigma.iter_mut().zip(sigma).for_each(|(drift, sigma)| *drift = drift.hypot(sigma));
    }
    replay.load_on = link;
    replay.wrench_on.clone_from(&request.wrench_on);
    replay.reference = reference.iter().map(LogSource::name).collect();
    replay.alarms_per_hour = request.alarms;
    replay.has_covariance = !estimate.covariance.is_empty();
    Ok(replay)
}

/// The logs in which the noise of the observer is measured: `given`, or if empty the logs of the estimate. Fails if one of
/// these logs cannot be opened.
pub fn reference_logs(
    model: &Model,
    file: &Path,
    estimate: &Estimate,
    given: &[PathBuf],
) -> Result<Vec<LogSource>, Error> {
    let Some(options) = &estimate.options else { return Ok(Vec::new()) };
    if !given.is_empty() {
        return given.iter().map(|path| Ok(model.open_log(path, &options.columns)?.0)).collect();
    }
    let open = |name: &String| {
        let opened = model.open_log(Path::new(name), &options.columns);
        opened.map(|(log, _)| log).map_err(|e| {
            Error::new(format_args!(
                "{}: the noise of the observer is measured in the logs that the estimate was made from, and one is not there: \
                 {e}; give a log without contact as [reference]",
                file.display()
            ))
        })
    };
    estimate.logs.iter().map(open).collect()
}
