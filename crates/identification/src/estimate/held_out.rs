//! Computes relative errors of predicted torques on data that were not fitted: other records, or left-out blocks
//! (cross-validation).
//!
//! For joint j: relative_j = |tau_j - W_j X| / |tau_j|, with parameters X that are fitted to other data. In cross-validation
//! each block of the record is predicted with X from all other blocks. Blocks are contiguous, because neighbouring samples
//! are correlated.
//!
//! The standard deviations of X predict this error: with the covariance C of X, the error of X raises the squared residual of
//! joint j by trace(W_j C W_j') on average.

use linear_model::linear_model::Model;
use logs::Error;
use numerics::triangle::{Triangle, TriangleBuilder};

use crate::estimate::residuals::{Residuals, Squares};
use crate::estimators::weighted::{Weights, fit};
use crate::rows::observation::{Observation, sum_by_joint, weighted};
use crate::signals::records::Records;

/// Computes the residuals of other records, predicted with the parameters `x`.
///
/// Fails when a record cannot be read.
pub fn validate<R: Records + ?Sized>(model: &Model, x: &[f64], records: &R) -> Result<Residuals, Error> {
    Ok(residuals(model, &Observation::of_records(model, records, None)?.joints(|_| true), x))
}

/// Residuals of cross-validation: each tenth of the record is predicted by a fit to the other tenths. A tenth is two
/// consecutive blocks of `observation`.
///
/// Each fit is weakly regularised towards the parameters of the whole record (`PARAMETER_HOLD_SHARE`). A combination of
/// parameters may be determined by one tenth only. When this tenth is left out, the combination keeps its value, so its error is
/// not tested.
pub fn cross_validate(model: &Model, observation: &Observation, weights: Weights) -> Residuals {
    cross_validate_by_part(model, observation, weights).0
}

/// Residuals of cross-validation by tenths of the record, and the relative error of each tenth over all joints, in the order
/// of time.
pub(crate) fn cross_validate_by_part(
    model: &Model,
    observation: &Observation,
    weights: Weights,
) -> (Residuals, Vec<f64>) {
    let parts = left_out(model, observation, weights);
    let all = together(model, &parts);
    (all, parts.into_iter().map(|part| Residuals::new(model.regressor, part).total).collect())
}

/// For each tenth of the record and each joint: sums of squared torques and residuals. The parameters are fitted to all other
/// tenths.
fn left_out(model: &Model, observation: &Observation, weights: Weights) -> Vec<Vec<Squares>> {
    let tenths: Vec<Vec<Triangle>> = observation.parts.chunks(2).map(sum_by_joint).collect();
    let (whole, weights) = fit(&observation.joints(|_| true), weights);
    predicted_from_others(model, &tenths, &weights, |rest| least_squares(rest, &whole.x))
}

/// Least-squares solution of `rest`, the rows of the record without one block. The solution is weakly regularised towards
/// `whole`, the solution of the whole record.
pub(crate) fn least_squares(mut rest: Triangle, whole: &[f64]) -> Vec<f64> {
    rest.merge(&held(&rest, whole), 1.0);
    rest.solution()
}

/// For each block and joint: sums of squared torques and residuals. `solve` finds the parameters from the weighted rows of
/// all other blocks. `parts`: for each block, the triangles (R of QR) of its joints; `weights`: one per joint.
pub(crate) fn predicted_from_others(
    model: &Model,
    parts: &[Vec<Triangle>],
    weights: &[f64],
    solve: impl Fn(Triangle) -> Vec<f64>,
) -> Vec<Vec<Squares>> {
    let rests = without_each(model, parts, weights);
    parts.iter().zip(rests).map(|(part, rest)| squares(model, part, &solve(rest))).collect()
}

/// Residuals over all blocks. `parts`: for each block, the sums of squares of its joints.
pub(crate) fn together(model: &Model, parts: &[Vec<Squares>]) -> Residuals {
    let mut sums = vec![Squares::default(); model.n()];
    for part in parts {
        for (sum, s) in sums.iter_mut().zip(part) {
            *sum = sum.with(s);
        }
    }
    Residuals::new(model.regressor, sums)
}

/// For each block, the triangle (R of QR) of the weighted rows of all other blocks. `parts`: for each block, the triangles of its
/// joints. `weights`: weights by joint, from a fit to the whole record (leaving out one block hardly changes them).
pub(crate) fn without_each(model: &Model, parts: &[Vec<Triangle>], weights: &[f64]) -> Vec<Triangle> {
    let parts: Vec<Triangle> = parts.iter().map(|joints| weighted(joints, weights)).collect();
    // The rows of all other blocks are the rows of the blocks before and of the blocks after. Running sums from both ends make
    // this computation fast.
    let sums = |parts: &mut dyn Iterator<Item = &Triangle>| -> Vec<Triangle> {
        let mut sum = Triangle::new(model.p());
        let before = parts.map(|part| {
            let before = sum.clone();
            sum.merge(part, 1.0);
            before
        });
        before.collect()
    };
    let before = sums(&mut parts.iter());
    let behind = sums(&mut parts.iter().rev());
    let mut rests = Vec::new();
    for (mut rest, behind) in before.into_iter().zip(behind.iter().rev()) {
        rest.merge(behind, 1.0);
        rests.push(rest);
    }
    rests
}

