//! The bandwidth of a motion, and the default cut-off of the low-pass.
//!
//! The rule is f_c = 20 f_95, but at most a fifth of the sampling rate. 95 % of the energy of the velocity of a joint lies below
//! f_95; the largest f_95 of all joints is used. The factor of 20 has two reasons. The torques contain harmonics of the motion
//! (Coulomb friction, products of velocities), which the model explains. And the fourth-order low-pass distorts signals well
//! below its cut-off.
//!
//! f_c is at least 4 Hz, because friction changes sign as fast in a slow motion as in a fast one. With the rule alone, a motion
//! of 0.05 Hz would have a cut-off of 1 Hz, and every reversal would be smoothed over a second.
//!
//! Motion of a joint above 10 Hz counts as chatter of the drive if it has more than 5 % of the energy of the velocity but hardly
//! changes the position. Chatter does not count in f_95. The cut-off is then so low that the filter, of order four and applied
//! twice, reduces the chatter to the level of noise:
//!
//! sum over chatter of (2 pi f)^2 E_j(f) / (1 + (f / f_c)^8)^2 = 1e-4 A_j.
//!
//! If the noise of the positions requires it, the cut-off is lower, but at least 5 f_95 of all joints together:
//!
//! (2 pi)^4 N_j h^2 f_c^5 / 5 = 1e-4 A_j.
//!
//! Here E_j(f) is the energy of the velocity of joint j at the frequency f, A_j the energy of its acceleration, N_j the energy
//! of the noise and h the sample time (defined below). At this cut-off the twice differentiated noise of joint j is a hundredth
//! of its acceleration. Such noise biases inertias towards zero by the square of this ratio.
//!
//! The energy is summed over all records that are fitted together. So all records have one cut-off, and a short record, or a
//! joint at standstill in one record, has a small influence:
//!
//! E_j(f) = sum over records of (2 pi f)^2 |X_j(f)|^2 h / n,   |X_j(f)|^2 >= 20 N_j,   A_j = sum over f of (2 pi f)^2 E_j(f)
//!
//! X_j is the transform of n positions, h s apart. N_j is the noise: the mean of |X_j|^2 in the upper half of the band, where
//! no robot moves. N_j is n times the variance of the noise of a position. Only bins with |X_j|^2 >= 20 N_j count; white noise
//! exceeds this in two bins of a billion. A joint with less than a hundredth of the largest energy of a joint does not count,
//! because its motion is coupled to other joints or is coloured noise.

use std::convert::Infallible;

use numerics::fft::Plans;
use processor::{in_order, threads};

use crate::signals::position_spectrum::{Energy, acceleration_energy, acceleration_noise, position_energy, quantile};
use crate::signals::position_spectrum::{REST_RANGE, REST_RANGE_SIGMAS, energy_of, excursion, noise_of, smooth_length};

/// The frequency content of a motion, and the default cut-off that follows from it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrequencyContent {
    /// For each joint, the frequency below which 95 % of the energy of its velocity lies, Hz; 0 for a joint that hardly moves
    /// (`COUNTED_ENERGY_SHARE`).
    pub f95: Vec<f64>,
    /// Default cut-off of the low-pass, Hz.
    pub cutoff: f64,
}

/// The cut-off is at most this share of the sampling rate.
const HIGHEST_CUTOFF_SHARE: f64 = 0.2;

/// The default cut-off is this factor times the highest f95 of the joints.
const CUTOFF_FREQUENCY_RATIO: f64 = 20.0;
/// f95 of a joint is the frequency below which this share of the energy of its velocity lies.
const MOTION_ENERGY_SHARE: f64 = 0.95;

/// A joint counts for f95 if the energy of its velocity is at least this share of the largest energy of all joints. This share
/// of the energy corresponds to a tenth of the speed.
const COUNTED_ENERGY_SHARE: f64 = 1e-2;

