//! How fast the motion is, and the cut-off that follows from it.
//!
//! The rule is f_c = 20 f_95, but f_c is at most a fifth of the sampling rate. Below f_95 lies 95 % of the energy of a
//! joint's velocity; the largest f_95 of all joints counts. The factor is twenty for two reasons. The torques hold
//! harmonics of the motion (Coulomb friction, products of velocities) that the model explains, and the fourth-order
//! low-pass distorts the signals well below its cut-off.
//!
//! Where the noise of the positions matters, the cut-off is lower, but at least 5 f_95 of all joints together:
//!
//! (2 pi)^4 N_j h^2 f_c^5 / 5 = 1e-4 A_j.
//!
//! At this cut-off the noise of joint j, differentiated twice, is a hundredth of its acceleration. Such noise makes
//! inertias smaller by the square of that.
//!
//! The energy is summed over all records that are fitted together. So they get one cut-off, and a short record, or a
//! joint that one record holds still, has no more weight than its share:
//!
//! E_j(f) = sum over records of (2 pi f)^2 |X_j(f)|^2 h / n,   |X_j(f)|^2 >= 20 N_j,   A_j = sum over f of (2 pi f)^2 E_j(f)
//!
//! X_j is the transform of n positions, h s apart. N_j is the mean of |X_j|^2 in the upper half of the band, where no
//! robot moves: n times the variance of the noise of a position. White noise reaches 20 times its mean in two bins of a
//! billion. Joints with less than a hundredth of the largest energy of a joint do not count, because their motion only
//! follows the others or is noise of another colour.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::f64::consts::TAU;

use numerics::fft::RealToComplex;
use numerics::in_order::in_order;

/// The frequency content of a motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrequencyContent {
    /// Frequency below which 95 % of the energy of a joint's velocity lies, Hz, one per joint; 0 for a joint that does
    /// not count.
    pub f95: Vec<f64>,
    /// Cut-off by the rule, Hz.
    pub cutoff: f64,
}

/// Ratio of the cut-off to the highest f95 of the joints.
const CUTOFF_FREQUENCY_RATIO: f64 = 20.0;
/// Share of a joint's energy that lies below its f95.
const MOTION_ENERGY_SHARE: f64 = 0.95;

/// A bin counts as motion from this multiple of the noise of a bin on.
const MOTION_TO_NOISE_RATIO: f64 = 20.0;

/// Share of the largest energy from which on a joint counts. It is a tenth of the speed.
const COUNTED_ENERGY_SHARE: f64 = 1e-2;

/// Energy of the noise at the cut-off, as a share of that of the acceleration.
const NOISE_ENERGY_SHARE: f64 = 1e-4;

/// Noise never lowers the cut-off below this multiple of the f95 of all joints together. At a multiple of 3 the filter
/// would cut the motion itself.
const MIN_CUTOFF_FREQUENCY_RATIO: f64 = 5.0;

/// Samples that are transformed at once. It is a power of two, about a minute at 1 kHz.
const SAMPLES_PER_TRANSFORM: usize = 1 << 16;

/// Samples of a piece from which its noise is estimated.
const SAMPLES_PER_NOISE_ESTIMATE: usize = 1 << 12;

/// Fewer samples have no spectrum to speak of.
const MIN_SPECTRUM_SAMPLES: usize = 8;

/// The energy of velocity, rad^2/s (m^2/s), by frequency. The key is the bits of the frequency in Hz, which sort like
/// the numbers.
type Energy = BTreeMap<u64, f64>;

/// Motion of one joint, and noise of the records in which it moves.
#[derive(Clone, Debug, Default)]
struct JointEnergy {
    motion: Energy,
    /// Noise of the acceleration up to a frequency f is this times f^5, rad^2/s^3.
    noise: f64,
}

/// The energy of the joints' velocities by frequency, of as many records as are pushed.
#[derive(Clone, Debug, Default)]
pub struct MotionEnergy {
    joints: Vec<JointEnergy>,
    /// Positions that are not transformed yet, one series per joint, and the time between them, s.
    waiting: Vec<Vec<f64>>,
    period: f64,
    /// Hz: a fifth of the lowest rate.
    highest: f64,
}

/// The frequency content of positions sampled every `period` s, and the cut-off by the rule.
pub fn rule(q: &[Vec<f64>], period: f64) -> FrequencyContent {
    let mut energy = MotionEnergy::default();
    energy.push(q, period);
    energy.content()
}

