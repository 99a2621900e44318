//! Robust regression: outliers have smaller weights.
//!
//! The method is iteratively reweighted least squares. The weights w(u) are those of the module `loss`, with u = residual / s_j
//! and the scale s_j = 1.4826 median(absolute residual) of joint j. Huber's weights start from the WLS solution, Tukey's from
//! Huber's solution.
//!
//! With psi(u) = w u the covariance is C = s^2 mean psi^2 / (mean psi')^2 (W'W)^-1 [Huber 1981, 7.6]. The triangle (R of the QR
//! decomposition) of the weighted rows would give s^2 mean(psi u) / mean w instead.

use linear_model::linear_model::Model;
use logs::Error;
use numerics::least_squares::Solution;

use crate::estimators::loss::Loss;
use crate::estimators::weighted::{Weights, fit};
use crate::rows::observation::{Observation, RowWeight};
use crate::signals::records::Records;

/// Largest number of reweighting iterations.
const MAX_REWEIGHTING_ITERATIONS: usize = 30;
/// The iteration ends if no parameter changes by more than this many sigma.
const SETTLED_CHANGE_SIGMAS: f64 = 1e-3;
/// Ratio of the standard deviation to the median absolute value, for normally distributed numbers.
const SIGMA_PER_MEDIAN: f64 = 1.4826;

/// The robust solution, with its weights and reweighted triangles.
pub struct Reweighted {
    /// The solution of the reweighted rows.
    pub solution: Solution,
    /// The weight of each joint, 1 / s_j, 1/(N m) (1/N). s_j: scale of its residuals.
    pub weights: Vec<f64>,
    /// The triangles of the reweighted rows.
    pub observation: Observation,
    /// For each joint j, the share of rows with |u| larger than the bound of the loss. u: residual divided by the scale s_j of
    /// the residuals of the joint.
    pub outliers: Vec<f64>,
    /// The function that gives the robust weight of a row from its residual.
    pub rows: Robust,
    /// slope = mean w / mean psi' over all rows. w: robust weight, psi: influence function. Standard deviations of a robust fit
    /// use the scores W' e, in which each residual e is multiplied by slope times w.
    pub slope: f64,
}

/// Gives the weight of a row from its residual. All sums after a robust fit use these weights.
#[derive(Clone, Debug)]
pub struct Robust {
    /// The loss function.
    pub loss: Loss,
    /// The scale s_j of the residuals of each joint j, N m (N): 1.4826 times the median of |residual|.
    scales: Vec<f64>,
}

impl Robust {
    /// The robust weight w(e / s_j) of a row of joint j. e: residual, N m (N); s_j: scale of the residuals of joint j.
    pub fn weight(&self, j: usize, e: f64) -> f64 {
        self.loss.weight(e / self.scales[j])
    }
}

/// The factor sqrt(w) by which a row of joint j with the residual e is multiplied. w: robust weight; 1 without robust weights.
pub fn row_factor(robust: Option<&Robust>, j: usize, e: f64) -> f64 {
    robust.map_or(1.0, |rows| rows.weight(j, e).sqrt())
}

