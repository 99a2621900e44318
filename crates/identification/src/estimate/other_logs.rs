//! Estimates the mean square error of identified parameters from logs that were not fitted.
//!
//! x, C: parameters and their covariance; T_j, z_j: rows and torques of joint j in another log; s_j: rms residual of joint j
//! in a fit to that log, N m (N); m: number of correlated rows that count as one. Then
//!
//! ```text
//! H = sum_j T_j'T_j / (m s_j^2)     g = sum_j T_j'(z_j - T_j x) / (m s_j^2)
//! P = C (1 + H C)^-1                d = P g                     E = P + d d'
//! ```
//! x + d is the estimate from both data sets, and P is its covariance. So E is the mean square error of x: the remaining
//! variance P plus the square of the change d. E is smaller than C if x predicts the other log well, and larger if x predicts
//! it worse than C explains.

use linear_model::linear_model::Model;
use nalgebra::{DMatrix, DVector};
use numerics::triangle::Triangle;

use crate::estimators::weighted::{Weights, fit};

/// Smallest ratio of squared residual to squared torque. Smaller residuals are rounding errors.
const ROUNDING_SQUARE_SHARE: f64 = 1e-18;

/// Computes the mean square errors E of the parameters x, p x p, row by row. `covariance`: C; `logs`: for each other log, the
/// triangles (R of QR) of its joints; `discount`: number of correlated rows that count as one. `None` if a matrix is
/// singular.
pub fn mean_square_errors(
    model: &Model,
    x: &[f64],
    covariance: &[Vec<f64>],
    logs: &[&[Triangle]],
    weights: Weights,
    discount: f64,
) -> Option<Vec<Vec<f64>>> {
    let p = model.p();
    // Parameters have different units, so they are divided by their standard deviations.
    let scale: Vec<f64> = (0..p).map(|c| covariance[c][c].max(0.0).sqrt()).collect();
    let over = |c: usize| if scale[c] > 0.0 { 1.0 / scale[c] } else { 0.0 };
    let correlation = DMatrix::from_fn(p, p, |i, j| over(i) * covariance[i][j] * over(j));
    let (mut information, mut slope) = (DMatrix::zeros(p, p), DVector::zeros(p));
    for joints in logs {
        let own = fit(joints, weights).0.x;
        for joint in joints.iter().filter(|joint| joint.rows > 0) {
            let (torque, left) = joint.squares(&own);
            // Variance m s_j^2 of a row, at least the variance of rounding.
            let variance = discount * left.max(ROUNDING_SQUARE_SHARE * torque) / joint.rows as f64;
            if variance <= 0.0 {
                continue;
            }
            let entry = |i: usize, c: usize| if i <= c { joint.at(i, c) } else { 0.0 };
            let rows = DMatrix::from_fn(p + 1, p, |i, c| entry(i, c) * scale[c]);
            let miss = |i: usize| entry(i, p) - (0..p).map(|c| entry(i, c) * x[c]).sum::<f64>();
            let miss = DVector::from_fn(p + 1, |i, _| miss(i));
            information += rows.transpose() * &rows / variance;
            slope += rows.transpose() * miss / variance;
        }
    }
    // P = C (1 + H C)^-1, d = P g, E = P + d d'. Rounding makes P asymmetric, so the mean of P and P' is used.
    let inverse = (DMatrix::identity(p, p) + information * &correlation).lu().try_inverse()?;
    let posterior = correlation * inverse;
    let moved = &posterior * slope;
    let entry = |i: usize, j: usize| 0.5 * (posterior[(i, j)] + posterior[(j, i)]) + moved[i] * moved[j];
    let error = |i: usize| (0..p).map(|j| scale[i] * entry(i, j) * scale[j]).collect::<Vec<f64>>();
    let errors: Vec<Vec<f64>> = (0..p).map(error).collect();
    errors.iter().flatten().all(|e| e.is_finite()).then_some(errors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::observation::Observation;
    use crate::test_arm::pendulum;
    use random::Random;

    /// Another log with little noise shows the errors of the parameters. Case 1: exact parameters; case 2: each parameter is
    /// wrong by two sigma. Without another log, E equals C.
    #[test]
    fn another_log_tells_the_error() {
        let (arm, model) = pendulum();
        let mut states = arm.states(500);
        let mut random = Random::new(3);
        states.tau.iter_mut().for_each(|tau| *tau += 1e-3 * random.normal());
        let log = Observation::of(&model, &states, 4).joints(|_| true);
        let (p, sigma) = (model.p(), 0.05);
        let covariance: Vec<Vec<f64>> =
            (0..p).map(|i| (0..p).map(|j| if i == j { sigma * sigma } else { 0.0 }).collect()).collect();
        let of = |x: &[f64], logs: &[&[Triangle]]| {
            mean_square_errors(&model, x, &covariance, logs, Weights::Joint, 1.0).unwrap()
        };
        for off in [0.0, 2.0] {
            let x: Vec<f64> = arm.truth.iter().map(|x| x + off * sigma).collect();
            let found = of(&x, &[&log]);
            for c in 0..p {
                // With noise of 0.001, a few hundred rows determine each parameter to about 0.001.
                assert!((found[c][c].sqrt() - off * sigma).abs() < 2e-3, "{off} {found:?}");
            }
        }
        let none = of(&arm.truth, &[]);
        assert!((0..p).all(|i| (0..p).all(|j| (none[i][j] - covariance[i][j]).abs() < 1e-15)));
    }
}