/// The frequency content of a motion as noisy encoders will show it, and the cut-off by the rule.
///
/// `deviation` holds the standard deviations of the noise, rad or m, one per joint.
pub(crate) fn rule_with_noise(q: &[Vec<f64>], period: f64, deviation: &[f64]) -> FrequencyContent {
    let mut energy = MotionEnergy::default();
    energy.push(q, period);
    energy.end_record();
    for ((joint, q), s) in energy.joints.iter_mut().zip(q).zip(deviation) {
        joint.noise += acceleration_noise(s * s, q.len(), period);
    }
    energy.content()
}

/// (2 pi)^4 sigma^2 n h^2 / 5, rad^2/s^3. Times f^5 it is the noise of n accelerations, h s apart, up to a frequency f.
fn acceleration_noise(variance: f64, count: usize, period: f64) -> f64 {
    TAU.powi(4) / 5.0 * variance * count as f64 * period * period
}

impl MotionEnergy {
    /// Adds positions `period` s apart that continue those before; where they do not, call `end_record` first.
    pub fn push(&mut self, q: &[Vec<f64>], period: f64) {
        let highest = 0.2 / period;
        self.highest = if self.highest > 0.0 { self.highest.min(highest) } else { highest };
        // The periods of blocks of one clock differ in the last digits only. Keeping the first gives all blocks the
        // same frequencies.
        if (period / self.period - 1.0).abs() > 1e-6 || self.period == 0.0 {
            self.period = period;
        }
        self.waiting.resize(q.len(), Vec::new());
        self.joints.resize(q.len(), JointEnergy::default());
        for (waiting, q) in self.waiting.iter_mut().zip(q) {
            waiting.extend_from_slice(q);
        }
        while self.waiting.first().is_some_and(|q| q.len() >= SAMPLES_PER_TRANSFORM) {
            self.transform(SAMPLES_PER_TRANSFORM);
        }
    }

    /// Ends a record; positions pushed from now on belong to another.
    pub(crate) fn end_record(&mut self) {
        let left = self.waiting.first().map_or(0, Vec::len);
        self.transform(left);
    }

    /// The content of all that was pushed, and the cut-off by the rule.
    pub fn content(mut self) -> FrequencyContent {
        self.end_record();
        let energy: Vec<f64> = self.joints.iter().map(|joint| joint.motion.values().sum()).collect();
        let most = energy.iter().copied().fold(0.0, f64::max);
        let counts = |e: f64| e > 0.0 && e >= COUNTED_ENERGY_SHARE * most;
        let f95 = |(joint, &e): (&JointEnergy, &f64)| {
            if counts(e) { quantile(&joint.motion, MOTION_ENERGY_SHARE * e) } else { 0.0 }
        };
        let f95: Vec<f64> = self.joints.iter().zip(&energy).map(f95).collect();
        let fastest = f95.iter().copied().fold(0.0, f64::max);
        let cutoff = if fastest > 0.0 { (CUTOFF_FREQUENCY_RATIO * fastest).min(self.highest) } else { self.highest };
        let counting = self.joints.iter().zip(&energy).filter(|(_, e)| counts(**e));
        let noisy = counting.map(|(joint, _)| joint.noise_limit()).fold(f64::INFINITY, f64::min);
        FrequencyContent { f95, cutoff: cutoff.min(noisy.max(MIN_CUTOFF_FREQUENCY_RATIO * self.f95_of_all())) }
    }

    /// Frequency below which 95 % of the energy of all joints together lies, Hz.
    fn f95_of_all(&self) -> f64 {
        let mut all = Energy::new();
        for (&frequency, energy) in self.joints.iter().flat_map(|joint| &joint.motion) {
            *all.entry(frequency).or_insert(0.0) += energy;
        }
        let sum: f64 = all.values().sum();
        quantile(&all, MOTION_ENERGY_SHARE * sum)
    }

    /// Transforms the first `count` of the waiting samples.
    fn transform(&mut self, count: usize) {
        if count < MIN_SPECTRUM_SAMPLES {
            return self.waiting.iter_mut().for_each(|q| q.truncate(0));
        }
        // A length with small factors, because the transform of a prime length is several times slower.
        let of_motion = numerics::fft::forward(smooth_length(count));
        let of_noise = numerics::fft::forward(smooth_length(count.min(SAMPLES_PER_NOISE_ESTIMATE)));
        let (period, joints) = (self.period, &mut self.joints);
        let energy = |_: usize, q: &Vec<f64>| {
            let variance = noise_of(&q[..count], of_noise.as_ref());
            match excursion(&q[..count]) < REST_RANGE.max(REST_RANGE_SIGMAS * variance.sqrt()) {
                true => (Vec::new(), 0.0),
                false => (energy_of(&q[..count], period, of_motion.as_ref()), variance),
            }
        };
        let Ok(()) = in_order(&self.waiting, energy, |j, (motion, variance)| {
            joints[j].noise += acceleration_noise(variance, count, period);
            for (frequency, energy) in motion {
                *joints[j].motion.entry(frequency).or_insert(0.0) += energy;
            }
            Ok::<(), Infallible>(())
        });
        self.waiting.iter_mut().for_each(|q| drop(q.drain(..count)));
    }
}

