//! What an observer sees without contact: the bands of the joints and the peaks, from logs that the estimate was fitted to.
//!
//! | constant of a joint | from |
//! |---|---|
//! | speed | a tenth of the RMS speed |
//! | noise | median absolute deviation of r at samples above this speed |
//! | low_speed | what the deviation of r beyond dry friction has more below this speed |
//! | dry | dry friction of the estimate |
//!
//! The median is not moved by a contact that the fitted logs contain by accident.

use nalgebra::DMatrix;
use online::{Band, Order};

use logs::LogSource;

use crate::error::Error;
use crate::replay::alarm_rate::Peaks;
use crate::replay::cycles::{Cycle, CycleModel};
use crate::replay::directions::{DIRECTIONS, directions};
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
    /// Share of the variance of the torques by the parameters that G holds.
    pub(crate) held: f64,
    pub(crate) peaks: Peaks,
}

/// Speed of a band, as a share of the RMS speed of the joint.
const LOW_SHARE_OF_SPEED: f64 = 0.1;
/// Friction changes its direction smoothly below this share of the RMS speed.
const SMOOTH_SHARE_OF_SPEED: f64 = 0.02;
/// Median absolute deviation of a unit normal number: 1 / 1.4826.
const NORMAL_MAD: f64 = 0.674_489_750_196_082;
/// With fewer samples at low speed, their deviation is unknown, and that at speed is added once more.
const LEAST_LOW_SAMPLES: usize = 50;
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
        cycles.slow = speeds.iter().map(|v| SMOOTH_SHARE_OF_SPEED * v).collect();
        let mut series = vec![Vec::new(); n];
        let (mut squares, mut count, mut before) = (vec![0.0; n], 0, vec![None; n]);
        let p = covariance.map_or(0, DMatrix::nrows);
        let mut products = vec![DMatrix::zeros(p, p); n];
        for log in logs {
            each_settled(cycles, log, order, gain, &mut |cycle, observers| {
                for (j, joint) in cycle.joints.iter().enumerate() {
                    let torque = observers.seen[j].torque;
                    series[j].push((joint.speed.abs(), torque.abs()));
                    squares[j] += before[j].map_or(0.0, |before: f64| (torque - before).powi(2));
                    before[j] = Some(torque);
                    count += usize::from(j == 0);
                }
            })?;
            before.fill(None);
            add_products(cycles, log, &mut products)?;
        }
        let dry = cycles.dry_friction();
        let bands: Vec<Band<f64>> = series
            .iter_mut()
            .zip(speeds.iter().zip(dry))
            .map(|(series, (speed, dry))| band(series, LOW_SHARE_OF_SPEED * speed, dry))
            .collect();
        let (factor, held) = match covariance {
            None => (Vec::new(), 0.0),
            Some(covariance) => {
                let weighted = products.iter().zip(&bands).map(|(products, band)| products / band.noise.powi(2));
                directions(covariance, &weighted.fold(DMatrix::zeros(p, p), |sum, products| sum + products))
            }
        };
        let of_count = |square: f64| (square / count.max(1) as f64).sqrt().max(f64::MIN_POSITIVE);
        let changes = squares.into_iter().map(of_count).collect();
        let mut noise = Noise { bands, changes, factor, held, peaks: Peaks::default() };
        let mut peaks = Peaks::default();
        for log in logs {
            each_settled(cycles, log, order, gain, &mut |cycle, observers| {
                let ratios = (0..n)
                    .map(|j| noise.ratio(j, &cycle.joints[j].row, cycle.joints[j].speed, observers.seen[j].torque));
                peaks.add(ratios.fold(0.0, |largest: f64, ratio| largest.max(ratio.abs())), cycle.period, hold);
            })?;
            peaks.end();
        }
        noise.peaks = peaks;
        Ok(noise)
    }

    /// The row y G of a joint: what a unit of each direction of the parameters' error adds to its torque, N m (N).
    pub(crate) fn shared(&self, row: &[f64]) -> [f64; DIRECTIONS] {
        let mut shared = [0.0; DIRECTIONS];
        for (y, factor) in row.iter().zip(&self.factor) {
            shared.iter_mut().zip(factor).for_each(|(sum, g)| *sum += y * g);
        }
        shared
    }

    /// The torque r of joint j in standard deviations.
    pub(crate) fn ratio(&self, j: usize, row: &[f64], speed: f64, torque: f64) -> f64 {
        self.bands[j].ratio(torque, speed, square(&self.shared(row)))
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

/// Number of cycles between those whose rows are added: neighbouring rows are alike.
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

/// The band of a joint from the pairs (speed, |r|).
fn band(series: &mut [(f64, f64)], speed: f64, dry: f64) -> Band<f64> {
    let mut fast: Vec<f64> = series.iter().filter(|(v, _)| *v > speed).map(|(_, r)| *r).collect();
    let noise = (median(&mut fast) / NORMAL_MAD).max(f64::MIN_POSITIVE);
    let unknown = Band { noise, low_speed: noise, dry, speed };
    let at_rest = Band { low_speed: 0.0, ..unknown };
    // Beyond dry friction, and undone by the share of the low-speed deviation that applies at the speed of the sample.
    let slow = series.iter().filter(|(v, _)| *v <= speed).map(|(v, r)| (r - at_rest.dry_at(*v)).max(0.0));
    let mut slow: Vec<f64> = slow.collect();
    if slow.len() < LEAST_LOW_SAMPLES {
        return unknown;
    }
    let excess = (median(&mut slow) / NORMAL_MAD).powi(2) - noise * noise;
    Band { low_speed: excess.max(0.0).sqrt(), ..unknown }
}

/// The median; zero for an empty list.
fn median(x: &mut [f64]) -> f64 {
    let middle = x.len() / 2;
    if x.is_empty() { 0.0 } else { *x.select_nth_unstable_by(middle, f64::total_cmp).1 }
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
                let speed = if k % 2 == 0 { 1.0 } else { 0.0 };
                let deviation = if k % 2 == 0 { 0.5 } else { 1.3 };
                // A contact in a tenth of the fast samples does not move the band by more than the median moves: 13 %.
                let contact = if k % 20 == 0 { 30.0 } else { 0.0 };
                let dry = if speed == 0.0 { 0.7 } else { 0.0 };
                (speed, (deviation * random.normal()).abs() + dry + contact)
            })
            .collect();
        let band = band(&mut series, 0.1, 0.7);
        assert!((band.noise / 0.5 - 1.0).abs() < 0.16, "{band:?}");
        assert!((band.low_speed / 1.2 - 1.0).abs() < 0.1, "{band:?}");
        assert_eq!(median(&mut []), 0.0);
    }
}