/// Weight of the row that regularises a parameter, divided by the norm of the column of the parameter.
const PARAMETER_HOLD_SHARE: f64 = 1e-3;

/// Rows that regularise each parameter towards its value in `x`, as a triangle (R of QR).
fn held(rows: &Triangle, x: &[f64]) -> Triangle {
    let p = rows.columns();
    let mut block = TriangleBuilder::new(p);
    for c in 0..p {
        let mut row = vec![0.0; p];
        row[c] = PARAMETER_HOLD_SHARE * rows.column_norm(c);
        block.push(&row, row[c] * x[c]);
    }
    block.finish()
}

/// Part of a relative error that comes from wrong parameters: sqrt(error^2 - least^2). `least`: relative error with
/// parameters that are fitted to the same data, that is, noise and model errors.
pub fn of_parameters(error: f64, least: f64) -> f64 {
    (error * error - least * least).max(0.0).sqrt()
}

/// Residuals tau - W x of each joint and in total. `joints`: triangles (R of QR) of the rows W and the torque tau, one per
/// joint.
pub fn residuals(model: &Model, joints: &[Triangle], x: &[f64]) -> Residuals {
    Residuals::new(model.regressor, squares(model, joints, x))
}

/// Sums of squared torques and squared residuals tau - W x, one entry per joint. `joints`: triangles (R of QR) of the rows.
fn squares(model: &Model, joints: &[Triangle], x: &[f64]) -> Vec<Squares> {
    let of_joint = |(j, joint): (usize, &Triangle)| {
        let (torque, left) = joint.squares(x);
        Squares::of(model, j, joint.rows, torque, left)
    };
    joints.iter().enumerate().map(of_joint).collect()
}

/// The relative error sqrt(sum trace(W C W')) / |tau| that the uncertainty of the parameters causes on average. `joints`:
/// triangles (R of QR) of the rows W, one per joint; `covariance`: C = sigma_i sigma_j rho_ij, p x p.
pub fn unsure(model: &Model, joints: &[Triangle], covariance: &[Vec<f64>]) -> f64 {
    let p = model.p();
    let of_row = |t: &Triangle, i: usize| -> f64 {
        let row: Vec<f64> = (i..p).map(|c| t.at(i, c)).collect();
        let along = |(a, x): (usize, &f64)| -> f64 {
            x * row.iter().zip(&covariance[i + a][i..]).map(|(y, c)| y * c).sum::<f64>()
        };
        row.iter().enumerate().map(along).sum()
    };
    let of_joint = |(j, t): (usize, &Triangle)| {
        let left = (0..p).map(|i| of_row(t, i)).sum::<f64>().max(0.0);
        Squares::of(model, j, t.rows, t.column_norm(p).powi(2) + t.taken_out, left)
    };
    Residuals::new(model.regressor, joints.iter().enumerate().map(of_joint).collect()).total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::pendulum;
    use linear_model::states::States;
    use random::Random;

    #[test]
    fn what_deviations_explain_is_what_such_an_error_leaves() {
        let (arm, model) = pendulum();
        let joints = Observation::of(&model, &arm.states(200), 4).joints(|_| true);
        let error = [0.02, -0.05, 0.01];
        let wrong: Vec<f64> = arm.truth.iter().zip(error).map(|(x, e)| x + e).collect();
        let covariance: Vec<Vec<f64>> = error.iter().map(|a| error.iter().map(|b| a * b).collect()).collect();
        let (explained, left) = (unsure(&model, &joints, &covariance), residuals(&model, &joints, &wrong).total);
        assert!(left > 1e-3 && (explained / left - 1.0).abs() < 1e-9, "{explained} {left}");
    }

    /// Only in one tenth of the record does the joint turn far enough to separate MX and MY. Without that tenth, the difference
    /// of MX and MY is not identifiable. The error of cross-validation must still equal the noise.
    #[test]
    fn what_one_part_tells_is_not_guessed_without_it() {
        let (arm, model) = pendulum();
        let mut states = arm.states(1000);
        let mut random = Random::new(7);
        states.q[100..].iter_mut().for_each(|q| *q = 0.3 + 1e-7 * *q);
        let mut truth = states.clone();
        model.rows(&states, 0..states.len(), |r, w| {
            truth.tau[r] = w.iter().zip(&arm.truth).map(|(w, x)| w * x).sum::<f64>() + 0.05 * random.normal();
        });
        let rms = |states: &States| (states.tau.iter().map(|t| t * t).sum::<f64>() / states.len() as f64).sqrt();
        let found = cross_validate(&model, &Observation::of(&model, &truth, 10), Weights::None);
        // The noise is 0.05. Tolerance: five standard errors of a thousand rows and three parameters.
        assert!((found.total * rms(&truth) - 0.05).abs() < 0.01, "{found}");
    }
}
