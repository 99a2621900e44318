//! Measures the noise of the observer without contact, in the logs to which the estimate was fitted: the constants of each
//! joint, and the peaks. r: external torque of a joint, which is only noise in these logs.
//!
//! | constant of a joint | from |
//! |---|---|
//! | speed | a tenth of the RMS speed |
//! | noise | median absolute deviation of r at samples above this speed |
//! | low_speed | noise added at the other samples; from the 95 % quantile of abs(r) beyond dry friction |
//! | dry | dry friction of the estimate |
//!
//! If a fitted log contains a short contact by accident, the median hardly changes.
//!
//! A sample is fast if the joint moves above a tenth of its RMS speed. Slowness: 1 at standstill, 0 at speed. The correlation
//! time of r tells how many independent values a mean contains. G is a factor of the covariance of the parameters, restricted
//! to few directions (`directions`). "Normal" refers to the normal distribution.

use nalgebra::DMatrix;
use online::{Band, NoiseScale, Order};

use logs::LogSource;

use crate::error::Error;
use crate::replay::alarm_rate::Peaks;
use crate::replay::cycles::{Cycle, CycleModel};
use crate::replay::directions::{DIRECTIONS, directions};
use crate::replay::load_noise::LoadNoise;
use crate::replay::observers::Observers;

/// The observer's torque without contact.
#[derive(Clone, Debug)]
pub(crate) struct Noise {
    /// The constants of each joint.
    pub(crate) bands: Vec<Band<f64>>,
    /// For each joint, the standard deviation of r's change from cycle to cycle, N m (N).
    pub(crate) changes: Vec<f64>,
    /// The factor G of the covariance, one row per parameter; no row without a covariance.
    pub(crate) factor: Vec<[f64; DIRECTIONS]>,
    pub(crate) peaks: Peaks,
    /// Correlation time of r, s. The mean of r over a time t has the variance of r, multiplied by the correlation time and
    /// divided by t.
    correlation_time: f64,
    /// The correlation time of each joint for the estimate of a load, s ([`LoadNoise::times`]).
    load_times: Vec<f64>,
}

/// Speed of a band, as a share of the RMS speed of the joint.
const LOW_SHARE_OF_SPEED: f64 = 0.1;
/// Friction changes its direction smoothly below this share of the RMS speed.
const SMOOTH_SHARE_OF_SPEED: f64 = 0.02;
/// Median absolute deviation of a standard normal number: 1 / 1.4826.
const NORMAL_MAD: f64 = 0.674_489_750_196_082;
/// If there are fewer samples at low speed than this number, the noise at low speed is unknown. It is then assumed that low
/// speed adds as much noise as there is at speed.
const LEAST_LOW_SAMPLES: usize = 50;
/// Memory of the scale of the noise, s: some hundred cycles.
pub(crate) const SCALE_MEMORY_S: f64 = 0.5;
/// Time at the start of a record in which the observer is not used, in time constants.
pub(crate) const SETTLING_TIME_CONSTANTS: f64 = 5.0;

