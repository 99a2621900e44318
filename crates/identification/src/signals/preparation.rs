//! From a log to the records of an identification: one for each part between gaps of its clock.

use linear_model::friction::terms::FrictionTerm;
use linear_model::regressor::{Regressor, predict_load};
use linear_model::states::States;
use logs::{Error, Log, Undriven};

use crate::signals::cutoff::{FrequencyContent, MotionEnergy};
use crate::signals::joint_signals::add_motion;
use crate::signals::signal_options::Signal;
use crate::signals::transmission::Transmission;

/// The steps that a log goes through before an estimator sees it.
#[derive(Clone, Debug, Default)]
pub struct Preparation {
    /// The transmission between the log and the joints.
    pub transmission: Transmission,
    /// How signals become states.
    pub signal: Signal,
    /// Friction terms whose columns are made before the filter; terms that are linear in the motion are not among them.
    pub friction: Vec<FrictionTerm>,
    /// Base parameters that predict the torques which friction grows with; empty without such friction.
    pub load: Vec<f64>,
    /// The frequency content of everything that is fitted together, where it is known.
    pub content: Option<FrequencyContent>,
}

impl Preparation {
    /// The same for logs with this content, which gives the cut-off where there is none.
    pub(crate) fn with_content(mut self, content: FrequencyContent) -> Preparation {
        if self.signal.order > 0 {
            self.signal.cutoff.get_or_insert(content.cutoff);
        }
        self.content = Some(content);
        self
    }

    /// Adds the motion of a log, or of a block of one.
    pub(crate) fn add_motion(&self, log: &Log, energy: &mut MotionEnergy) -> Result<(), Error> {
        if log.report.clock.gaps == 0 {
            return add_motion(log, self.transmission.positions(log)?, &self.signal, energy);
        }
        for part in log.segments() {
            add_motion(&part, self.transmission.positions(&part)?, &self.signal, energy)?;
            energy.end_record();
        }
        Ok(())
    }

    /// The same with the content of logs that are fitted together.
    ///
    /// Fails where a log does not fit the transmission.
    pub fn for_logs(&self, logs: &[Log]) -> Result<Preparation, Error> {
        let mut energy = MotionEnergy::default();
        for log in logs {
            self.add_motion(log, &mut energy)?;
            energy.end_record();
        }
        Ok(self.clone().with_content(energy.content()))
    }
}

/// The states of a log, checked against the regressor: one record for each part between gaps of its clock.
pub fn states(regressor: &dyn Regressor, log: &Log, preparation: &Preparation) -> Result<Vec<States>, Error> {
    let states = states_or_none(regressor, log.clone(), preparation)?;
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
    log: Log,
    preparation: &Preparation,
) -> Result<Vec<States>, Error> {
    if log.report.clock.gaps == 0 {
        let states = states_of(regressor, log, preparation)?;
        return Ok(if states.is_empty() { Vec::new() } else { vec![states] });
    }
    // One cut-off for all parts.
    let preparation = match preparation.content {
        Some(_) => preparation.clone(),
        None => preparation.for_logs(std::slice::from_ref(&log))?,
    };
    let mut records = Vec::new();
    for part in log.segments() {
        let states = states_of(regressor, part, &preparation)?;
        if !states.is_empty() {
            records.push(states);
        }
    }
    Ok(records)
}

/// Larger than any signal of a robot in any unit. The squares of far larger numbers would overflow.
const ABSURD_SIGNAL: f64 = 1e100;

/// A thousand turns, rad. Cables stop a joint between links after a few turns, and a rotor before its gear turns some
/// hundred times as far. A wheel that has gone farther can start anew without loss, because torques depend on its angle
/// within a turn only. From 2^27 rad on the generated sine would not be a number.
const LARGEST_ANGLE_RAD: f64 = 1000.0 * std::f64::consts::TAU;

/// Refuses positions that cannot be angles of a joint, such as the counts of an encoder.
fn check_angles(regressor: &dyn Regressor, log: &Log, q: &[Vec<f64>]) -> Result<(), Error> {
    for (k, q) in q.iter().enumerate().filter(|(k, _)| !regressor.is_prismatic(*k)) {
        if let Some((r, angle)) = q.iter().enumerate().find(|(_, q)| q.abs() > LARGEST_ANGLE_RAD) {
            let (row, name) = (log.rows.get(r).copied().unwrap_or(0), &log.coordinates[k]);
            let message = format!(
                "row {row}: {name} is at {angle:.4e} rad, more than a thousand turns, where the angle of a joint in rad is \
                 expected: these are probably counts of an encoder; divide the column by the counts of a radian of the \
                 joint, and where a joint does turn so far subtract whole turns"
            );
            return Err(Error::at(&log.name, 0, message));
        }
    }
    Ok(())
}

/// The coordinates that something else moves.
fn prescribed(log: &Log) -> Vec<usize> {
    let suspects = log.report.suspect.iter().enumerate();
    suspects.filter(|(_, suspect)| suspect.undriven == Some(Undriven::Prescribed)).map(|(k, _)| k).collect()
}

/// The states of a log without gaps; none where nothing is left between the ends and the window.
fn states_of(regressor: &dyn Regressor, log: Log, preparation: &Preparation) -> Result<States, Error> {
    let n = regressor.coordinates().len();
    if log.coordinates.len() != n {
        let message = format!("the log has {} joints, the robot has {n} coordinates", log.coordinates.len());
        return Err(Error::at(&log.name, 0, message));
    }
    let name = log.name.clone();
    let prescribed = prescribed(&log);
    let signals = preparation.transmission.apply(log)?;
    check_angles(regressor, &signals.log, &signals.q)?;
    let mut states = signals.states(&preparation.signal, &preparation.friction, preparation.content.as_ref())?;
    let finite =
        [&states.q, &states.dq, &states.ddq, &states.tau].iter().all(|x| x.iter().all(|x| x.abs() < ABSURD_SIGNAL));
    if !finite {
        return Err(Error::at(&name, 0, "the signals leave the range of numbers; look for absurd values in the log"));
    }
    // What moves a coordinate from outside is not known: its motion counts, and its row does not.
    states.used.chunks_exact_mut(n).for_each(|used| prescribed.iter().for_each(|&k| used[k] = false));
    if !preparation.load.is_empty() {
        let (given, expected) = (preparation.load.len(), regressor.parameters().len());
        if given != expected {
            let message = format!(
                "friction_load has {given} numbers, one per base parameter is expected, {expected}: leave it out, and the \
                 first fit gives it"
            );
            return Err(Error::new(message));
        }
        predict_load(regressor, &mut states, &preparation.load);
    }
    Ok(states)
}

/// Records, of the log of that number.
pub(crate) fn of_log(number: usize, mut records: Vec<States>) -> Vec<States> {
    records.iter_mut().for_each(|states| states.log = number);
    records
}
