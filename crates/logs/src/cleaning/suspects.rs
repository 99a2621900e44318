//! Finds signals that no robot can produce: jumps of positions, torques that were not measured, words read without their sign,
//! rows of a second source.
//!
//! A finding is only reported, except that jumps by a full turn are removed. The word type is the way in which a register
//! stores the sign of a number
//! (`raw_words`). Rows of a second source come from another publisher on the same topic (`publishers`).

use std::fmt;

use serde::Serialize;

use crate::cleaning::raw_words::RawWord;
use crate::cleaning::turns::{extremes, may_be_wrapped, unwrap_angle};
use crate::cleaning::undriven::NoTorqueReason;

/// Suspicious findings in the signals of one coordinate.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Suspect {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Number of jumps of the position, without jumps by a full turn.
    pub jumps: usize,
    /// The reason why the coordinate has no torque; `None` if it has a torque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub undriven: Option<NoTorqueReason>,
    /// The value of the torque or current if it is equal in all rows; otherwise `None`.
    pub constant: Option<f64>,
    /// Share of the rows in which the torque is at its largest or smallest value; `None` if the share is not significant.
    pub saturated: Option<f64>,
    /// The word type of the torques if they were read without their sign; otherwise `None`.
    pub raw_effort: Option<RawWord>,
    /// The word type of the velocities if they were read without their sign; otherwise `None`.
    pub raw_velocity: Option<RawWord>,
    /// Number of rows from a second source.
    pub foreign_rows: usize,
    /// Whether the torques in the rows of the second source are all zero.
    pub foreign_are_zero: bool,
    /// Smallest and largest position in the log, rad (m).
    #[serde(skip)]
    pub(crate) logged: Option<(f64, f64)>,
}

impl Suspect {
    /// Examines the samples of one coordinate. Removes jumps by a full turn from its position, and also returns their number.
    pub(crate) fn of(
        coordinate: &str,
        t: &[f64],
        q: &mut [f64],
        velocity: Option<&[f64]>,
        effort: &[f64],
    ) -> (Suspect, usize) {
        let logged = Some(extremes(q)).filter(|_| !q.is_empty());
        let wrapped = unwrap_angle(q);
        // Adding zero converts -0 to 0.
        let constant = effort.first().filter(|first| effort.iter().all(|x| x == *first)).map(|x| x + 0.0);
        let suspect = Suspect {
            coordinate: coordinate.into(),
            jumps: jumps(t, q),
            constant,
            saturated: saturated(effort),
            raw_effort: RawWord::of(effort),
            raw_velocity: velocity.and_then(RawWord::of),
            logged,
            ..Suspect::default()
        };
        (suspect, wrapped)
    }

    /// Removes the findings on the torque if the coordinate has no torque.
    pub(crate) fn undriven(self, undriven: Option<NoTorqueReason>) -> Suspect {
        match undriven {
            None => self,
            Some(_) => Suspect { undriven, constant: None, saturated: None, raw_effort: None, ..self },
        }
    }

    /// Whether the range of the positions is so small that they may have been logged within one turn.
    pub(crate) fn may_be_wrapped(&self) -> bool {
        self.logged.is_some_and(may_be_wrapped)
    }

    /// Adds the findings of a later block of the same log.
    pub fn append(&mut self, next: &Suspect) {
        self.jumps += next.jumps;
        self.constant = self.constant.filter(|x| next.constant == Some(*x));
        self.saturated = match (self.saturated, next.saturated) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
        self.raw_effort = self.raw_effort.or(next.raw_effort);
        self.raw_velocity = self.raw_velocity.or(next.raw_velocity);
        self.foreign_are_zero = match (self.foreign_rows, next.foreign_rows) {
            (0, _) => next.foreign_are_zero,
            (_, 0) => self.foreign_are_zero,
            _ => self.foreign_are_zero && next.foreign_are_zero,
        };
        self.foreign_rows += next.foreign_rows;
        self.logged = match (self.logged, next.logged) {
            (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
            (a, b) => a.or(b),
        };
    }
}

impl fmt::Display for Suspect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = &self.coordinate;
        if self.jumps > 0 {
            let jumps = self.jumps;
            let what = if jumps == 1 { "jump" } else { "jumps" };
            writeln!(f, "{name}: {jumps} {what} of the position: spikes, or poses without the way between")?;
        }
        match self.undriven {
            Some(NoTorqueReason::Prescribed) => {
                writeln!(f, "{name}: something else moves it: its positions count, and it gives no rows of torque")?;
            }
            Some(NoTorqueReason::Free) => writeln!(f, "{name}: nothing drives it: its torque is taken to be zero")?,
            None => {}
        }
        if let Some(x) = self.constant {
            writeln!(f, "{name}: its torque is {x} in every row: is it measured?")?;
        }
        if let Some(share) = self.saturated {
            writeln!(f, "{name}: its torque stands at its limits in {:.0} % of the rows: saturated?", 100.0 * share)?;
        }
        for (word, what) in [(self.raw_effort, "torque"), (self.raw_velocity, "velocity")] {
            if let Some(word) = word {
                writeln!(f, "{name}: its {what} is a word read without its sign: {word}")?;
            }
        }
        Ok(())
    }
}