impl Noise {
    /// Measures the noise in `logs`, which should contain no contact. `covariance`: of all parameters of the linear model; `None`
    /// if it is unknown. Sets the smooth speeds of `cycles`.
    pub(crate) fn measure(
        cycles: &mut CycleModel,
        logs: &[LogSource],
        covariance: Option<&DMatrix<f64>>,
        (order, gain): (Order<f64>, f64),
        hold: f64,
    ) -> Result<Noise, Error> {
        let n = cycles.n();
        let speeds = rms_speeds(cycles, logs)?;
        // The direction and the slowness of a cycle depend on these speeds, so the speeds are set before the logs are
        // processed. The noise is not known yet.
        cycles.slow = speeds.iter().map(|v| SMOOTH_SHARE_OF_SPEED * v).collect();
        let dry = cycles.linear.dry_friction(cycles.x());
        let unknown = |(speed, dry): (&f64, f64)| Band {
            noise: 0.0,
            low_speed: 0.0,
            dry,
            speed: (LOW_SHARE_OF_SPEED * speed).max(f64::MIN_POSITIVE),
        };
        cycles.bands = speeds.iter().zip(dry).map(unknown).collect();
        let mut series = vec![Vec::new(); n];
        let (mut squares, mut count, mut before) = (vec![0.0; n], 0, vec![None; n]);
        let p = covariance.map_or(0, DMatrix::nrows);
        let mut products = vec![DMatrix::zeros(p, p); n];
        for log in logs {
            each_settled(cycles, log, order, gain, &mut |cycle, observers| {
                for (j, seen) in observers.seen.iter().enumerate().take(cycle.joints.len()) {
                    let torque = seen.torque;
                    series[j].push((seen.slowness, torque.abs()));
                    // Squared change of r from cycle to cycle; the first cycle of a log has no previous value.
                    squares[j] += before[j].map_or(0.0, |before: f64| (torque - before).powi(2));
                    before[j] = Some(torque);
                    count += usize::from(j == 0);
                }
            })?;
            before.fill(None);
            add_products(cycles, log, &mut products)?;
        }
        let measured = series.iter_mut().zip(&cycles.bands);
        let bands: Vec<Band<f64>> = measured.map(|(series, unknown)| band(series, *unknown)).collect();
        let factor = match covariance {
            None => Vec::new(),
            Some(covariance) => {
                // M = sum_j (sum of y'y over the rows y of joint j) / noise_j^2, up to a factor that cancels in G.
                let weighted = products.iter().zip(&bands).map(|(products, band)| products / band.noise.powi(2));
                directions(covariance, &weighted.fold(DMatrix::zeros(p, p), |sum, products| sum + products))
            }
        };
        let of_count = |square: f64| (square / count.max(1) as f64).sqrt().max(f64::MIN_POSITIVE);
        let changes = squares.into_iter().map(of_count).collect();
        let (peaks, correlation_time, load_times) = (Peaks::default(), 0.0, Vec::new());
        let noise = Noise { bands, changes, factor, peaks, correlation_time, load_times };
        noise.with_peaks(cycles, logs, (order, gain), hold)
    }

    /// Adds the peaks and the correlation times, which need the bands. The arguments are those of [`Noise::measure`].
    fn with_peaks(
        mut self,
        cycles: &CycleModel,
        logs: &[LogSource],
        (order, gain): (Order<f64>, f64),
        hold: f64,
    ) -> Result<Noise, Error> {
        let noise = &self;
        let (mut peaks, mut means) = (Peaks::default(), BatchMeans::new(cycles.n(), BATCH_TIME_CONSTANTS / gain));
        let mut load = LoadNoise::new(cycles.n());
        for log in logs {
            let mut scales = noise.scales();
            each_settled(cycles, log, order, gain, &mut |cycle, observers| {
                let joints = cycle.joints.iter().zip(&observers.seen).zip(&mut scales).enumerate();
                let ratios = joints.map(|(j, ((joint, seen), scale))| {
                    let mut band = noise.bands[j];
                    band.noise *= scale.step(seen.torque, cycle.period);
                    band.ratio(seen.torque, seen.slowness, square(&noise.shared(&joint.row))).abs()
                });
                peaks.add(ratios.fold(0.0, f64::max), cycle.period, hold);
                // Torques at low speed have their own deviation.
                let seen = observers.seen.iter().zip(&noise.bands);
                means.add(cycle.period, seen.map(|(seen, band)| seen.torque / band.deviation(seen.slowness, 0.0)));
                load.add(cycle.period, &observers.seen, &noise.bands);
            })?;
            peaks.end();
            means.end();
            load.end();
        }
        (self.peaks, self.correlation_time) = (peaks, means.correlation_time());
        self.load_times = load.times(self.correlation_time);
        Ok(self)
    }

    /// The scales of the noise of all joints, at their start.
    pub(crate) fn scales(&self) -> Vec<NoiseScale<f64>> {
        self.changes.iter().map(|&change| NoiseScale::new(change, SCALE_MEMORY_S)).collect()
    }

    /// For cycles with this period, s: the variance of a mean of correlated errors, divided by the variance of a mean of
    /// independent errors. At least 1.
    pub(crate) fn correlation(&self, period: f64) -> f64 {
        (self.correlation_time / period).max(1.0)
    }

    /// sqrt(f) of each joint ([`crate::replay::load_noise`]), for cycles with this period, s. 1 if it is unknown.
    pub(crate) fn load_factors(&self, period: f64) -> Vec<f64> {
        self.load_times.iter().map(|&time| if time > 0.0 { (time / period).sqrt() } else { 1.0 }).collect()
    }

