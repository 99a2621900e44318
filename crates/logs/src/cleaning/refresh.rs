//! Determines the time between new values of a signal: in a log of 500 Hz, a signal of 125 Hz has each value in four rows.
//!
//! The rows between two changes of a group of signals are a run. If nearly all runs have the same length, this length is the
//! time between new values. Rest is a single long run. A coarse encoder gives runs of all lengths, or steps of one count; then
//! the signal is not slower than the log.

use std::fmt;

use serde::Serialize;

/// Time between new values of the signals of a log, s. It equals the period of the clock if every row is new. It is zero if it
/// could not be determined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Refresh {
    /// Time between new positions, velocities and accelerations, s.
    pub motion: f64,
    /// Time between new torques or currents, s.
    pub effort: f64,
}

/// Smallest number of runs for a decision.
const MIN_RUNS: usize = 20;

/// Smallest share of runs with the usual length. If runs end by chance, the share is at most a third.
const STEADY_SHARE: f64 = 0.8;

/// Smallest ratio of the median step of a series to its smallest step. With a smaller ratio, the steps are encoder counts.
const MIN_STEP_RATIO: f64 = 4.0;

/// Two times count as equal if their relative difference is below this.
const SAME_TIME: f64 = 0.1;

/// A signal is slower than the log if its time between new values exceeds this multiple of the log's period.
const MIN_SLOW_RATIO: f64 = 1.5;

impl Refresh {
    /// The times between new values of the signals `motion` and `effort` of a log. `period`: time between rows, s.
    pub(crate) fn of(motion: &[&[f64]], effort: &[&[f64]], period: f64) -> Refresh {
        Refresh { motion: between_changes(motion, period), effort: between_changes(effort, period) }
    }

    /// Combines these times with the times of the next block of the same log.
    pub(crate) fn append(&mut self, next: &Refresh) {
        let join = |a: f64, b: f64| match (a, b) {
            (0.0, x) | (x, 0.0) => x,
            (a, b) if (a / b - 1.0).abs() < SAME_TIME => a,
            (a, b) => a.min(b),
        };
        *self = Refresh { motion: join(self.motion, next.motion), effort: join(self.effort, next.effort) };
    }

    /// The time between new positions, s; `None` if every row has a new one. `period`: time between rows, s.
    pub fn seldom_motion(&self, period: f64) -> Option<f64> {
        Some(self.motion).filter(|time| *time > MIN_SLOW_RATIO * period)
    }

    /// The time between new efforts, s; `None` if every row has a new one. `period`: time between rows, s.
    pub fn seldom_effort(&self, period: f64) -> Option<f64> {
        Some(self.effort).filter(|time| *time > MIN_SLOW_RATIO * period)
    }

    /// The sentence of the report on slow signals; `None` if every row is new.
    pub(crate) fn sentence(&self, period: f64) -> Option<String> {
        let rate = |time: f64| format!("{:.4} times a second", Hertz(1.0 / time));
        match (self.seldom_motion(period), self.seldom_effort(period)) {
            (None, None) => None,
            (Some(motion), Some(effort)) if (motion / effort - 1.0).abs() < SAME_TIME => {
                Some(format!("new values come {}: that is the rate of this log", rate(motion)))
            }
            (Some(motion), None) => Some(format!("new positions come {}: that is their rate", rate(motion))),
            (None, Some(effort)) => Some(format!("new torques come {}: that is their rate", rate(effort))),
            (Some(motion), Some(effort)) => Some(format!(
                "new positions come {}, new torques {}: those are their rates",
                rate(motion),
                rate(effort)
            )),
        }
    }
}

/// A rate with four significant digits.
struct Hertz(f64);

impl fmt::Display for Hertz {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let decimals = (3 - self.0.log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{:.decimals$}", self.0);
        f.write_str(if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text })
    }
}

