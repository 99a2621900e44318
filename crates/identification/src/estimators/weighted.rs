//! Ordinary and weighted least squares from the triangles of the joints.
//!
//! OLS weighs all rows alike; WLS multiplies the rows of joint j by 1 / std(residual of joint j), three times over
//! [Gautier 1997]. Both come out of the same triangles. The robust weights (`huber`) need the rows again.

use serde::{Deserialize, Serialize};

use crate::algebra::least_squares::{Solution, solve};
use crate::algebra::triangle::Triangle;
use crate::rows::observation::weighted;

/// The weights of the rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Weights {
    /// All alike: ordinary least squares.
    None,
    /// By the standard deviation of the joint's residual: weighted least squares.
    Joint,
    /// As `Joint`, and rows that do not fit count less: robust regression.
    Huber,
    /// As `Huber`, and from there on rows that do not fit at all do not count.
    Bisquare,
}

/// Number of reweightings of WLS.
const REWEIGHTINGS: usize = 3;

/// Solves with the weights asked for; also returns the weights.
pub fn fit(joints: &[Triangle], weights: Weights) -> (Solution, Vec<f64>) {
    let mut w = vec![1.0; joints.len()];
    let mut solution = solve(&weighted(joints, &w));
    if weights != Weights::None {
        for _ in 0..REWEIGHTINGS {
            w = joints.iter().map(|joint| inverse_std(joint, &solution.x)).collect();
            solution = solve(&weighted(joints, &w));
        }
    }
    (solution, w)
}

/// 1 / root mean square of the residual; a joint without rows or without residual counts as it is.
fn inverse_std(joint: &Triangle, x: &[f64]) -> f64 {
    let (total, residual) = joint.squares(x);
    // A residual at the level of rounding would give the joint all the weight there is.
    let floor = 1e-20 * total;
    if joint.rows == 0 || total == 0.0 { 1.0 } else { (joint.rows as f64 / residual.max(floor)).sqrt() }
}

/// |residual| / |total| from squares; 0 where the total is 0.
pub fn relative(total: f64, residual: f64) -> f64 {
    if total > 0.0 { (residual / total).sqrt() } else { 0.0 }
}
