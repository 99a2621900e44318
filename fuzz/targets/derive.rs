//! Fuzz target for robot models: each text is read, the model is derived, and its functions are evaluated.
//!
//! ```text
//! tau = Y_s X_s = Y X,    X = B X_s
//! ```
//! Property: the standard regressor Y_s and the base regressor Y give the same torques tau (N m, or N for a prismatic joint) for
//! random standard parameters X_s. X: base parameters, B: matrix that computes them from the standard parameters.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use random::Random;
use rist::describe::description::{check_values, parse_robot};
use rist::describe::evaluation::{Evaluation, ManyStates, Quantity};
use rist::{Model, ModelOptions};

/// Largest numbers of coordinates and links of a tested robot. Larger robots take seconds to derive and test nothing new.
const COORDINATES: usize = 4;
const LINKS: usize = 6;

/// Tolerance, relative to the sum of the magnitudes of all terms: a thousand operations with errors of 1e-16, and lengths that
/// cancel to three digits.
const ROUNDING: f64 = 1e-10;

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    for path in ["robot.yaml", "robot.urdf", "robot.par"].map(Path::new) {
        let Ok(robot) = parse_robot(text, path, &ModelOptions::default()) else { continue };
        let is_small = robot.coordinates.len() <= COORDINATES && robot.links.len() <= LINKS;
        if !is_small || robot.coordinates.is_empty() || check_values(&robot, path).is_err() {
            continue;
        }
        if let Ok(model) = Model::of(robot, path, false) {
            torques_agree(&model);
        }
    }
});

fn torques_agree(model: &Model) {
    let mut random = Random::new(7);
    let mut normal = |count: usize| (0..count).map(|_| random.normal()).collect::<Vec<f64>>();
    let n = model.regressor().coordinates().len();
    let (q, dq, ddq) = (normal(n), normal(n), normal(n));
    let standard = normal(model.parameters.standard.len());
    let base = model.parameters.values(&standard);
    let at = |quantity| {
        let evaluation = Evaluation::new(model, quantity).expect("a model that was derived is evaluated");
        let shape = evaluation.outputs()[0].clone();
        let mut y = vec![0.0; shape.rows * shape.columns];
        let states = ManyStates { q: &q, dq: &dq, ddq: &ddq, ..ManyStates::default() };
        evaluation.fill(model, &states, &mut y).expect("lengths are those of the model");
        y
    };
    let (y_s, y) = (at(Quantity::Regressor), at(Quantity::BaseRegressor));
    for k in 0..n {
        let row_s = &y_s[k * standard.len()..][..standard.len()];
        let row = &y[k * base.len()..][..base.len()];
        let (by_standard, by_base) = (sum(row_s, &standard), sum(row, &base));
        // Each base parameter is itself a sum of terms. The magnitudes of these terms also count for the tolerance.
        let absorbed = row.iter().zip(&model.parameters.base).flat_map(|(y, b)| {
            b.terms.iter().map(|term| (y * term.coefficient * standard[term.parameter]).abs()).collect::<Vec<f64>>()
        });
        let size = magnitude(row_s, &standard) + absorbed.sum::<f64>();
        let difference = (by_standard - by_base).abs();
        // If numbers overflow, or if a loop does not close, there is no finite torque to compare.
        if size.is_finite() {
            assert!(difference <= ROUNDING * size, "joint {k}: {by_standard} and {by_base}, of terms up to {size}");
        }
    }
}

fn sum(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn magnitude(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a * b).abs()).sum()
}