/// The time between changes of a group of series, s; zero if there are too few changes.
fn between_changes(group: &[&[f64]], period: f64) -> f64 {
    let rows = group.first().map_or(0, |x| x.len());
    let changes: Vec<usize> = (1..rows).filter(|&r| group.iter().any(|x| x[r] != x[r - 1])).collect();
    if changes.len() <= MIN_RUNS {
        return 0.0;
    }
    let runs: Vec<usize> = changes.windows(2).map(|w| w[1] - w[0]).collect();
    let mut sorted = runs.clone();
    let middle = sorted.len() / 2;
    let usual = *sorted.select_nth_unstable(middle).1;
    // If the signal has another clock than the log, the length of its runs alternates, for example between two and three rows.
    let near = if usual == 2 { 2..=3 } else { usual - (usual / 4).max(1).min(usual - 1)..=usual + (usual / 4).max(1) };
    let steady: Vec<usize> = runs.iter().copied().filter(|run| near.contains(run)).collect();
    if usual < 2 || (steady.len() as f64) < STEADY_SHARE * runs.len() as f64 || !is_finer_than_counts(group, &changes) {
        return period;
    }
    period * steady.iter().sum::<usize>() as f64 / steady.len() as f64
}

/// Whether some series of the group changes by more than single encoder counts.
fn is_finer_than_counts(group: &[&[f64]], changes: &[usize]) -> bool {
    group.iter().any(|x| {
        let mut steps: Vec<f64> = changes.iter().map(|&r| (x[r] - x[r - 1]).abs()).filter(|s| *s > 0.0).collect();
        let smallest = steps.iter().copied().fold(f64::INFINITY, f64::min);
        let middle = steps.len() / 2;
        steps.len() > MIN_RUNS && *steps.select_nth_unstable_by(middle, f64::total_cmp).1 >= MIN_STEP_RATIO * smallest
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pseudo-random numbers between -1 and 1.
    fn chance(i: usize, seed: f64) -> f64 {
        2.0 * ((12.9898 * i as f64 + seed).sin() * 43_758.545_3).rem_euclid(1.0) - 1.0
    }

    /// A signal that gets a new value every `held` rows.
    fn held(rows: usize, held: usize, seed: f64) -> Vec<f64> {
        (0..rows).map(|r| r - r % held).map(|r| (0.003 * r as f64).sin() + 1e-3 * chance(r, seed)).collect()
    }

    fn of(motion: &[f64], effort: &[f64]) -> Refresh {
        Refresh::of(&[motion], &[effort], 2e-3)
    }

    #[test]
    fn the_time_between_new_values_is_found() {
        let found = of(&held(4000, 4, 1.0), &held(4000, 25, 2.0));
        assert!((found.motion - 8e-3).abs() < 1e-9 && (found.effort - 50e-3).abs() < 1e-9, "{found:?}");
        let said = found.sentence(2e-3).unwrap();
        assert_eq!(said, "new positions come 125 times a second, new torques 20 times a second: those are their rates");
        let both = of(&held(4000, 4, 1.0), &held(4000, 4, 2.0)).sentence(2e-3).unwrap();
        assert_eq!(both, "new values come 125 times a second: that is the rate of this log");
        // During rest no value changes. The changes before and after the rest determine the time.
        let mut rested = held(4000, 4, 3.0);
        let at = rested[1999];
        rested[2000..3000].fill(at);
        assert!((of(&rested, &rested).motion - 8e-3).abs() < 1e-9);
    }

    #[test]
    fn what_repeats_by_chance_is_not_seldom() {
        let fresh = held(4000, 1, 4.0);
        let coarse: Vec<f64> = fresh.iter().map(|x| (x * 652.0).round() / 652.0).collect();
        let ramp: Vec<f64> = (0..4000).map(|r| f64::from(r / 8) * 1.5e-3).collect();
        let mut lost = fresh.clone();
        (1..4000).for_each(|r| {
            if chance(r, 5.0) > 0.5 {
                lost[r] = lost[r - 1]
            }
        });
        for x in [&fresh, &coarse, &ramp, &lost] {
            let found = of(x, &fresh);
            assert_eq!((found.seldom_motion(2e-3), found.sentence(2e-3)), (None, None), "{found:?}");
        }
        assert_eq!(of(&[0.5; 4000], &fresh[..0]), Refresh::default());
    }

    #[test]
    fn parts_add_up() {
        let (slow, new, rest) = (8e-3, 2e-3, 0.0);
        for (a, b, expected) in [(slow, slow, slow), (rest, slow, slow), (slow, rest, slow), (slow, new, new)] {
            let mut sum = Refresh { motion: a, effort: a };
            sum.append(&Refresh { motion: b, effort: b });
            assert_eq!(sum, Refresh { motion: expected, effort: expected });
        }
    }
}