impl JointEnergy {
    /// Largest frequency up to which noise is at most [`NOISE_ENERGY_SHARE`] of the acceleration, Hz; infinite without
    /// noise.
    fn noise_limit(&self) -> f64 {
        let squared = |bits: &u64| (TAU * f64::from_bits(*bits)).powi(2);
        let acceleration: f64 = self.motion.iter().map(|(bits, energy)| squared(bits) * energy).sum();
        (NOISE_ENERGY_SHARE * acceleration / self.noise).powf(0.2)
    }
}

/// The frequency up to which the energy adds up to `sum`, Hz.
fn quantile(energy: &Energy, sum: f64) -> f64 {
    let mut below = 0.0;
    let reached = energy.iter().find(|(_, e)| {
        below += **e;
        below >= sum
    });
    reached.map_or(0.0, |(bits, _)| f64::from_bits(*bits))
}

/// Joints whose extremes are closer than this (rad, m) are at rest. What they show is noise.
const REST_RANGE: f64 = 1e-3;

/// Joints whose extremes are closer than this many standard deviations of their noise are at rest too. The extremes of
/// a million samples of noise are ten apart.
const REST_RANGE_SIGMAS: f64 = 20.0;

/// From the lowest to the highest position.
fn excursion(q: &[f64]) -> f64 {
    let (low, high) = q.iter().fold((f64::MAX, f64::MIN), |(l, h), &x| (l.min(x), h.max(x)));
    high - low
}

/// The bits of each frequency of motion in Hz, and its energy.
fn energy_of(q: &[f64], period: f64, fft: &dyn RealToComplex<f64>) -> Vec<(u64, f64)> {
    let n = fft.len();
    // The line through both ends is subtracted, so that the ends of the record make no jump.
    let slope = (q[n - 1] - q[0]) / (n - 1) as f64;
    let mut x: Vec<f64> = (0..n).map(|i| q[i] - q[0] - slope * i as f64).collect();
    let mut spectrum = fft.make_output_vec();
    if fft.process(&mut x, &mut spectrum).is_err() {
        return Vec::new();
    }
    let squares: Vec<f64> = spectrum.iter().map(|c| c.norm_sqr()).collect();
    let noise = mean_square(&squares[n / 4..]);
    // Beyond a fifth of the rate, differentiated noise would outweigh the motion.
    let moving = squares.iter().enumerate().take(n / 5).skip(1).filter(|(_, s)| **s > MOTION_TO_NOISE_RATIO * noise);
    let energy = |(k, square): (usize, &f64)| {
        let frequency = k as f64 / (n as f64 * period);
        (frequency.to_bits(), (TAU * frequency).powi(2) * square * period / n as f64)
    };
    moving.map(energy).collect()
}

/// The variance of the noise of one position, rad^2 (m^2), from the middle of the record.
///
/// The window is flat at its ends [Harris 1978], so the ends of the piece do not leak into the upper half of the band.
fn noise_of(q: &[f64], fft: &dyn RealToComplex<f64>) -> f64 {
    let n = fft.len();
    let q = &q[(q.len() - n) / 2..][..n];
    let slope = (q[n - 1] - q[0]) / (n - 1) as f64;
    let window = |i: usize| 0.5 - 0.5 * (TAU * i as f64 / n as f64).cos();
    let mut x: Vec<f64> = (0..n).map(|i| window(i) * (q[i] - q[0] - slope * i as f64)).collect();
    let mut spectrum = fft.make_output_vec();
    if fft.process(&mut x, &mut spectrum).is_err() {
        return 0.0;
    }
    let squares: Vec<f64> = spectrum[n / 4..].iter().map(|c| c.norm_sqr()).collect();
    // The squares of the window add up to 3 n / 8.
    mean_square(&squares) / (0.375 * n as f64)
}

/// The mean square of a bin of noise, from the median of the bins.
///
/// The squares of white noise are distributed exponentially. Spectral lines do not move the median.
fn mean_square(squares: &[f64]) -> f64 {
    let mut squares = squares.to_vec();
    let middle = squares.len() / 2;
    if squares.is_empty() {
        return 0.0;
    }
    *squares.select_nth_unstable_by(middle, f64::total_cmp).1 / std::f64::consts::LN_2
}

