//! How fast the motion is, and the cut-off that follows from it.
//!
//! The rule: f_c = 20 f_95, where f_95 is the frequency below which 95 % of the energy of the
//! fastest joint's velocity lies; at most a fifth of the sampling rate. The factor is twenty because the
//! torques hold harmonics of the motion (Coulomb friction, products of velocities) that the model
//! explains, and because the fourth-order low-pass bends the signals well below its cut-off.

use realfft::RealFftPlanner;

/// The frequency content of a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct FrequencyContent {
    /// f_95 of each joint, Hz: 95 % of the energy of its velocity lies below; 0 for a joint at rest.
    pub f95: Vec<f64>,
    /// Cut-off by the rule, Hz.
    pub cutoff: f64,
}

const FACTOR: f64 = 20.0;
const SHARE: f64 = 0.95;

/// The frequency content of positions sampled every `period` s, and the cut-off by the rule.
pub fn rule(q: &[Vec<f64>], period: f64) -> FrequencyContent {
    FrequencyContent::of(q.iter().map(|q| velocity_f95(q, period)).collect(), period)
}

impl FrequencyContent {
    fn of(f95: Vec<f64>, period: f64) -> FrequencyContent {
        let fastest = f95.iter().copied().fold(0.0, f64::max);
        let highest = 0.2 / period;
        FrequencyContent { cutoff: if fastest > 0.0 { (FACTOR * fastest).min(highest) } else { highest }, f95 }
    }

    /// The content of the fastest of two parts of a record, joint by joint.
    pub(crate) fn faster(self, other: FrequencyContent, period: f64) -> FrequencyContent {
        FrequencyContent::of(self.f95.iter().zip(&other.f95).map(|(a, b)| a.max(*b)).collect(), period)
    }
}

/// Joints that move less than this (rad, m) between their extremes are at rest: noise has no content.
const REST: f64 = 1e-3;

fn velocity_f95(q: &[f64], period: f64) -> f64 {
    let (low, high) = q.iter().fold((f64::MAX, f64::MIN), |(l, h), &x| (l.min(x), h.max(x)));
    // A length with small factors: the transform of a prime length is several times slower.
    let n = smooth_length(q.len());
    if n < 8 || high - low < REST {
        return 0.0;
    }
    // The line through both ends is subtracted, so that the ends of the record make no jump.
    let slope = (q[n - 1] - q[0]) / (n - 1) as f64;
    let mut x: Vec<f64> = (0..n).map(|i| q[i] - q[0] - slope * i as f64).collect();
    let fft = RealFftPlanner::new().plan_fft_forward(n);
    let mut spectrum = fft.make_output_vec();
    if fft.process(&mut x, &mut spectrum).is_err() {
        return 0.0;
    }
    // Noise beyond a fifth of the rate, differentiated, would outweigh the motion.
    let bins = n / 5;
    let energy: Vec<f64> =
        spectrum.iter().take(bins).enumerate().map(|(k, c)| c.norm_sqr() * (k as f64).powi(2)).collect();
    let total: f64 = energy.iter().sum();
    let mut sum = 0.0;
    let bin = energy.iter().position(|e| {
        sum += e;
        sum >= SHARE * total
    });
    bin.unwrap_or(0).max(1) as f64 / (n as f64 * period)
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
    use std::f64::consts::PI;

    #[test]
    fn a_wave_has_its_own_frequency() {
        for (n, period) in [(4000, 0.001), (3989, 0.01)] {
            let q: Vec<f64> = (0..n).map(|i| (2.0 * PI * 1.5 * i as f64 * period).sin()).collect();
            let content = rule(&[vec![0.3; n], q], period);
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
}
