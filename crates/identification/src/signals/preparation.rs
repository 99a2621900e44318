//! Converts a log into the records of an identification: one record for each segment between gaps of the clock. A record is a
//! list of states: q, dq, ddq and tau at its samples. Frequency content: bandwidth of the motion and default cut-off
//! (`cutoff`).

use linear_model::friction::terms::FrictionTerm;
use linear_model::regressor::{Regressor, predict_load};
use linear_model::states::States;
use logs::{Error, Log, NoTorqueReason};

use crate::signals::cutoff::{FrequencyContent, MotionEnergy};
use crate::signals::joint_signals::add_motion;
use crate::signals::signal_options::Signal;
use crate::signals::transmission::Transmission;

/// The options for converting a log into states.
#[derive(Clone, Debug, Default)]
pub struct Preparation {
    /// The transmission between the log and the joints.
    pub transmission: Transmission,
    /// The options for filters, derivatives, clock and window.
    pub signal: Signal,
    /// Friction terms whose columns are computed from a lightly filtered velocity, and are then filtered like the torques. Terms
    /// that are linear in the motion are not needed here.
    pub friction: Vec<FrictionTerm>,
    /// Base parameters from which the load (torque without friction) is computed for load-dependent friction. Empty without such
    /// friction.
    pub load: Vec<f64>,
    /// The frequency content of all logs that are fitted together. `None`: not known.
    pub content: Option<FrequencyContent>,
}

impl Preparation {
    /// A copy that uses the frequency content `content` of the logs. If the options have no cut-off, the copy gets the default
    /// cut-off that follows from the content.
    pub(crate) fn with_content(mut self, content: FrequencyContent) -> Preparation {
        if self.signal.order > 0 {
            self.signal.cutoff.get_or_insert(content.cutoff);
        }
        self.content = Some(content);
        self
    }

    /// Adds the motion of a log, or of a block of a log, to `energy`. The motion is computed from the positions of the joints.
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

    /// A copy with the frequency content of all these logs together, so that all logs have the same default cut-off.
    ///
    /// Fails if a log does not fit the transmission.
    pub fn for_logs(&self, logs: &[Log]) -> Result<Preparation, Error> {
        let mut energy = MotionEnergy::default();
        for log in logs {
            self.add_motion(log, &mut energy)?;
            energy.end_record();
        }
        Ok(self.clone().with_content(energy.content()))
    }
}

/// The states of a log: one record for each segment between gaps of the clock.
///
/// Fails if the log does not fit the regressor or the options, or if no sample remains.
pub fn states(regressor: &dyn Regressor, log: &Log, preparation: &Preparation) -> Result<Vec<States>, Error> {
    let states = states_or_none(regressor, log.clone(), preparation)?;
    if states.is_empty() {
        let cutoff = preparation.signal.cutoff.map_or(String::new(), |hz| format!(" (cut-off {hz} Hz)"));
        let message = format!(
            "no sample of {} remains between the ends, the gaps and the window: the filter{cutoff} takes three periods of \
             its cut-off at each end",
            log.len()
        );
        return Err(Error::at(&log.name, 0, message));
    }
    Ok(states)
}

/// The states of a log, one record for each segment between gaps. If no sample remains, the result is an empty list, whereas
/// `states` fails.
pub(crate) fn states_or_none(
    regressor: &dyn Regressor,
    log: Log,
    preparation: &Preparation,
) -> Result<Vec<States>, Error> {
    if log.report.clock.gaps == 0 {
        let states = states_of(regressor, log, preparation)?;
        return Ok(if states.is_empty() { Vec::new() } else { vec![states] });
    }
    // All segments have the same cut-off.
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

/// Largest accepted value of a signal. No signal of a robot is larger in any unit, and squares of much larger numbers would
/// overflow.
const IMPOSSIBLE_SIGNAL: f64 = 1e100;

/// Largest angle of a joint, rad: a thousand turns. Cables limit a joint between links to a few turns, and the rotor before the
/// gear turns about a hundred times as far. For a wheel, whole turns can be subtracted from the angle, because torques depend
/// only on the angle within a turn. From 2^27 rad on, the generated sine is NaN.
const LARGEST_ANGLE_RAD: f64 = 1000.0 * std::f64::consts::TAU;

/// Fails if positions cannot be angles of a joint, such as the counts of an encoder.
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

/// Indices of the coordinates that have no drive and are moved from outside.
fn prescribed(log: &Log) -> Vec<usize> {
    let suspects = log.report.suspect.iter().enumerate();
    suspects.filter(|(_, suspect)| suspect.undriven == Some(NoTorqueReason::Prescribed)).map(|(k, _)| k).collect()
}

/// The states of a log without gaps. Empty if no sample remains between the ends and inside the window.
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
        [&states.q, &states.dq, &states.ddq, &states.tau].iter().all(|x| x.iter().all(|x| x.abs() < IMPOSSIBLE_SIGNAL));
    if !finite {
        return Err(Error::at(
            &name,
            0,
            "the signals exceed the range of floating-point numbers; look for absurd values in the log",
        ));
    }
    // The external force that moves a prescribed coordinate is unknown. So the motion of this coordinate is used, but its
    // torque row is not.
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

/// Sets the log number `number` in all records of a log.
pub(crate) fn of_log(number: usize, mut records: Vec<States>) -> Vec<States> {
    records.iter_mut().for_each(|states| states.log = number);
    records
}