/// The largest product of 2s, 3s and 5s up to n, at least 95 % of it.
fn smooth_length(n: usize) -> usize {
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

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;
    use std::f64::consts::PI;

    fn wave(n: usize, period: f64, hz: f64, amplitude: f64) -> Vec<f64> {
        (0..n).map(|i| amplitude * (2.0 * PI * hz * i as f64 * period).sin()).collect()
    }

    #[test]
    fn a_wave_has_its_own_frequency() {
        for (n, period) in [(4000, 0.001), (3989, 0.01)] {
            let content = rule(&[vec![0.3; n], wave(n, period, 1.5, 1.0)], period);
            assert_eq!(content.f95[0], 0.0);
            let resolution = 2.0 / (n as f64 * period);
            assert!((content.f95[1] - 1.5).abs() <= resolution, "{content:?}");
            assert_eq!(content.cutoff, (20.0 * content.f95[1]).min(0.2 / period));
        }
    }

    #[test]
    fn short_records_and_rest_do_not_fail() {
        assert_eq!(rule(&[vec![0.0; 3]], 0.1).cutoff, 2.0);
        assert_eq!(rule(&[], 0.1).cutoff, 2.0);
    }

    /// Neither a held joint, nor a creeping one, nor one with a rough encoder says how fast the motion is.
    #[test]
    fn noise_is_no_motion() {
        let mut random = Random::new(3);
        let n = 8000;
        let mut noisy = |x: Vec<f64>, sd: f64| x.iter().map(|x| x + sd * random.normal()).collect::<Vec<f64>>();
        let swing = noisy(wave(n, 1e-3, 0.5, 1.0), 1e-5);
        let (held, rough) = (noisy(vec![0.2; n], 1e-5), noisy(vec![0.2; n], 5e-4));
        let creeping = noisy(wave(n, 1e-3, 0.25, 0.02), 5e-5);
        // This joint follows the others at 8 Hz, by a hundredth of a radian.
        let shaken = noisy(wave(n, 1e-3, 8.0, 0.005), 1e-5);
        let content = rule(&[held, rough, swing, creeping, shaken], 1e-3);
        assert_eq!((content.f95[0], content.f95[1], content.f95[3], content.f95[4]), (0.0, 0.0, 0.0, 0.0));
        // One bin of a record of 8 s on either side.
        assert!((content.f95[2] - 0.5).abs() <= 0.126 && content.cutoff <= 12.6, "{content:?}");
    }

    /// f_c^5 = 1.25e-4 f^4 a^2 / (sigma^2 h) for a wave of amplitude a at f; no less than 5 f, no more than 20 f.
    #[test]
    fn noise_of_the_encoders_lowers_the_cutoff() {
        let (n, period) = (20_000, 1e-3);
        let mut random = Random::new(4);
        for (sd, expected) in [(1e-6, 20.0), (5e-4, 13.80), (1e-2, 5.0)] {
            let noisy: Vec<f64> = wave(n, period, 1.0, 1.0).iter().map(|x| x + sd * random.normal()).collect();
            let cutoff = rule(&[noisy], period).cutoff;
            let foretold = rule_with_noise(&[wave(n, period, 1.0, 1.0)], period, &[sd]).cutoff;
            assert!((foretold / expected - 1.0).abs() < 0.01, "{sd}: {foretold} for {expected}");
            // The noise of one draw is known to a few per cent, and its fifth root to less. A bin is a twentieth of a
            // Hz.
            assert!((cutoff / expected - 1.0).abs() < 0.02, "{sd}: {cutoff} for {expected}");
        }
    }

    /// The content does not depend on how the samples come in, and a record of a second beside one of a minute does not
    /// decide it.
    #[test]
    fn blocks_and_records_add_up() {
        let q = wave(150_000, 1e-3, 0.7, 1.0);
        let whole = rule(std::slice::from_ref(&q), 1e-3);
        let mut blocks = MotionEnergy::default();
        q.chunks(7001).for_each(|block| blocks.push(&[block.to_vec()], 1e-3));
        assert_eq!(blocks.content(), whole);
        let mut records = MotionEnergy::default();
        records.push(&[q[..60_000].to_vec()], 1e-3);
        records.end_record();
        records.push(&[q[60_400..61_400].to_vec()], 1e-3);
        let content = records.content();
        assert!((content.f95[0] - 0.7).abs() < 0.04, "{content:?}");
        assert!(rule(&[q[60_400..61_400].to_vec()], 1e-3).f95[0] > 0.9);
    }
}