/// Largest allowed energy of the filtered acceleration noise, divided by the energy of the acceleration.
const NOISE_ENERGY_SHARE: f64 = 1e-4;

/// Least cut-off for slow motions, Hz. On measured robots (cobot6, UR10e), parameters identified with a lower cut-off predict
/// other motions worse. A higher cut-off does not improve the prediction of slow motions.
const SLOW_CUTOFF_HZ: f64 = 4.0;

/// Motion below this frequency is never chatter, Hz. No commanded motion of a robot has higher frequencies.
const SLOWEST_CHATTER_HZ: f64 = 10.0;

/// Motion above [`SLOWEST_CHATTER_HZ`] is chatter if its position energy is below this share of the largest position energy of
/// all joints.
const CHATTER_POSITION_SHARE: f64 = 1e-3;

/// If the cut-off is lowered because of noise, it is still at least this factor times the f95 of all joints together. With a
/// factor of only 3, the filter would distort the motion itself.
const MIN_CUTOFF_FREQUENCY_RATIO: f64 = 5.0;

/// Number of samples per transform: a power of two, about a minute at 1 kHz.
const SAMPLES_PER_TRANSFORM: usize = 1 << 16;

/// Number of samples of a block from which the noise of the block is estimated.
const SAMPLES_PER_NOISE_ESTIMATE: usize = 1 << 12;

/// Least number of samples of a spectrum.
const MIN_SPECTRUM_SAMPLES: usize = 8;

/// Two sampling periods with at most this relative difference belong to one clock.
const EQUAL_PERIOD_TOLERANCE: f64 = 1e-6;

/// The energy of the motion of one joint, and the energy of the noise in those records in which the joint moves.
#[derive(Clone, Debug, Default)]
struct JointEnergy {
    motion: Energy,
    /// Energy of the chatter of the drive, by frequency.
    chatter: Energy,
    /// Noise factor, rad^2 s^2. The noise factor times f^5 is the energy of the acceleration noise up to the frequency f, Hz.
    noise: f64,
}

/// The energy of the velocities of joints by frequency, summed over records.
#[derive(Clone, Debug, Default)]
pub struct MotionEnergy {
    joints: Vec<JointEnergy>,
    /// Positions whose spectrum is not computed yet, one series per joint. `period`: time between samples, s.
    waiting: Vec<Vec<f64>>,
    period: f64,
    /// Highest allowed cut-off: a fifth of the lowest sampling rate, Hz.
    highest: f64,
    plans: Plans,
}

/// The frequency content and default cut-off of positions q, rad (m), one series per joint, sampled every `period` s.
pub fn rule(q: &[Vec<f64>], period: f64) -> FrequencyContent {
    let mut energy = MotionEnergy::default();
    energy.push(q, period);
    energy.content()
}

/// The frequency content and default cut-off of a noise-free motion with encoder noise. The noise is added to the spectrum and
/// not to the samples, so the result is not random.
///
/// `deviation`: standard deviations of the noise, rad (m), one per joint.
pub(crate) fn rule_with_noise(q: &[Vec<f64>], period: f64, deviation: &[f64]) -> FrequencyContent {
    let mut energy = MotionEnergy::default();
    energy.push(q, period);
    energy.end_record();
    for ((joint, q), s) in energy.joints.iter_mut().zip(q).zip(deviation) {
        joint.noise += acceleration_noise(s * s, q.len(), period);
    }
    energy.content()
}

