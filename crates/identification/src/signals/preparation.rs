//! From a log to the records of an identification: one for each part between gaps of its clock.

use logs::{Error, Log};

use crate::model::regressor::Regressor;
use crate::model::states::States;
use crate::signals::cutoff::FrequencyContent;
use crate::signals::signal_options::Signal;
use crate::signals::transmission::Transmission;

/// The steps that a log goes through before an estimator sees it.
#[derive(Clone, Debug, Default)]
pub struct Preparation {
    /// The transmission between the log and the joints.
    pub transmission: Transmission,
    /// How signals become states.
    pub signal: Signal,
}

/// The states of a log, checked against the regressor: one record for each part between gaps of its clock.
pub fn states(regressor: &dyn Regressor, log: &Log, preparation: &Preparation) -> Result<Vec<States>, Error> {
    let states = states_or_none(regressor, log, preparation)?;
    if states.is_empty() {
        let cutoff = preparation.signal.cutoff.map_or(String::new(), |hz| format!(" (cut-off {hz} Hz)"));
        let message = format!(
            "no sample is left of {} between the ends, the gaps and the window: the filter{cutoff} takes three periods of \
             its cut-off at each end",
            log.len()
        );
        return Err(Error::at(&log.name, 0, message));
    }
    Ok(states)
}

/// The same as `states`, but empty where nothing is left.
pub(crate) fn states_or_none(
    regressor: &dyn Regressor,
    log: &Log,
    preparation: &Preparation,
) -> Result<Vec<States>, Error> {
    if log.report.gaps == 0 {
        let states = states_of(regressor, log, preparation)?;
        return Ok(if states.is_empty() { Vec::new() } else { vec![states] });
    }
    let segments = log.segments();
    // One cut-off for all parts: that of the fastest.
    let mut preparation = preparation.clone();
    if preparation.signal.order > 0 && preparation.signal.cutoff.is_none() {
        let mut fastest: Option<FrequencyContent> = None;
        for part in &segments {
            let (content, period) = preparation.transmission.apply(part)?.content(&preparation.signal)?;
            fastest = Some(match fastest {
                None => content,
                Some(fastest) => fastest.faster(content, period),
            });
        }
        preparation.signal.cutoff = fastest.map(|f| f.cutoff);
    }
    let mut records = Vec::new();
    for part in &segments {
        let states = states_of(regressor, part, &preparation)?;
        if !states.is_empty() {
            records.push(states);
        }
    }
    Ok(records)
}

/// Larger than any signal of a robot in any unit; squares of larger numbers would overflow.
const ABSURD: f64 = 1e100;

/// The states of a log without gaps; none where nothing is left between the ends and the window.
fn states_of(regressor: &dyn Regressor, log: &Log, preparation: &Preparation) -> Result<States, Error> {
    let n = regressor.coordinates().len();
    if log.coordinates.len() != n {
        let message = format!("the log has {} joints, the robot has {n} coordinates", log.coordinates.len());
        return Err(Error::at(&log.name, 0, message));
    }
    let states = preparation.transmission.apply(log)?.states(&preparation.signal)?;
    let finite = [&states.q, &states.dq, &states.ddq, &states.tau].iter().all(|x| x.iter().all(|x| x.abs() < ABSURD));
    if !finite {
        return Err(Error::at(
            &log.name,
            0,
            "the signals leave the range of numbers; look for absurd values in the log",
        ));
    }
    Ok(states)
}
