//! Collects samples of all records, evenly thinned to the number that a log check needs.
//!
//! One pass over the records keeps every m-th sample with its neighbours in time; m doubles whenever there are too many. Two
//! quantities are summed over all samples, before thinning: the path length of each joint, and the products that compare each
//! measured velocity with the derivative of each position.

use linear_model::regressor::Regressor;
use linear_model::states::States;
use logs::Error;

use crate::estimate::log_check::change::{Change, position_of};
use crate::signals::records::Records;

/// Least number of kept torques, summed over all joints (if the log has so many): a few thousand samples of an arm.
const MIN_TORQUE_ENTRIES: usize = 16_384;

/// Least number of kept samples for a robot with many joints (if the log has so many).
const MIN_KEPT_SAMPLES: usize = 512;

/// The lag of a velocity is not estimated if the rms velocity of the joint is below this share of the largest rms velocity of
/// all joints.
const SLOW_JOINT_SPEED_SHARE: f64 = 0.2;
/// A velocity column counts as the derivative of the position if their squared correlation exceeds this value.
const SAME_VELOCITY_CORRELATION: f64 = 0.9;
/// An acceleration column counts as the derivative of the velocity if their squared correlation exceeds this value.
const SAME_ACCELERATION_CORRELATION: f64 = 0.25;
/// Plausible range of the ratio (rms of an acceleration column / rms of the derivative of the velocity).
pub(crate) const LIKELY_SIZES: std::ops::Range<f64> = 0.5..2.0;

/// Number of correlated rows that count as one independent row: twice the autocorrelation time of filtered noise. This time is
/// 0.32 periods of the cut-off frequency, and a period has ten rows.
const CORRELATED_NOISE_ROWS: f64 = 6.4;

/// A motion is short if the number of periods (there and back) is below this value.
const FEW_PERIODS: f64 = 1.5;

/// The data of a log check, collected in one pass over the records.
#[derive(Clone, Debug, Default)]
pub(crate) struct Samples {
    /// The kept samples of all records, one after the other.
    pub kept: States,
    /// The sample directly before each kept sample, and the sample directly after it. `span`: time between these two samples,
    /// s.
    pub before: States,
    pub after: States,
    pub span: Vec<f64>,
    /// For each kept sample, the number of its log, from 0.
    pub log: Vec<usize>,
    /// Smallest and largest position of each coordinate, rad (m).
    pub range: Vec<(f64, f64)>,
    /// Path length of each coordinate, sum |delta q|, rad (m).
    pub path: Vec<f64>,
    /// Sums over all samples; slope_l: difference quotient of the position of joint l. `velocity[k]`: dq_k . dq_k;
    /// `slope[l]`: slope_l . slope_l; `together[k n + l]`: dq_k . slope_l.
    pub velocity: Vec<f64>,
    pub slope: Vec<f64>,
    pub together: Vec<f64>,
    /// For each coordinate, sums that compare velocity and acceleration with difference quotients of position and velocity.
    pub rates: Vec<RateSums>,
    /// Number of samples over which the sums are taken.
    pub count: usize,
}

/// Sums over all samples of one coordinate that compare velocity dq and acceleration ddq with difference quotients. slope,
/// bend: first and second difference quotient of the position.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RateSums {
    /// Sums of (slope - dq) bend, bend^2 and (slope - dq)^2. slope, bend: first and second difference quotient of the
    /// position.
    lag: f64,
    bend: f64,
    off: f64,
    /// Sums of ddq dq', ddq^2 and dq'^2 over the samples. ddq: acceleration; dq': difference quotient of the velocity.
    both: f64,
    acceleration: f64,
    slope: f64,
}

impl Samples {
    /// Collects the samples of the records in one pass. n: number of coordinates.
    ///
    /// Fails when a record cannot be read.
    pub(crate) fn of<R: Records + ?Sized>(records: &R, n: usize) -> Result<Samples, Error> {
        let mut all = Samples {
            range: vec![(f64::MAX, f64::MIN); n],
            path: vec![0.0; n],
            velocity: vec![0.0; n],
            slope: vec![0.0; n],
            together: vec![0.0; n * n],
            rates: vec![RateSums::default(); n],
            ..Samples::default()
        };
        for part in [&mut all.kept, &mut all.before, &mut all.after] {
            part.n = n;
        }
        let most = (MIN_TORQUE_ENTRIES / n.max(1)).max(MIN_KEPT_SAMPLES);
        let (mut every, mut count) = (1, 0);
        // A sample is used if it has a neighbour before and a neighbour after it. All used samples enter the sums, but only
        // every m-th used sample is kept.
        records.each(&mut |states| {
            for r in 1..states.len().saturating_sub(1) {
                all.sum(states, r);
                if count % every == 0 {
                    all.keep(states, r);
                }
                count += 1;
                // If too many samples are kept, every second one is dropped and the step doubles.
                if all.kept.len() == 2 * most {
                    all.halve();
                    every *= 2;
                }
            }
            all.kept.cutoff = states.cutoff;
        })?;
        Ok(all)
    }

