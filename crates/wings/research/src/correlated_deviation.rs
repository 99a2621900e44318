//! Variances of parameters whose scores (contributions of single samples to the error of the estimate) are correlated over time.
//!
//! h_r: score of sample r; n: number of samples; L: span of correlation, in samples; rho: correlation of residuals from sample to
//! sample. The variance of each parameter is
//!   var x = sum_l (1 - |l|/L) sum_r h_r h_(r-l)        [Newey, West 1987]
//! The weights 1 - |l|/L (Bartlett) are the weights of overlapping sums, so the variance is also
//!   var x = 1/L sum_k S_k^2,  S_k = sum of L successive h_r,
//! which needs only L vectors in memory. L follows the rule for a first-order process with the correlation of the residuals,
//!   L = 1.1447 (4 rho^2 / ((1 - rho)^2 (1 + rho)^2) n)^(1/3)   [Andrews 1991]
//! with rho the largest correlation among the joints. L is at most a tenth of the record.
//!
//! Not here: errors that depend on the state of the robot (`replicate_deviation`).

use linear_model::linear_model::Model;
use linear_model::states::States;

/// Largest span L of the overlapping sums, in samples. This limit bounds the memory.
const MAX_SPAN_SAMPLES: usize = 4096;
/// The factor in the rule of [Andrews 1991] for the span of Bartlett weights.
const ANDREWS_FACTOR: f64 = 1.1447;

/// Adds up the squares of overlapping sums. Each sum has `span` successive scores h_r.
pub(crate) struct OverlappingSums {
    ring: Vec<Vec<f64>>,
    sum: Vec<f64>,
    variance: Vec<f64>,
    at: usize,
}

impl OverlappingSums {
    pub(crate) fn new(p: usize, span: usize) -> OverlappingSums {
        OverlappingSums { ring: vec![vec![0.0; p]; span], sum: vec![0.0; p], variance: vec![0.0; p], at: 0 }
    }

    /// Adds the next score h_r.
    pub(crate) fn add(&mut self, h: &[f64]) {
        let span = self.ring.len();
        let slot = &mut self.ring[self.at % span];
        for c in 0..self.sum.len() {
            self.sum[c] += h[c] - slot[c];
            self.variance[c] += self.sum[c] * self.sum[c] / span as f64;
        }
        slot.copy_from_slice(h);
        self.at += 1;
    }

    /// The variance of each parameter. The sum includes spans that extend beyond the end of the record; scores beyond the end
    /// are zero.
    pub(crate) fn variance(mut self) -> Vec<f64> {
        let nothing = vec![0.0; self.sum.len()];
        for _ in 0..self.ring.len() {
            self.add(&nothing);
        }
        self.variance
    }
}

/// Computes the correlation of residuals between successive samples, for each joint.
struct LagOne {
    /// For each joint, index and residual of its last sample; `None` before the first sample.
    last: Vec<Option<(usize, f64)>>,
    squares: Vec<f64>,
    products: Vec<f64>,
}

impl LagOne {
    fn new(n: usize) -> LagOne {
        LagOne { last: vec![None; n], squares: vec![0.0; n], products: vec![0.0; n] }
    }

    fn add(&mut self, r: usize, j: usize, e: f64) {
        if let Some((_, before)) = self.last[j].filter(|(sample, _)| sample + 1 == r) {
            self.squares[j] += 0.5 * (e * e + before * before);
            self.products[j] += e * before;
        }
        self.last[j] = Some((r, e));
    }

    fn largest(&self) -> f64 {
        let rho = self.squares.iter().zip(&self.products).filter(|(s, _)| **s > 0.0).map(|(s, p)| p / s);
        rho.fold(0.0, f64::max)
    }
}

/// The correlation between successive residuals of a joint, for the joint where it is largest.
pub(crate) fn correlation(model: &Model, states: &States, x: &[f64]) -> f64 {
    let mut lag_one = LagOne::new(model.n());
    model.residuals(states, x, |r, j, e| lag_one.add(r, j, e));
    lag_one.largest()
}

pub(crate) fn span(rho: f64, n: usize) -> usize {
    // With n samples, a correlation above 1 - 1/(n + 1) cannot be distinguished from 1, so rho is limited to this value.
    let rho = rho.min(1.0 - 1.0 / (n as f64 + 1.0));
    let alpha = 4.0 * rho * rho / ((1.0 - rho) * (1.0 + rho)).powi(2);
    let length = ANDREWS_FACTOR * (alpha * n as f64).cbrt();
    (length.ceil() as usize).clamp(1, (n / 10).clamp(1, MAX_SPAN_SAMPLES))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;
    use random::Random;

    /// Noise with a correlation of 0.9 from sample to sample: the variance of its sum is 19 times as large as for white noise.
    /// Bartlett weights give a smaller factor.
    #[test]
    fn correlated_noise_is_not_taken_for_white() {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &[], &[]);
        let (mut random, runs, n) = (Random::new(11), 40, 2000);
        let (mut found, mut rho) = (0.0, 0.0);
        for _ in 0..runs {
            let (mut states, mut noise) = (arm.states(n), 0.0);
            let mut h = Vec::new();
            for r in 0..n {
                noise = 0.9 * noise + (1.0f64 - 0.81).sqrt() * random.normal();
                states.tau[r] += noise;
                h.push(noise);
            }
            let one = correlation(&model, &states, &arm.truth);
            let mut sums = OverlappingSums::new(1, span(one, n));
            h.iter().for_each(|h| sums.add(&[*h]));
            found += sums.variance()[0] / f64::from(runs) / n as f64;
            rho += one / f64::from(runs);
        }
        // Tolerances for forty records. Each record is worth about a hundred independent samples.
        assert!((rho - 0.9).abs() < 0.01, "{rho}");
        assert!((13.0..19.5).contains(&found), "{found}");
        assert_eq!(span(0.0, n), 1);
    }
}
