//! Computes the residual of the nominal base parameters on a log. Nominal: from the robot description. Only friction is fitted
//! to this log.
//!
//! The fit is tau - Y X = F x_F. Y X: torques of the nominal base parameters X; F: columns of friction and couplings; x_F:
//! fitted parameters of these columns. The rows are weighted by joint.

use linear_model::linear_model::Model;
use numerics::least_squares::solve;
use numerics::triangle::{Triangle, TriangleBuilder};

use crate::estimate::held_out::residuals;
use crate::estimate::residuals::Residuals;

/// Residuals with the nominal base parameters `described` and fitted friction. `joints`: triangles (R of QR) of the rows, one
/// per joint; `weights`: weight of the rows of each joint.
pub fn nominal_residuals(model: &Model, joints: &[Triangle], weights: &[f64], described: &[f64]) -> Residuals {
    residuals(model, joints, &nominal_values(model, joints, weights, described))
}

/// The nominal base parameters `described`, followed by the friction parameters with the smallest residual; one value per
/// column of the model. `joints`: triangles (R of QR) of the rows; `weights`: weight of the rows of each joint.
pub fn nominal_values(model: &Model, joints: &[Triangle], weights: &[f64], described: &[f64]) -> Vec<f64> {
    let (p, base) = (model.p(), described.len());
    let mut rest = TriangleBuilder::new(p - base);
    for (joint, weight) in joints.iter().zip(weights) {
        for i in 0..=p {
            let entry = |c: usize| if i <= c { weight * joint.at(i, c) } else { 0.0 };
            let known: f64 = described.iter().enumerate().map(|(c, x)| entry(c) * x).sum();
            let row: Vec<f64> = (base..p).map(entry).collect();
            rest.push(&row, entry(p) - known);
        }
    }
    let friction = if p > base { solve(&rest.finish()).x } else { Vec::new() };
    [described, &friction].concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::observation::Observation;
    use crate::test_arm::Pendulum;
    use linear_model::friction::terms::FrictionTerm;

    #[test]
    fn the_right_description_predicts_its_log() {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &FrictionTerm::STANDARD, &[]);
        let mut states = arm.states(800);
        for r in 0..states.len() {
            states.tau[r] += 0.4 * states.dq[r] + 0.3 * states.direction[r];
        }
        let joints = Observation::of(&model, &states, 4).joints(|_| true);
        let bare = Model::new(&arm, &[], &[]);
        let frictionless = Observation::of(&bare, &arm.states(800), 4).joints(|_| true);
        assert!(nominal_residuals(&bare, &frictionless, &[2.0], &arm.truth).total < 1e-9);
        let of = |described: &[f64]| nominal_residuals(&model, &joints, &[2.0], described).total;
        assert!(of(&arm.truth) < 1e-9, "{}", of(&arm.truth));
        let [zz, mx, my] = arm.truth;
        assert!(of(&[2.0 * zz, mx, my]) > 0.1);
    }
}