    /// A copy of these samples with faults undone by `changes`.
    pub(crate) fn changed(&self, changes: &[Change], regressor: &dyn Regressor) -> Samples {
        let (n, rows) = (self.kept.n, self.every(1));
        let done = |part: &States| Change::all_done(changes, part, &rows, regressor);
        let [mut low, mut high] = [0, 1].map(|end| {
            let of = |range: &(f64, f64)| if end == 0 { range.0 } else { range.1 };
            self.range.iter().map(of).collect::<Vec<f64>>()
        });
        for ends in [&mut low, &mut high] {
            Change::move_positions(changes, ends, regressor);
        }
        let mut all = Samples {
            kept: done(&self.kept),
            before: done(&self.before),
            after: done(&self.after),
            span: self.span.clone(),
            log: self.log.clone(),
            velocity: vec![0.0; n],
            slope: vec![0.0; n],
            together: vec![0.0; n * n],
            rates: vec![RateSums::default(); n],
            path: vec![0.0; n],
            range: vec![(0.0, 0.0); n],
            ..Samples::default()
        };
        all.kept.cutoff = self.kept.cutoff;
        for r in rows {
            let three = [&all.before, &all.kept, &all.after].map(|part| Change::all_done(&[], part, &[r], regressor));
            all.sum(&States::joined(&three), 1);
        }
        all.range = low.into_iter().zip(high).map(|(a, b)| (a.min(b), a.max(b))).collect();
        // The path length of thinned samples is too short. So the path length is computed from the number of periods of the
        // unchanged samples.
        let periods = (0..n).map(|k| 2.0 * self.periods(position_of(changes, k)));
        all.path = periods.zip(&all.range).map(|(periods, (a, b))| periods * (b - a)).collect();
        all
    }

    fn sum(&mut self, states: &States, r: usize) {
        let n = self.kept.n;
        let span = states.t[r + 1] - states.t[r - 1];
        self.count += 1;
        for k in 0..n {
            let q = states.q[r * n + k];
            self.range[k] = (self.range[k].0.min(q), self.range[k].1.max(q));
            self.path[k] += (q - states.q[(r - 1) * n + k]).abs();
            let slope = (states.q[(r + 1) * n + k] - states.q[(r - 1) * n + k]) / span;
            self.slope[k] += slope * slope;
            self.velocity[k] += states.dq[r * n + k].powi(2);
            let at = |x: &[f64]| [x[(r - 1) * n + k], x[r * n + k], x[(r + 1) * n + k]];
            let (position, rate, acceleration) = (at(&states.q), at(&states.dq), states.ddq[r * n + k]);
            let bend = (position[0] - 2.0 * position[1] + position[2]) / (0.25 * span * span);
            let of_rate = (rate[2] - rate[0]) / span;
            let sums = &mut self.rates[k];
            sums.lag += (slope - rate[1]) * bend;
            sums.bend += bend * bend;
            sums.off += (slope - rate[1]).powi(2);
            sums.both += acceleration * of_rate;
            sums.acceleration += acceleration * acceleration;
            sums.slope += of_rate * of_rate;
            for (l, together) in self.together[k..].iter_mut().step_by(n).enumerate() {
                *together += states.dq[r * n + l] * slope;
            }
        }
    }

    fn keep(&mut self, states: &States, r: usize) {
        for (part, r) in [(&mut self.before, r - 1), (&mut self.kept, r), (&mut self.after, r + 1)] {
            let at = r * part.n..(r + 1) * part.n;
            part.t.push(states.t[r]);
            part.q.extend_from_slice(&states.q[at.clone()]);
            part.dq.extend_from_slice(&states.dq[at.clone()]);
            part.ddq.extend_from_slice(&states.ddq[at.clone()]);
            part.tau.extend_from_slice(&states.tau[at.clone()]);
            part.direction.extend_from_slice(&states.direction[at.clone()]);
            part.used.extend_from_slice(&states.used[at]);
        }
        self.span.push(states.t[r + 1] - states.t[r - 1]);
        self.log.push(states.log);
    }

    /// Drops every second kept sample.
    fn halve(&mut self) {
        for part in [&mut self.before, &mut self.kept, &mut self.after] {
            let n = part.n;
            for x in [&mut part.q, &mut part.dq, &mut part.ddq, &mut part.tau, &mut part.direction] {
                *x = x.chunks(n).step_by(2).flatten().copied().collect();
            }
            part.used = part.used.chunks(n).step_by(2).flatten().copied().collect();
            part.t = part.t.iter().step_by(2).copied().collect();
        }
        self.span = self.span.iter().step_by(2).copied().collect();
        self.log = self.log.iter().step_by(2).copied().collect();
    }

