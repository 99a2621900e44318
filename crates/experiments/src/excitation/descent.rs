//! Quasi-Newton descent for a function whose Hessian is partially known.
//!
//! The method is limited-memory BFGS [Nocedal, Wright 2006, algorithm 7.4] with a backtracking line search (Armijo) inside the
//! domain. The usual initial Hessian of L-BFGS, a multiple of the identity, is replaced by the known part of the Hessian (of a
//! barrier). A pair of step and gradient change is not stored if the curvature along the step is not positive.

use numerics::interruption::Interruption;
use numerics::vector::dot;

/// Greatest number of pairs of step and gradient change that L-BFGS stores.
const REMEMBERED_PAIRS: usize = 12;
/// Armijo constant: a step must achieve this share of the linearly predicted decrease.
const ARMIJO_SHARE: f64 = 1e-4;
/// Greatest number of times that the line search halves a step.
const MAX_STEP_HALVINGS: usize = 25;
/// A pair of step and gradient change is stored only if the cosine of the angle between step and gradient change exceeds this
/// value.
const MIN_CURVATURE_COSINE: f64 = 1e-10;
/// A descent ends after this number of consecutive iterations in which the objective decreases too little.
const MAX_STALLED_ITERATIONS: usize = 3;

/// An objective function on an open set, which a descent minimises.
pub trait Objective {
    /// Value and gradient at x. `None` if x is outside the set, or if the value is above `at_most`: the line search then rejects
    /// x and needs no gradient.
    fn value(&self, x: &[f64], at_most: f64) -> Option<(f64, Vec<f64>)>;

    /// Solves H y = `direction` with the known part H of the Hessian at x; y replaces `direction`.
    fn precondition(&self, x: &[f64], direction: &mut [f64]);

    /// The greatest step from x along `direction` that the line search may try, so that x stays inside the set.
    fn greatest_step(&self, x: &[f64], direction: &[f64]) -> f64;
}

/// The result of a descent.
pub struct Descent {
    /// The point at which the descent ended.
    pub x: Vec<f64>,
    /// The value of the objective at `x`.
    pub value: f64,
    /// Number of iterations of the descent.
    pub iterations: usize,
}

/// Minimises `objective` f from `x` in at most `iterations` steps. `None` if x is outside the domain of f.
///
/// Ends earlier if each of three consecutive iterations decreases f by less than `least` (1 + |f|), if no step succeeds, or if it
/// is interrupted.
pub(crate) fn descend(objective: &dyn Objective, x: &[f64], iterations: usize, least: f64) -> Option<Descent> {
    let mut x = x.to_vec();
    let (mut value, mut slope) = objective.value(&x, f64::INFINITY)?;
    // The stored pairs (s, y, 1 / s'y): s is a step, y the change of the gradient in this step. The oldest pair is first.
    let mut pairs: Vec<(Vec<f64>, Vec<f64>, f64)> = Vec::new();
    let mut stalled = 0;
    for iteration in 0..iterations {
        if Interruption::check().is_err() {
            return Some(Descent { x, value, iterations: iteration });
        }
        let mut direction = along(objective, &x, &slope, &pairs);
        let mut rate = dot(&direction, &slope);
        // If the stored pairs give an ascent direction, discard them and use the known part of the Hessian alone.
        if rate.is_nan() || rate >= 0.0 {
            pairs.clear();
            direction = along(objective, &x, &slope, &pairs);
            rate = dot(&direction, &slope);
        }
        let Some((next, next_value, next_slope)) = line_search(objective, &x, &direction, value, rate) else {
            if pairs.is_empty() {
                return Some(Descent { x, value, iterations: iteration });
            }
            pairs.clear();
            continue;
        };
        // s: step, y: change of the gradient. The pair is stored only if the curvature s'y along the step is clearly positive.
        let s: Vec<f64> = next.iter().zip(&x).map(|(a, b)| a - b).collect();
        let y: Vec<f64> = next_slope.iter().zip(&slope).map(|(a, b)| a - b).collect();
        let sy = dot(&s, &y);
        if sy > MIN_CURVATURE_COSINE * (dot(&s, &s) * dot(&y, &y)).sqrt() {
            if pairs.len() == REMEMBERED_PAIRS {
                pairs.remove(0);
            }
            pairs.push((s, y, 1.0 / sy));
        }
        stalled = if value - next_value < least * (1.0 + value.abs()) { stalled + 1 } else { 0 };
        (x, value, slope) = (next, next_value, next_slope);
        if stalled == MAX_STALLED_ITERATIONS {
            return Some(Descent { x, value, iterations: iteration + 1 });
        }
    }
    Some(Descent { x, value, iterations })
}

