//! Tests whether a motion repeats another motion, by the distances between their states (q, dq).
//!
//! Each signal is divided by its standard deviation. Periods of one motion return to the same states; a different motion does
//! not.

use linear_model::states::States;
use logs::Error;

use crate::estimate::log_check::samples::Samples;
use crate::signals::records::Records;

/// The states (q, dq) that a robot visited in its logs, thinned.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VisitedStates {
    n: usize,
    /// n positions and n velocities of each state, in the order of time.
    states: Vec<f64>,
    /// For each state, the number of its log, from 0.
    logs: Vec<usize>,
}

/// Largest number of visited states that are kept.
const MOST_STATES: usize = 2000;
/// Largest number of states of a motion that are compared with the visited states.
const EXAMINED_STATES: usize = 300;
/// Number of blocks (tenths) of a record. Each block is compared with all other blocks.
const RECORD_BLOCKS: usize = 10;
/// A state is new if its distance from every visited state exceeds this value. Distance: rms over the moving signals, each
/// divided by its standard deviation.
const NEW_STATE_DISTANCE: f64 = 0.15;
/// A motion is new if more than this share of its states is new.
const NEW_STATES_SHARE: f64 = 0.5;

impl VisitedStates {
    pub(crate) fn of(samples: &Samples) -> VisitedStates {
        let States { n, q, dq, .. } = &samples.kept;
        let count = samples.kept.len();
        let every = count.div_ceil(MOST_STATES).max(1);
        let state = |r: usize| [&q[r * n..(r + 1) * n], &dq[r * n..(r + 1) * n]].concat();
        let states = (0..count).step_by(every).flat_map(state).collect();
        VisitedStates { n: *n, states, logs: samples.log.iter().step_by(every).copied().collect() }
    }

    /// Collects the visited states of the records of a robot with n coordinates.
    ///
    /// Fails when a record cannot be read.
    pub fn of_records<R: Records + ?Sized>(records: &R, n: usize) -> Result<VisitedStates, Error> {
        Ok(VisitedStates::of(&Samples::of(records, n)?))
    }

    /// Whether most states are far from all states of the other tenths of the record. Then a prediction of a left-out tenth
    /// tests a new motion.
    pub fn has_new_parts(&self) -> bool {
        let count = self.len();
        let part = |i: usize| i * RECORD_BLOCKS / count.max(1);
        self.is_new(self, |_| true, |i, j| part(i) != part(j))
    }

    /// Whether the motion of the log with the number `log` differs from the motions of all other logs; false if there is only
    /// one log.
    pub fn is_new_log(&self, log: usize) -> bool {
        let has_others = self.logs.iter().any(|other| *other != log);
        has_others && self.is_new(self, |i| self.logs[i] == log, |_, j| self.logs[j] != log)
    }

    /// Whether the motion of `self` differs from the motion `before`.
    pub fn is_other_than(&self, before: &VisitedStates) -> bool {
        before.is_new(self, |_| true, |_, _| true)
    }

    fn len(&self) -> usize {
        self.states.len() / (2 * self.n).max(1)
    }

    /// Whether most states of `other` are far from the states of `self`. `is_meant(i)`: whether state i of `other` is tested;
    /// `counts(i, j)`: whether this state is compared with state j of `self`. False if there are too few states.
    fn is_new(
        &self,
        other: &VisitedStates,
        is_meant: impl Fn(usize) -> bool,
        counts: impl Fn(usize, usize) -> bool,
    ) -> bool {
        let width = 2 * self.n;
        let meant: Vec<usize> = (0..other.len()).filter(|i| is_meant(*i)).collect();
        if self.len() < RECORD_BLOCKS || meant.len() < RECORD_BLOCKS || other.n != self.n {
            return false;
        }
        let scale = self.deviations();
        let moves = scale.iter().filter(|s| **s > 0.0).count().max(1) as f64;
        let distance = |a: &[f64], b: &[f64]| {
            let one = |c: usize| if scale[c] > 0.0 { ((a[c] - b[c]) / scale[c]).powi(2) } else { 0.0 };
            (0..width).map(one).sum::<f64>() / moves
        };
        let every = meant.len().div_ceil(EXAMINED_STATES);
        let tried = meant.iter().step_by(every);
        let nearest = |&i: &usize| {
            let a = &other.states[i * width..(i + 1) * width];
            let others = self.states.chunks_exact(width).enumerate().filter(|(j, _)| counts(i, *j));
            others.map(|(_, b)| distance(a, b)).fold(f64::INFINITY, f64::min)
        };
        let all = tried.clone().count();
        let new = tried.map(nearest).filter(|d| *d > NEW_STATE_DISTANCE * NEW_STATE_DISTANCE).count();
        new as f64 > NEW_STATES_SHARE * all as f64
    }

    /// Standard deviation of each signal: n positions, then n velocities.
    fn deviations(&self) -> Vec<f64> {
        let (width, count) = (2 * self.n, self.len() as f64);
        let of = |c: usize| {
            let series = || self.states.iter().skip(c).step_by(width);
            let mean = series().sum::<f64>() / count;
            (series().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt()
        };
        (0..width).map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(count: usize, q: impl Fn(f64) -> [f64; 2]) -> VisitedStates {
        let dt = 0.01;
        let state = |r: usize| {
            let (t, h) = (dt * r as f64, 1e-5);
            let (here, next) = (q(t), q(t + h));
            [here[0], here[1], (next[0] - here[0]) / h, (next[1] - here[1]) / h]
        };
        VisitedStates { n: 2, states: (0..count).flat_map(state).collect(), logs: vec![0; count] }
    }

    #[test]
    fn periods_are_one_motion_and_other_frequencies_are_another() {
        let one = |t: f64| [(2.0 * t).sin() + 0.3 * (4.0 * t).cos(), (6.0 * t).sin()];
        let periodic = motion(1500, one);
        assert!(!periodic.has_new_parts());
        let wandering = motion(1500, |t| [(0.5 * t + 0.07 * t * t).sin(), (0.3 * t + 0.05 * t * t).cos()]);
        assert!(wandering.has_new_parts());
        assert!(wandering.is_other_than(&periodic));
        let later = motion(400, |t| one(t + 0.7));
        assert!(!later.is_other_than(&periodic));

        // Joins several motions; each becomes one log of a fit.
        let together = |logs: &[&VisitedStates]| {
            let of = |(log, visited): (usize, &&VisitedStates)| vec![log; visited.len()];
            let states = logs.iter().flat_map(|visited| visited.states.clone()).collect();
            VisitedStates { n: 2, states, logs: logs.iter().enumerate().flat_map(of).collect() }
        };
        let all = together(&[&periodic, &wandering, &later]);
        assert_eq!([0, 1, 2].map(|log| all.is_new_log(log)), [false, true, false]);
        assert!(!together(&[&wandering]).is_new_log(0));
    }
}