    /// The indices of every `step`-th kept sample.
    pub(crate) fn every(&self, step: usize) -> Vec<usize> {
        (0..self.kept.len()).step_by(step.max(1)).collect()
    }

    /// Number of periods (there and back) of joint k: path length divided by twice the range of positions.
    pub(crate) fn periods(&self, k: usize) -> f64 {
        let range = self.range[k].1 - self.range[k].0;
        if range > 0.0 { 0.5 * self.path[k] / range } else { 0.0 }
    }

    /// Whether the motion is short: the median number of periods of the moving joints is below `FEW_PERIODS`. Then other
    /// bodies, zeros or signs may explain the torques by chance.
    pub(crate) fn are_few(&self) -> bool {
        let mut periods: Vec<f64> =
            (0..self.kept.n).map(|k| self.periods(k)).filter(|periods| *periods > 0.0).collect();
        periods.sort_by(f64::total_cmp);
        periods.get(periods.len() / 2).is_some_and(|middle| *middle < FEW_PERIODS)
    }

    /// Lag of the velocity of joint k behind the derivative of its position, s, for example because of a low-pass or another
    /// clock. `None` if k hardly moves, or if the velocity is another signal.
    pub(crate) fn velocity_lag(&self, k: usize) -> Option<f64> {
        let fastest = self.velocity.iter().copied().fold(0.0, f64::max);
        let sums = &self.rates[k];
        let moves = self.velocity[k] > SLOW_JOINT_SPEED_SHARE * SLOW_JOINT_SPEED_SHARE * fastest && sums.bend > 0.0;
        (moves && self.alike(k, k) > SAME_VELOCITY_CORRELATION).then(|| sums.lag / sums.bend)
    }

    /// Standard deviation of the velocity lag of joint k, s. The difference between the velocity and the derivative of the
    /// position, without the part that the lag explains, is treated as filtered noise with correlated rows.
    pub(crate) fn velocity_lag_deviation(&self, k: usize) -> f64 {
        let sums = &self.rates[k];
        let left = (sums.off - sums.lag * sums.lag / sums.bend).max(0.0);
        let variance = CORRELATED_NOISE_ROWS * left / (self.count as f64 * sums.bend);
        if variance.is_finite() { variance.sqrt() } else { 0.0 }
    }

    /// Correlation of the acceleration of joint k with the derivative of its velocity, and the ratio of their rms values.
    /// `None` if one of the two is zero.
    pub(crate) fn acceleration(&self, k: usize) -> Option<(f64, f64)> {
        let sums = &self.rates[k];
        let both = sums.acceleration * sums.slope;
        (both > 0.0).then(|| (sums.both / both.sqrt(), (sums.acceleration / sums.slope).sqrt()))
    }

    /// Whether the acceleration column of joint k is not the derivative of its velocity but another signal.
    pub(crate) fn is_acceleration_wrong(&self, k: usize) -> bool {
        let sums = &self.rates[k];
        let both = sums.acceleration * sums.slope;
        let size = if sums.slope > 0.0 { (sums.acceleration / sums.slope).sqrt() } else { 1.0 };
        both > 0.0
            && (sums.both * sums.both.abs() < SAME_ACCELERATION_CORRELATION * both || !LIKELY_SIZES.contains(&size))
    }

    /// Squared correlation, with the sign of the correlation, of the velocity of joint k and the derivative of the position
    /// of joint l.
    pub(crate) fn alike(&self, k: usize, l: usize) -> f64 {
        let together = self.together[k * self.kept.n + l];
        let both = self.velocity[k] * self.slope[l];
        if both > 0.0 { together * together.abs() / both } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;

    #[test]
    fn a_long_record_is_thinned_and_summed_whole() {
        let states = Pendulum::new().states(100_000);
        let samples = Samples::of([states.clone()].as_slice(), 1).unwrap();
        assert!((MIN_TORQUE_ENTRIES..2 * MIN_TORQUE_ENTRIES).contains(&samples.kept.len()), "{}", samples.kept.len());
        let step = samples.kept.t[1] - samples.kept.t[0];
        // At most 32 768 of 100 000 samples are kept. So every fourth is kept, and the step is 0.04 s.
        assert!((step - 0.04).abs() < 1e-9, "{step}");
        assert!(samples.span.iter().all(|s| (s - 0.02).abs() < 1e-9));
        let path: f64 = states.q.windows(2).map(|w| (w[1] - w[0]).abs()).sum();
        assert!((samples.path[0] / path - 1.0).abs() < 1e-4);
        assert!(samples.alike(0, 0) > 0.999);
    }

    #[test]
    fn a_joint_there_and_back_has_one_period() {
        let mut states = Pendulum::new().states(629);
        for (q, t) in states.q.iter_mut().zip(&states.t) {
            *q = t.sin();
        }
        let samples = Samples::of([states].as_slice(), 1).unwrap();
        assert!((samples.periods(0) - 1.0).abs() < 0.01, "{}", samples.periods(0));
    }
}