/// Backtracking line search: halves the step along `direction` until it achieves the required share of the predicted decrease.
/// `rate`: derivative along `direction`. Gives the new x with its value and gradient; `None` if no step succeeds.
fn line_search(
    objective: &dyn Objective,
    x: &[f64],
    direction: &[f64],
    value: f64,
    rate: f64,
) -> Option<(Vec<f64>, f64, Vec<f64>)> {
    let mut step = objective.greatest_step(x, direction).min(1.0);
    for _ in 0..MAX_STEP_HALVINGS {
        if Interruption::check().is_err() {
            return None;
        }
        let candidate: Vec<f64> = x.iter().zip(direction).map(|(x, d)| x + step * d).collect();
        if let Some((value, slope)) = objective.value(&candidate, value + ARMIJO_SHARE * step * rate) {
            return Some((candidate, value, slope));
        }
        step *= 0.5;
    }
    None
}

/// The descent direction of L-BFGS at x with gradient `slope`, by the two-loop recursion over the stored `pairs`.
fn along(objective: &dyn Objective, x: &[f64], slope: &[f64], pairs: &[(Vec<f64>, Vec<f64>, f64)]) -> Vec<f64> {
    let mut d: Vec<f64> = slope.iter().map(|g| -g).collect();
    let mut shares = Vec::with_capacity(pairs.len());
    for (s, y, rho) in pairs.iter().rev() {
        let share = rho * dot(s, &d);
        d.iter_mut().zip(y).for_each(|(d, y)| *d -= share * y);
        shares.push(share);
    }
    objective.precondition(x, &mut d);
    for ((s, y, rho), share) in pairs.iter().zip(shares.iter().rev()) {
        let back = rho * dot(y, &d);
        d.iter_mut().zip(s).for_each(|(d, s)| *d += (share - back) * s);
    }
    d
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's function on x_0 < 0.8, plus a logarithmic barrier that keeps the minimum away from 0.8.
    struct Valley;

    impl Objective for Valley {
        fn value(&self, x: &[f64], at_most: f64) -> Option<(f64, Vec<f64>)> {
            let room = 0.8 - x[0];
            if room <= 0.0 {
                return None;
            }
            let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
            let wall = 1e-4;
            let value = a * a + 100.0 * b * b - wall * room.ln();
            let gradient = vec![-2.0 * a - 400.0 * x[0] * b + wall / room, 200.0 * b];
            (value <= at_most).then_some((value, gradient))
        }

        fn precondition(&self, x: &[f64], direction: &mut [f64]) {
            direction[0] /= 2.0 + 1e-4 / (0.8 - x[0]).powi(2);
            direction[1] /= 200.0;
        }

        fn greatest_step(&self, x: &[f64], direction: &[f64]) -> f64 {
            if direction[0] > 0.0 { 0.99 * (0.8 - x[0]) / direction[0] } else { f64::INFINITY }
        }
    }

    #[test]
    fn the_valley_is_followed_to_the_wall() {
        let found = descend(&Valley, &[-1.2, 1.0], 200, 1e-7).unwrap();
        assert!(found.iterations < 200);
        // The minimum is near the barrier at 0.8: 2 (1 - x) = 1e-4 / (0.8 - x) gives 0.8 - x = 2.5e-4.
        let (a, b) = (found.x[0], found.x[1]);
        assert!((a - 0.79975).abs() < 1e-4 && (b - a * a).abs() < 1e-3, "{a} {b}");
        assert!(descend(&Valley, &[0.9, 0.0], 10, 1e-7).is_none());
    }
}
