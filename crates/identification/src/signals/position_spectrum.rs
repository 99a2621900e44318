//! Computes the spectrum of the positions of one joint: the energy of its motion by frequency, and the noise of its encoder.
//!
//! A bin is one frequency of the discrete Fourier transform. The energy of the velocity is the square of velocity integrated
//! over time, rad^2/s (m^2/s). Frequencies without motion contain only the noise.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use logs::extremes;
use numerics::fft::RealToComplex;

/// The energy of the velocity by frequency, rad^2/s (m^2/s). The key is the bit pattern of the frequency in Hz. Bit patterns
/// have the order of the frequencies.
pub(crate) type Energy = BTreeMap<u64, f64>;

/// A frequency bin counts as motion if its squared amplitude exceeds the mean noise of a bin by this factor.
const MOTION_TO_NOISE_RATIO: f64 = 20.0;
/// The spectrum of the motion is used up to 1/5 of the sampling rate. At higher frequencies, differentiated noise would exceed
/// the motion.
const HIGHEST_MOTION_BIN_DIVISOR: usize = 5;
/// Frequencies above 1/4 of the sampling rate (upper half of the band) contain only noise.
const LOWEST_NOISE_BIN_DIVISOR: usize = 4;

/// A joint is at rest if its range of positions is below this value, rad (m). The positions then contain only noise.
pub(crate) const REST_RANGE: f64 = 1e-3;

/// A joint is also at rest if its range is below this many standard deviations of its position noise. A million samples of
/// noise have a range of only ten standard deviations.
pub(crate) const REST_RANGE_SIGMAS: f64 = 20.0;

/// The range of positions: highest minus lowest position, rad (m).
pub(crate) fn excursion(q: &[f64]) -> f64 {
    let (low, high) = extremes(q);
    high - low
}

/// The frequencies at which the joint moves (as bit patterns, Hz), each with the energy of the velocity at this frequency,
/// rad^2/s (m^2/s). `period`: time between samples, s.
pub(crate) fn energy_of(q: &[f64], period: f64, fft: &dyn RealToComplex<f64>) -> Vec<(u64, f64)> {
    let n = fft.len();
    // The line through both end points is subtracted. Then the signal has no jump where the transform continues it
    // periodically.
    let slope = (q[n - 1] - q[0]) / (n - 1) as f64;
    let mut x: Vec<f64> = (0..n).map(|i| q[i] - q[0] - slope * i as f64).collect();
    let mut spectrum = fft.make_output_vec();
    if fft.process(&mut x, &mut spectrum).is_err() {
        return Vec::new();
    }
    let squares: Vec<f64> = spectrum.iter().map(|c| c.norm_sqr()).collect();
    let noise = mean_square(&squares[n / LOWEST_NOISE_BIN_DIVISOR..]);
    let bins = squares.iter().enumerate().take(n / HIGHEST_MOTION_BIN_DIVISOR).skip(1);
    let moving = bins.filter(|(_, s)| **s > MOTION_TO_NOISE_RATIO * noise);
    let energy = |(k, square): (usize, &f64)| {
        let frequency = k as f64 / (n as f64 * period);
        (frequency.to_bits(), (TAU * frequency).powi(2) * square * period / n as f64)
    };
    moving.map(energy).collect()
}

/// The variance of the noise of a position, rad^2 (m^2), from the middle of the record.
///
/// The window function is flat at both ends [Harris 1978], so the ends of the block cause no leakage into the upper half of the
/// band.
pub(crate) fn noise_of(q: &[f64], fft: &dyn RealToComplex<f64>) -> f64 {
    let n = fft.len();
    let q = &q[(q.len() - n) / 2..][..n];
    let slope = (q[n - 1] - q[0]) / (n - 1) as f64;
    let window = |i: usize| 0.5 - 0.5 * (TAU * i as f64 / n as f64).cos();
    let mut x: Vec<f64> = (0..n).map(|i| window(i) * (q[i] - q[0] - slope * i as f64)).collect();
    let mut spectrum = fft.make_output_vec();
    if fft.process(&mut x, &mut spectrum).is_err() {
        return 0.0;
    }
    let squares: Vec<f64> = spectrum[n / LOWEST_NOISE_BIN_DIVISOR..].iter().map(|c| c.norm_sqr()).collect();
    // The sum of the squared window values is 3 n / 8.
    mean_square(&squares) / (0.375 * n as f64)
}

/// The mean square of the noise of a bin, computed from the median of the bins.
///
/// The squares of the bins of white noise have an exponential distribution, with mean = median / ln 2. Spectral lines hardly
/// change the median.
fn mean_square(squares: &[f64]) -> f64 {
    let mut squares = squares.to_vec();
    let middle = squares.len() / 2;
    if squares.is_empty() {
        return 0.0;
    }
    *squares.select_nth_unstable_by(middle, f64::total_cmp).1 / std::f64::consts::LN_2
}

/// The largest number up to n that has only the prime factors 2, 3 and 5; n if this number is below 95 % of n.
pub(crate) fn smooth_length(n: usize) -> usize {
    let smooth = |mut m: usize| {
        for d in [2, 3, 5] {
            while m > 0 && m.is_multiple_of(d) {
                m /= d;
            }
        }
        m == 1
    };
    (n - n / 20..=n).rev().find(|&m| smooth(m)).unwrap_or(n)
}

/// Energy of the acceleration, (rad/s^2)^2 s, from the energy of the velocity by frequency.
pub(crate) fn acceleration_energy<'a>(velocity: impl Iterator<Item = (&'a u64, &'a f64)>) -> f64 {
    velocity.map(|(bits, energy)| (TAU * f64::from_bits(*bits)).powi(2) * energy).sum()
}

/// Energy of the position, rad^2 s, from the energy of the velocity by frequency.
pub(crate) fn position_energy<'a>(velocity: impl Iterator<Item = (&'a u64, &'a f64)>) -> f64 {
    velocity.map(|(bits, energy)| energy / (TAU * f64::from_bits(*bits)).powi(2)).sum()
}

/// The noise factor (2 pi)^4 sigma^2 n h^2 / 5, rad^2 s^2. The noise factor times f^5 is the energy of the noise of n
/// accelerations up to the frequency f, Hz. `variance`: sigma^2 of a position, rad^2; `count`: n; `period`: sample time h, s.
pub(crate) fn acceleration_noise(variance: f64, count: usize, period: f64) -> f64 {
    TAU.powi(4) / 5.0 * variance * count as f64 * period * period
}

/// The frequency up to which the energy adds up to `sum`, Hz.
pub(crate) fn quantile(energy: &Energy, sum: f64) -> f64 {
    let mut below = 0.0;
    let reached = energy.iter().find(|(_, e)| {
        below += **e;
        below >= sum
    });
    reached.map_or(0.0, |(bits, _)| f64::from_bits(*bits))
}