impl MotionEnergy {
    /// Adds positions, sampled every `period` s, that continue the previous positions. Before a new record, call `end_record`.
    pub fn push(&mut self, q: &[Vec<f64>], period: f64) {
        let highest = HIGHEST_CUTOFF_SHARE / period;
        self.highest = if self.highest > 0.0 { self.highest.min(highest) } else { highest };
        // The periods of blocks of one clock differ only in the last digits. The period of the first block is used for all
        // blocks, so that their frequency bins are equal.
        if (period / self.period - 1.0).abs() > EQUAL_PERIOD_TOLERANCE || self.period == 0.0 {
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

    /// Limits the cut-off to a fifth of the sampling rate of the torques. `period`: time between samples of the torques, s.
    pub(crate) fn sample_efforts(&mut self, period: f64) {
        self.highest = self.highest.min(HIGHEST_CUTOFF_SHARE / period);
    }

    /// Ends a record. Positions that are added later belong to another record.
    pub(crate) fn end_record(&mut self) {
        let left = self.waiting.first().map_or(0, Vec::len);
        self.transform(left);
    }

    /// The frequency content of all records together, and the default cut-off.
    pub fn content(mut self) -> FrequencyContent {
        self.end_record();
        self.set_chatter_apart();
        let energy: Vec<f64> = self.joints.iter().map(|joint| joint.motion.values().sum()).collect();
        let most = energy.iter().copied().fold(0.0, f64::max);
        let counts = |e: f64| e > 0.0 && e >= COUNTED_ENERGY_SHARE * most;
        let f95 = |(joint, &e): (&JointEnergy, &f64)| {
            if counts(e) { quantile(&joint.motion, MOTION_ENERGY_SHARE * e) } else { 0.0 }
        };
        let f95: Vec<f64> = self.joints.iter().zip(&energy).map(f95).collect();
        let fastest = f95.iter().copied().fold(0.0, f64::max);
        let ruled = (CUTOFF_FREQUENCY_RATIO * fastest).max(SLOW_CUTOFF_HZ);
        let cutoff = if fastest > 0.0 { ruled.min(self.highest) } else { self.highest };
        let counting = self.joints.iter().zip(&energy).filter(|(_, e)| counts(**e));
        let noisy =
            counting.map(|(joint, _)| joint.noise_limit().min(joint.chatter_limit())).fold(f64::INFINITY, f64::min);
        FrequencyContent { f95, cutoff: cutoff.min(noisy.max(MIN_CUTOFF_FREQUENCY_RATIO * self.f95_of_all())) }
    }

    /// Moves the energy of the chatter of the drives (fast vibration without change of position) from the motion energy into a
    /// separate sum.
    fn set_chatter_apart(&mut self) {
        let largest = self.joints.iter().map(|joint| position_energy(joint.motion.iter())).fold(0.0, f64::max);
        for joint in &mut self.joints {
            let fast = joint.motion.range(SLOWEST_CHATTER_HZ.to_bits()..);
            let (whole, share) =
                (joint.motion.values().sum::<f64>(), fast.clone().map(|(_, energy)| energy).sum::<f64>());
            let is_chatter = share > (1.0 - MOTION_ENERGY_SHARE) * whole;
            if is_chatter && position_energy(fast) < CHATTER_POSITION_SHARE * largest {
                // The 5 % of the fast energy at the lowest frequencies stay in the motion energy, because this part is spectral
                // leakage from the ends of a record.
                let mut fast = joint.motion.split_off(&SLOWEST_CHATTER_HZ.to_bits());
                let slowest = quantile(&fast, (1.0 - MOTION_ENERGY_SHARE) * share);
                joint.chatter = fast.split_off(&slowest.to_bits());
            }
        }
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

    /// Computes the spectrum of the first `count` waiting samples, and adds the energy of this spectrum to the sums.
    fn transform(&mut self, count: usize) {
        if count < MIN_SPECTRUM_SAMPLES {
            return self.waiting.iter_mut().for_each(|q| q.truncate(0));
        }
        // The length has small prime factors, because the transform of a prime length takes several times longer.
        let of_motion = self.plans.forward(smooth_length(count));
        let of_noise = self.plans.forward(smooth_length(count.min(SAMPLES_PER_NOISE_ESTIMATE)));
        let (period, joints) = (self.period, &mut self.joints);
        let energy = |_: usize, q: &Vec<f64>| {
            let variance = noise_of(&q[..count], of_noise.as_ref());
            match excursion(&q[..count]) < REST_RANGE.max(REST_RANGE_SIGMAS * variance.sqrt()) {
                true => (Vec::new(), 0.0),
                false => (energy_of(&q[..count], period, of_motion.as_ref()), variance),
            }
        };
        let Ok(()) = in_order(&self.waiting, threads(), energy, |j, (motion, variance)| {
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
    /// The largest cut-off at which noise has at most [`NOISE_ENERGY_SHARE`] of the energy of the acceleration, Hz. Infinite
    /// without noise.
    fn noise_limit(&self) -> f64 {
        (NOISE_ENERGY_SHARE * acceleration_energy(self.motion.iter()) / self.noise).powf(0.2)
    }

    /// The largest cut-off at which the filtered chatter has at most [`NOISE_ENERGY_SHARE`] of the energy of the acceleration,
    /// Hz. Infinite without chatter.
    fn chatter_limit(&self) -> f64 {
        let Some((&slowest, _)) = self.chatter.first_key_value() else { return f64::INFINITY };
        let allowed = NOISE_ENERGY_SHARE * acceleration_energy(self.motion.iter());
        let left = |cutoff: f64| {
            let passed = |(bits, energy): (&u64, &f64)| {
                let gain = (1.0 + (f64::from_bits(*bits) / cutoff).powi(8)).powi(-2);
                acceleration_energy(std::iter::once((bits, &(gain * energy))))
            };
            self.chatter.iter().map(passed).sum::<f64>()
        };
        // The filtered chatter grows with the cut-off. Bisection finds the limit to a thousandth.
        let (mut low, mut high) = (0.0, f64::from_bits(slowest));
        for _ in 0..CUTOFF_BISECTIONS {
            let middle = 0.5 * (low + high);
            *(if left(middle) <= allowed { &mut low } else { &mut high }) = middle;
        }
        low
    }
}

/// Number of bisections of the interval that contains the cut-off.
const CUTOFF_BISECTIONS: usize = 10;

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

    #[test]
    fn noise_is_no_motion() {
        let mut random = Random::new(3);
        let n = 8000;
        let mut noisy = |x: Vec<f64>, sd: f64| x.iter().map(|x| x + sd * random.normal()).collect::<Vec<f64>>();
        let swing = noisy(wave(n, 1e-3, 0.5, 1.0), 1e-5);
        let (held, rough) = (noisy(vec![0.2; n], 1e-5), noisy(vec![0.2; n], 5e-4));
        let creeping = noisy(wave(n, 1e-3, 0.25, 0.02), 5e-5);
        // The motion of this joint at 8 Hz is caused by another joint. This motion is 0.01 rad peak to peak.
        let shaken = noisy(wave(n, 1e-3, 8.0, 0.005), 1e-5);
        let content = rule(&[held, rough, swing, creeping, shaken], 1e-3);
        assert_eq!((content.f95[0], content.f95[1], content.f95[3], content.f95[4]), (0.0, 0.0, 0.0, 0.0));
        // Allowed difference: one frequency bin in both directions. A bin is 1/8 Hz wide, because the record is 8 s long.
        assert!((content.f95[2] - 0.5).abs() <= 0.126 && content.cutoff <= 12.6, "{content:?}");
    }

    /// Default cut-off of a sine (amplitude a, frequency f, noise sigma, sample time h): f_c^5 = 1.25e-4 f^4 a^2 / (sigma^2 h),
    /// limited to 5 f .. 20 f.
    #[test]
    fn noise_of_the_encoders_lowers_the_cutoff() {
        let (n, period) = (20_000, 1e-3);
        let mut random = Random::new(4);
        for (sd, expected) in [(1e-6, 20.0), (5e-4, 13.80), (1e-2, 5.0)] {
            let noisy: Vec<f64> = wave(n, period, 1.0, 1.0).iter().map(|x| x + sd * random.normal()).collect();
            let cutoff = rule(&[noisy], period).cutoff;
            let foretold = rule_with_noise(&[wave(n, period, 1.0, 1.0)], period, &[sd]).cutoff;
            assert!((foretold / expected - 1.0).abs() < 0.01, "{sd}: {foretold} for {expected}");
            // The noise energy of one record is known to a few per cent. The cut-off depends on the fifth root of this energy,
            // which is known more accurately. A frequency bin is 0.05 Hz wide.
            assert!((cutoff / expected - 1.0).abs() < 0.02, "{sd}: {cutoff} for {expected}");
        }
    }

    /// Chatter of a drive at 105 Hz has more velocity energy than the motion. The cut-off follows from the motion, and the
    /// filtered chatter is a hundredth of the acceleration.
    #[test]
    fn the_cutoff_follows_the_motion_and_not_the_chatter() {
        let (n, period) = (20_000, 1e-3);
        let mut random = Random::new(6);
        let mut noisy = |x: Vec<f64>| x.iter().map(|x| x + 1e-6 * random.normal()).collect::<Vec<f64>>();
        let quiet = rule(&[noisy(wave(n, period, 1.0, 1.0))], period);
        assert!((quiet.cutoff - 20.0).abs() <= 1.0, "{quiet:?}");
        let motion = wave(n, period, 1.0, 1.0);
        let with = |amplitude: f64, hz: f64| -> Vec<f64> {
            motion.iter().zip(wave(n, period, hz, amplitude)).map(|(x, y)| x + y).collect()
        };
        for (amplitude, hz) in [(0.02, 105.0), (0.005, 105.0), (0.03, 30.0), (0.02, 170.0)] {
            let found = rule(&[noisy(with(amplitude, hz))], period);
            assert!((found.f95[0] - 1.0).abs() <= 0.1 && found.cutoff <= quiet.cutoff, "{hz}: {found:?}");
            let left = amplitude * hz * hz / (1.0 + (hz / found.cutoff).powi(8));
            // The tolerance is a thousandth for the bisection, plus the effect of a bin of 0.05 Hz.
            assert!(left <= 0.0105, "{amplitude} {hz}: {left} at {found:?}");
        }
        // Chatter is motion above 10 Hz with hardly any position energy, compared with the joint that has the largest position
        // energy. The four cases follow from this definition:
        // - 30 Hz with a tenth of the amplitude of the motion is not chatter: its position energy is too large.
        // - 30 Hz with a fiftieth of this amplitude is chatter, also if all amplitudes are fifty times smaller.
        // - 9 Hz is never chatter.
        // - 60 Hz alone is not chatter: without a slower motion, its own position energy is the largest.
        assert!(rule(&[noisy(with(0.1, 30.0))], period).f95[0] > 29.0);
        assert!(rule(&[noisy(with(0.02, 30.0).iter().map(|x| x / 50.0).collect())], period).f95[0] < 1.1);
        assert!(rule(&[noisy(with(0.03, 9.0))], period).f95[0] > 1.1);
        assert!(rule(&[noisy(wave(n, period, 60.0, 0.2))], period).f95[0] > 59.0);
    }

    #[test]
    fn a_slow_motion_keeps_its_reversals() {
        let (n, period) = (50_000, 2e-3);
        let mut random = Random::new(7);
        let mut cutoff = |sd: f64| {
            let noisy: Vec<f64> = wave(n, period, 0.05, 1.0).iter().map(|x| x + sd * random.normal()).collect();
            rule(&[noisy], period).cutoff
        };
        assert_eq!(cutoff(1e-6), 4.0);
        // The noise gives f_c^5 = 1.25e-4 f^4 a^2 / (sigma^2 h).
        let expected = (1.25e-4 * 0.05f64.powi(4) / (1e-8 * period)).powf(0.2);
        let found = cutoff(1e-4);
        assert!((found / expected - 1.0).abs() < 0.03 && found < 3.0, "{found} for {expected}");
    }

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