    /// The row y G of a joint: for each direction of the error of the parameters, the torque error that one unit in this
    /// direction causes, N m (N).
    pub(crate) fn shared(&self, row: &[f64]) -> [f64; DIRECTIONS] {
        let mut shared = [0.0; DIRECTIONS];
        for (y, factor) in row.iter().zip(&self.factor) {
            shared.iter_mut().zip(factor).for_each(|(sum, g)| *sum += y * g);
        }
        shared
    }
}

/// Sums for the correlation time of the observers' torques: the variance of the means of batches, over all joints.
struct BatchMeans {
    /// Length of a batch, s.
    length: f64,
    sums: Vec<f64>,
    time: f64,
    count: usize,
    /// Sum of the squares of all values, and their number.
    squares: (f64, usize),
    /// Sum of the squares of the means, and their number.
    of_means: (f64, usize),
}

/// Length of a batch in time constants of the observer: much longer than its memory.
const BATCH_TIME_CONSTANTS: f64 = 20.0;

impl BatchMeans {
    fn new(joints: usize, length: f64) -> BatchMeans {
        BatchMeans { length, sums: vec![0.0; joints], time: 0.0, count: 0, squares: (0.0, 0), of_means: (0.0, 0) }
    }

    fn add(&mut self, period: f64, values: impl Iterator<Item = f64>) {
        for (sum, value) in self.sums.iter_mut().zip(values) {
            *sum += value;
            self.squares.0 += value * value;
            self.squares.1 += 1;
        }
        (self.time, self.count) = (self.time + period, self.count + 1);
        if self.time >= self.length {
            let count = self.count as f64;
            self.of_means.0 += self.sums.iter().map(|sum| (sum / count).powi(2)).sum::<f64>();
            self.of_means.1 += self.sums.len();
            self.end();
        }
    }

    /// Drops the present batch, for example at the end of a record.
    fn end(&mut self) {
        self.sums.fill(0.0);
        (self.time, self.count) = (0.0, 0);
    }

    /// The correlation time t_1, s. It follows from: variance of the mean of a batch = (variance of the values) t_1 / (length
    /// of the batch). Zero without a batch.
    fn correlation_time(&self) -> f64 {
        let mean = |(sum, count): (f64, usize)| if count > 0 { sum / count as f64 } else { 0.0 };
        let whole = mean(self.squares);
        if whole > 0.0 { self.length * mean(self.of_means) / whole } else { 0.0 }
    }
}

/// The sum of squares.
pub(crate) fn square(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum()
}

/// Calls `take` with each cycle of a log after the observers have settled.
fn each_settled(
    cycles: &CycleModel,
    log: &LogSource,
    order: Order<f64>,
    gain: f64,
    take: &mut dyn FnMut(&Cycle, &Observers),
) -> Result<(), Error> {
    let mut observers = Observers::new(cycles.n(), order);
    let mut since = 0.0;
    cycles.each(log, &mut |cycle| {
        observers.step(cycle);
        since = if cycle.period > 0.0 { since + cycle.period } else { 0.0 };
        if since * gain > SETTLING_TIME_CONSTANTS {
            take(cycle, &observers);
        }
    })
}

fn rms_speeds(cycles: &CycleModel, logs: &[LogSource]) -> Result<Vec<f64>, Error> {
    let (mut squares, mut count) = (vec![0.0; cycles.n()], 0);
    for log in logs {
        cycles.each(log, &mut |cycle| {
            count += 1;
            squares.iter_mut().zip(cycle.joints).for_each(|(square, joint)| *square += joint.speed.powi(2));
        })?;
    }
    Ok(squares.iter().map(|square| (square / f64::from(count.max(1))).sqrt().max(f64::MIN_POSITIVE)).collect())
}

/// Only the row of every n-th cycle is added, with this n, because neighbouring rows are nearly equal.
const CYCLES_PER_PRODUCT: usize = 10;