/// Iteratively reweighted least squares with the loss `loss`. The iteration starts from the solution `start`.
///
/// Fails if a record cannot be read.
pub fn reweighted<R: Records + ?Sized>(
    model: &Model,
    records: &R,
    start: &Solution,
    loss: Loss,
) -> Result<Reweighted, Error> {
    let mut x = start.x.clone();
    let mut iterations = 0;
    loop {
        iterations += 1;
        // Scales s_j and weights w(e / s_j) come from the residuals e of the previous solution x.
        let mut sizes = vec![Sizes::new(); model.n()];
        records.each(&mut |states| model.residuals(states, &x, |_, j, e| sizes[j].add(e)))?;
        let scales: Vec<f64> = sizes.iter().map(Sizes::sigma).collect();
        let weight = |j: usize, e: f64| loss.weight(e / scales[j]).sqrt();
        let observation = Observation::of_records(model, records, Some(RowWeight { x: &x, weight: &weight }))?;
        let (mut solution, weights) = fit(&observation.joints(|_| true), Weights::Joint);
        // Change of each parameter in standard deviations: |x_c - x_c'| / sigma_c, where x' is the new solution.
        let change = x.iter().zip(&solution.x).enumerate().map(|(c, (a, b))| {
            (a - b).abs() / (solution.variance * solution.inverse[(c, c)]).sqrt().max(f64::MIN_POSITIVE)
        });
        if change.fold(0.0, f64::max) < SETTLED_CHANGE_SIGMAS || iterations == MAX_REWEIGHTING_ITERATIONS {
            let outliers = sizes.iter().zip(&scales).map(|(s, scale)| s.beyond(loss.bound() * scale)).collect();
            // The covariance of a robust fit needs the factor `means.variance()` (see the file's head). The sums use x and the
            // scales from which the weights of this solution were computed.
            let means = Means::of(model, records, &x, &scales, loss)?;
            solution.variance *= means.variance();
            let slope = means.slope();
            let rows = Robust { loss, scales };
            return Ok(Reweighted { solution, weights, observation, outliers, rows, slope });
        }
        x = solution.x;
    }
}

/// Sums over all rows, with u = e / s_j. e: residual of the row, s_j: scale of the residuals of joint j, w: robust weight,
/// psi(u) = w(u) u: influence function. The fields are: number of rows, sum of w, sum of psi u, sum of psi^2, sum of psi'.
#[derive(Default)]
struct Means {
    rows: f64,
    w: f64,
    psi_u: f64,
    psi_psi: f64,
    /// Sum of psi'(u).
    slope: f64,
}

impl Means {
    fn of<R: Records + ?Sized>(
        model: &Model,
        records: &R,
        x: &[f64],
        scales: &[f64],
        loss: Loss,
    ) -> Result<Means, Error> {
        let mut means = Means::default();
        records.each(&mut |states| {
            model.residuals(states, x, |_, j, e| {
                let u = e / scales[j];
                let w = loss.weight(u);
                means.rows += 1.0;
                means.w += w;
                means.psi_u += w * u * u;
                means.psi_psi += (w * u).powi(2);
                means.slope += loss.slope(u);
            });
        })?;
        Ok(means)
    }

    /// mean w / mean psi' (w: robust weight, psi: influence function); 1 if the ratio is not a positive number.
    fn slope(&self) -> f64 {
        Some(self.w / self.slope).filter(|s| s.is_finite() && *s > 0.0).unwrap_or(1.0)
    }

    /// The variance of a robust fit divided by the variance from the weighted rows of this fit; 1 if the ratio is not a
    /// positive number.
    fn variance(&self) -> f64 {
        let ratio = self.rows * self.psi_psi * self.w / (self.slope * self.slope * self.psi_u);
        Some(ratio).filter(|r| r.is_finite() && *r > 0.0).unwrap_or(1.0)
    }
}

/// A histogram of absolute values with a relative resolution of 1/256.
///
/// The index of a bin is the leading bits of a float, so the bins have a logarithmic scale. The median is computed without
/// storing the numbers and without knowing their range.
#[derive(Clone)]
struct Sizes {
    counts: Vec<u32>,
}

/// The bin number of a float contains the exponent and the 8 highest fraction bits. This constant is the number of the other
/// fraction bits.
const DROPPED_FRACTION_BITS: u32 = 52 - 8;

impl Sizes {
    fn new() -> Sizes {
        Sizes { counts: vec![0; (f64::INFINITY.to_bits() >> DROPPED_FRACTION_BITS) as usize + 1] }
    }

    fn add(&mut self, e: f64) {
        if e.is_finite() {
            self.counts[(e.abs().to_bits() >> DROPPED_FRACTION_BITS) as usize] += 1;
        }
    }

    fn total(&self) -> u64 {
        self.counts.iter().map(|&c| u64::from(c)).sum()
    }