/// Smallest ratio of the speed of a jump to a high usual speed: 99 % of the steps are at most as fast as this usual speed.
const JUMP_SPEED_RATIO: f64 = 20.0;
/// Smallest speed of a jump, rad/s.
const SMALLEST_JUMP_SPEED_RAD_S: f64 = 1.0;
/// Smallest number of steps for which jumps are counted. At most 1 % of the steps can be counted as jumps.
const MIN_STEPS_FOR_JUMPS: usize = 100;

/// The number of jumps in a position: spikes, or poses that were logged without the motion between them.
fn jumps(t: &[f64], q: &[f64]) -> usize {
    let rate = |i: usize| (q[i + 1] - q[i]).abs() / (t[i + 1] - t[i]);
    let mut rates: Vec<f64> = (0..t.len().saturating_sub(1)).map(rate).collect();
    if rates.len() < MIN_STEPS_FOR_JUMPS {
        return 0;
    }
    let fastest = rates.iter().copied().fold(0.0, f64::max);
    // In most logs, more than 1 % of the steps are nearly as fast as the fastest. Then there are no jumps, and sorting is not
    // needed.
    if rates.iter().filter(|rate| **rate > fastest / JUMP_SPEED_RATIO).count() > rates.len() / 100 {
        return 0;
    }
    // In a log of poses at rest, nearly every step with a motion is a jump, so all of the fastest 1 % of the steps may be jumps.
    let at = rates.len() - 1 - rates.len() / 100;
    let usual = *rates.select_nth_unstable_by(at, f64::total_cmp).1;
    let limit = (JUMP_SPEED_RATIO * usual).max(SMALLEST_JUMP_SPEED_RAD_S);
    rates.iter().filter(|rate| **rate > limit).count()
}

/// Share of the samples in which a torque has its largest or smallest value. `None` if the share is not significant.
fn saturated(effort: &[f64]) -> Option<f64> {
    let (low, high) = extremes(effort);
    let at = |value: f64| effort.iter().filter(|x| **x == value).count();
    // A quantised torque repeats each value, and most often the values at its turning points. These are not counted.
    let above = effort.iter().copied().filter(|x| *x > low).fold(f64::INFINITY, f64::min);
    let below = effort.iter().copied().filter(|x| *x < high).fold(f64::NEG_INFINITY, f64::max);
    let held = |bound: f64, next: f64| at(bound).saturating_sub(TURNING_POINT_RATIO * at(next));
    let share = (held(low, above) + held(high, below)) as f64 / effort.len() as f64;
    (low < high && share > SATURATED_SAMPLES_SHARE).then_some(share)
}

/// At a turning point of a quantised signal: largest ratio of the number of samples at the last value to the number at the
/// value before. A parabola that ends halfway between two values has the ratio 1 / (sqrt 2 - 1) = 2.4.
const TURNING_POINT_RATIO: usize = 3;

/// Smallest share of samples at the limits that is significant.
const SATURATED_SAMPLES_SHARE: f64 = 0.01;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jumps_are_counted_and_motions_are_not() {
        let t: Vec<f64> = (0..2000).map(|i| 0.001 * f64::from(i)).collect();
        let mut q: Vec<f64> = t.iter().map(|t| (9.0 * t).sin()).collect();
        assert_eq!(jumps(&t, &q), 0);
        q[700] += 0.5;
        assert_eq!(jumps(&t, &q), 2);
    }

    #[test]
    fn a_torque_at_its_limit() {
        let torque: Vec<f64> = (0..1000).map(|i| (0.02 * f64::from(i)).sin()).collect();
        assert_eq!(saturated(&torque), None);
        let clipped: Vec<f64> = torque.iter().map(|x| x.clamp(-0.8, 0.8)).collect();
        // A sine exceeds 0.8 in magnitude in 2/pi acos 0.8 = 41 % of the samples.
        assert!((saturated(&clipped).unwrap() - 0.41).abs() < 0.02);
        assert_eq!(saturated(&[0.0; 50]), None);
        // Quantised values repeat, most often at the extremes, and are accepted. Clipped values are still found.
        for step in [0.3, 0.11, 0.05] {
            let coarse = |x: &f64| (x / step).round() * step;
            assert_eq!(saturated(&torque.iter().map(coarse).collect::<Vec<f64>>()), None, "{step}");
            assert!(saturated(&clipped.iter().map(|x| coarse(&x.clamp(-0.5, 0.5))).collect::<Vec<f64>>()).is_some());
        }
    }
}