/// Adds the products y'y of the rows of each joint.
fn add_products(cycles: &CycleModel, log: &LogSource, products: &mut [DMatrix<f64>]) -> Result<(), Error> {
    let mut count = 0;
    cycles.each(log, &mut |cycle| {
        count += 1;
        if count % CYCLES_PER_PRODUCT != 0 {
            return;
        }
        for (products, joint) in products.iter_mut().zip(cycle.joints).filter(|(products, _)| products.nrows() > 0) {
            for (r, a) in joint.row.iter().enumerate().filter(|(_, a)| **a != 0.0) {
                joint.row.iter().enumerate().for_each(|(c, b)| products[(r, c)] += a * b);
            }
        }
    })
}

/// The band of a joint from the pairs (slowness, |r|).
fn band(series: &mut [(f64, f64)], unknown: Band<f64>) -> Band<f64> {
    let is_fast = |(slowness, _): &&(f64, f64)| *slowness < FAST_BELOW;
    let mut fast: Vec<f64> = series.iter().filter(is_fast).map(|(_, r)| *r).collect();
    let noise = (median(&mut fast) / NORMAL_MAD).max(f64::MIN_POSITIVE);
    let slow = series.iter().filter(|pair| !is_fast(pair)).map(|(w, r)| (r - unknown.dry_at(*w)).max(0.0));
    let mut slow: Vec<f64> = slow.collect();
    if slow.len() < LEAST_LOW_SAMPLES {
        return Band { noise, low_speed: noise, ..unknown };
    }
    let excess = (quantile(&mut slow, LOW_SPEED_QUANTILE) / LOW_SPEED_DEVIATIONS).powi(2) - noise * noise;
    Band { noise, low_speed: excess.max(0.0).sqrt(), ..unknown }
}

/// A sample is fast if its slowness is below this.
const FAST_BELOW: f64 = 0.5;

/// At low speed, the error of friction has no normal distribution, because it is large at reversals. So its standard deviation
/// is computed from this quantile of its absolute value, as for a normal variable. A contact in a few samples hardly changes
/// this quantile.
const LOW_SPEED_QUANTILE: f64 = 0.95;
/// The 95 % quantile of the absolute value of a standard normal number.
const LOW_SPEED_DEVIATIONS: f64 = 1.96;

/// The median; zero for an empty list.
fn median(x: &mut [f64]) -> f64 {
    quantile(x, 0.5)
}

/// A quantile; zero for an empty list.
fn quantile(x: &mut [f64], share: f64) -> f64 {
    let place = (share * x.len() as f64) as usize;
    if x.is_empty() { 0.0 } else { *x.select_nth_unstable_by(place.min(x.len() - 1), f64::total_cmp).1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    #[test]
    fn the_band_is_that_of_the_noise() {
        let mut random = Random::new(1);
        let mut series: Vec<(f64, f64)> = (0..40_000)
            .map(|k| {
                let slowness = if k % 2 == 0 { 0.0 } else { 1.0 };
                let deviation = if k % 2 == 0 { 0.5 } else { 1.3 };
                // A contact in a tenth of the fast samples changes the median, and therefore the band, by at most 13 %.
                let contact = if k % 20 == 0 { 30.0 } else { 0.0 };
                let dry = 0.7 * slowness;
                (slowness, (deviation * random.normal()).abs() + dry + contact)
            })
            .collect();
        let band = band(&mut series, Band { noise: 0.0, low_speed: 0.0, dry: 0.7, speed: 0.1 });
        assert!((band.noise / 0.5 - 1.0).abs() < 0.16, "{band:?}");
        assert!((band.low_speed / 1.2 - 1.0).abs() < 0.1, "{band:?}");
        assert_eq!(median(&mut []), 0.0);
    }

    #[test]
    fn the_correlation_time_is_that_of_the_filter() {
        let (mut random, mut means, period) = (Random::new(2), BatchMeans::new(1, 0.4), 0.002);
        let (mut state, a) = (0.0, f64::exp(-50.0 * 0.002));
        for _ in 0..200_000 {
            state = a * state + random.normal();
            means.add(period, std::iter::once(state));
        }
        // The correlation time is (1 + a) / (1 - a) samples. At the ends of a batch of twenty time constants, a twentieth is
        // lost.
        let expected = period * (1.0 + a) / (1.0 - a);
        assert!((means.correlation_time() / expected - 0.95).abs() < 0.1, "{}", means.correlation_time());
    }
}