    /// 1.4826 times the median, which equals sigma for normally distributed numbers; 1 for an empty histogram.
    fn sigma(&self) -> f64 {
        let mut left = self.total() / 2;
        let middle = self.counts.iter().position(|&c| {
            let here = u64::from(c) > left;
            left = left.saturating_sub(u64::from(c));
            here
        });
        let value =
            |bin: usize| f64::from_bits(((bin as u64) << DROPPED_FRACTION_BITS) | (1 << (DROPPED_FRACTION_BITS - 1)));
        middle.map_or(1.0, |bin| (SIGMA_PER_MEDIAN * value(bin)).max(f64::MIN_POSITIVE))
    }

    /// The share of the absolute values that are larger than `limit`.
    fn beyond(&self, limit: f64) -> f64 {
        let far: u64 =
            self.counts[(limit.to_bits() >> DROPPED_FRACTION_BITS) as usize + 1..].iter().map(|&c| u64::from(c)).sum();
        far as f64 / self.total().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::pendulum;
    use random::Random;

    #[test]
    fn outliers_do_not_pull() {
        let (arm, model) = pendulum();
        let mut random = Random::new(17);
        let runs = 30;
        let (mut bias_ls, mut bias, mut bias_bisquare) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for _ in 0..runs {
            let mut states = arm.states(800);
            for r in 0..states.len() {
                let outlier = if random.uniform() < 0.05 { 3.0 } else { 0.0 };
                states.tau[r] += 0.1 * random.normal() + outlier * states.q[r].signum();
            }
            let (ls, _) = fit(&Observation::of(&model, &states, 1).joints(|_| true), Weights::Joint);
            let records = [states];
            let robust = reweighted(&model, records.as_slice(), &ls, Loss::Huber).unwrap();
            let bisquare = reweighted(&model, records.as_slice(), &robust.solution, Loss::Bisquare).unwrap();
            // 5 % of the rows are outliers of 30 sigma. No other row exceeds the bound of 4.7 sigma.
            assert!((bisquare.outliers[0] - 0.05).abs() < 0.04, "{:?}", bisquare.outliers);
            for c in 0..3 {
                let sigma = 0.1 * robust.solution.inverse[(c, c)].sqrt() * robust.weights[0];
                bias_ls[c] += (ls.x[c] - arm.truth[c]) / sigma / f64::from(runs);
                bias[c] += (robust.solution.x[c] - arm.truth[c]) / sigma / f64::from(runs);
                bias_bisquare[c] += (bisquare.solution.x[c] - arm.truth[c]) / sigma / f64::from(runs);
            }
        }
        let worst = |b: [f64; 3]| b.into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        assert!(worst(bias_ls) > 3.0, "{bias_ls:?}");
        assert!(worst(bias) < worst(bias_ls) / 5.0, "{bias:?} {bias_ls:?}");
        // The mean of thirty runs has a standard deviation of 1/sqrt(30) = 0.18 sigma; 0.5 sigma is allowed. Huber's estimate has
        // a bias of half a sigma here.
        assert!(worst(bias_bisquare) < 0.5 && worst(bias_bisquare) < worst(bias), "{bias_bisquare:?} {bias:?}");
    }

    #[test]
    fn clean_data_are_left_alone() {
        let (arm, model) = pendulum();
        let mut random = Random::new(18);
        let mut states = arm.states(800);
        states.tau.iter_mut().for_each(|t| *t += 0.1 * random.normal());
        let (ls, _) = fit(&Observation::of(&model, &states, 1).joints(|_| true), Weights::Joint);
        let robust = reweighted(&model, [states].as_slice(), &ls, Loss::Huber).unwrap();
        for c in 0..3 {
            let sigma = (ls.variance * ls.inverse[(c, c)]).sqrt();
            // Huber's estimate has 95 % efficiency. So the difference between Huber's estimate and least squares has a standard
            // deviation of 0.23 sigma. Four standard deviations are allowed.
            assert!((robust.solution.x[c] - ls.x[c]).abs() < sigma);
        }
        // For normal noise, 17.9 % of the residuals are larger than 1.345 sigma. With 800 rows this share has a standard
        // deviation of 1.4 %.
        assert!((robust.outliers[0] - 0.179).abs() < 0.05, "{:?}", robust.outliers);
    }
}
