//! The motion that tells most, as a function of its coefficients with an exact gradient.
//!
//! f(x) = J(W(x)) + mu (B(x) + S(x) + T(x)): J the criterion of the rows at some instants of a period
//! ([`crate::excitation::criterion`]), B the wall of the kinematic limits
//! ([`crate::excitation::barrier`]), S that of the distances between bodies
//! ([`crate::excitation::space_wall`]), T that of torques and powers at the instants of the period and the
//! blends ([`crate::excitation::torque_wall`]).
//!
//! One reverse pass through the regressor gives the slope of J and T along the states: df/dY is known, dY/d(q, dq, ddq)
//! exact.

use crate::excitation::barrier::Curvature;
use crate::excitation::criterion::criterion;
use crate::excitation::descent::Objective;
use crate::excitation::problem::Prepared;
use crate::excitation::space_wall::Seen;

/// Curvature of the criterion along a scaled coefficient, roughly: what the barrier does not know.
const CRITERION_CURVATURE: f64 = 0.1;

/// A problem at one height of its walls.
pub struct Walled<'a> {
    /// What all starts share.
    pub prepared: &'a Prepared<'a>,
    /// mu.
    pub height: f64,
    /// What the start has seen of bodies.
    pub seen: &'a Seen,
}

impl Walled<'_> {
    fn evaluate(&self, x: &[f64], at_most: f64) -> Option<(f64, Vec<f64>)> {
        let (prepared, problem, height) = (self.prepared, self.prepared.problem, self.height);
        let mut gradient = vec![0.0; x.len()];
        let mut value = height * prepared.barrier().value(x, height, &mut gradient)?;
        let (n, b, moving) = (problem.limits.len(), problem.regressor.parameters().len(), prepared.moving());
        if let Some(space) = &prepared.space {
            value += space.value(self.seen, &|row| prepared.positions(x, row), height, &mut |row, slope| {
                moving.iter().enumerate().for_each(|(j, &k)| prepared.add_slope(j, row, slope[k], &mut gradient));
            })?;
        }
        let samples = problem.samples;
        let states = prepared.states(x);
        let y = prepared.filled(&states);
        if y.iter().any(|y| !y.is_finite()) {
            return None;
        }
        let mut weights = vec![0.0; y.len()];
        let mut along = vec![0.0; states.len()];

        if let Some(wall) = problem.torque {
            let weight = height / samples as f64;
            value += wall.value(problem.limits, weight, (&states, &y), &mut weights, &mut along)?;
        }

        // The criterion.
        let (w, friction) = prepared.rows(&states, &y);
        let found = criterion(problem.aim, w, prepared.p(), samples)?;
        value += found.value;
        if !(value.is_finite() && value <= at_most) {
            return None;
        }
        let (slope, of_motion) = (found.slope(), samples * moving.len());
        for (at, slope) in slope.chunks_exact(prepared.p()).enumerate().take(of_motion) {
            let (r, i) = (at / moving.len(), moving[at % moving.len()]);
            let noise = problem.noise[i];
            for (g, &c) in slope.iter().zip(&prepared.base) {
                weights[(r * n + i) * b + c] += g / noise;
            }
            for &(t, place) in &prepared.own[i] {
                let [_, along_dq, along_ddq] = friction[at][t];
                along[r * 3 * n + n + i] += slope[place] / noise * along_dq;
                along[r * 3 * n + 2 * n + i] += slope[place] / noise * along_ddq;
            }
        }

        // From the entries of Y to the states, and from those to the coefficients.
        let mut through = vec![0.0; states.len()];
        problem.regressor.pull_back(&states, &weights, &mut through);
        for (r, rows) in prepared.instants.iter().enumerate() {
            for (j, &k) in moving.iter().enumerate() {
                for (d, row) in rows.iter().enumerate() {
                    let at = r * 3 * n + d * n + k;
                    prepared.add_slope(j, row, through[at] + along[at], &mut gradient);
                }
            }
        }
        Some((value, gradient))
    }

    fn curvature(&self, x: &[f64]) -> Option<Curvature> {
        self.prepared.barrier().curvature(x, self.height, CRITERION_CURVATURE)
    }
}

impl Objective for Walled<'_> {
    fn value(&self, x: &[f64], at_most: f64) -> Option<(f64, Vec<f64>)> {
        self.evaluate(x, at_most)
    }

    fn precondition(&self, x: &[f64], direction: &mut [f64]) {
        // Inside the walls it is positive definite; without a factor the direction stays that of the slope.
        if let Some(curvature) = self.curvature(x) {
            curvature.solve(direction);
        }
    }

    fn greatest_step(&self, x: &[f64], direction: &[f64]) -> f64 {
        self.prepared.barrier().step(x, direction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::criterion::Aim;
    use crate::excitation::fourier_series::FourierSeries;
    use crate::excitation::gap_proof::tests::Rod;
    use crate::excitation::limits::CoordinateLimits;
    use crate::excitation::motion::Shape;
    use crate::excitation::problem::Problem;
    use crate::excitation::quintic_spline::QuinticSpline;
    use crate::excitation::search::tests::{pendulum_limits, pendulum_torque};
    use crate::pendulum::Pendulum;
    use linear_model::friction::terms::FrictionTerm;

    /// The gradient of criterion and walls together, against central differences.
    #[test]
    fn the_gradient_is_exact() {
        let (arm, wall) = (Pendulum::new(), pendulum_torque());
        let limits = [CoordinateLimits { power: Some(12.0), ..pendulum_limits() }];
        // Less than 0.05 m of room: the wall of space is felt.
        let rod = Rod::new(0.55);
        let series = Shape::Fourier(FourierSeries { period: 5.0, blend: 1.0, harmonics: 3 });
        let spline = Shape::Spline(QuinticSpline { period: 5.0, spans: 7 });
        let (of_series, of_spline) = ([0.1, 0.15, -0.1, 0.1, 0.2, 0.05, -0.1], [0.1, 0.2, -0.2, 0.2, -0.1, 0.2, 0.1]);
        let all = [Aim::Determinant, Aim::Condition];
        for (aim, (shape, x)) in all.into_iter().flat_map(|a| [(a, (series, of_series)), (a, (spline, of_spline))]) {
            let problem = Problem {
                regressor: &arm,
                friction: &[FrictionTerm::Viscous, FrictionTerm::Coulomb],
                limits: &limits,
                noise: &[0.1],
                aim,
                torque: Some(&wall),
                columns: &[true; 5],
                shape,
                samples: 50,
                surroundings: Some(&rod),
                prior: &[0.3, 0.1, 0.0, 0.0, 0.2],
            };
            let prepared = Prepared::new(&problem);
            let seen = Seen::default();
            let walled = Walled { prepared: &prepared, height: 0.01, seen: &seen };
            let (_, gradient) = walled.value(&x, f64::INFINITY).unwrap();
            for k in 0..x.len() {
                let h = 1e-6;
                let moved = |h: f64| {
                    let mut x = x;
                    x[k] += h;
                    walled.value(&x, f64::INFINITY).unwrap().0
                };
                let slope = (moved(h) - moved(-h)) / (2.0 * h);
                // Central differences: 1e-16 over 1e-6, and h^2 times the third derivative of the smooth sign.
                assert!(
                    (gradient[k] - slope).abs() < 1e-6 * (1.0 + slope.abs()),
                    "{aim:?} {shape:?} {k}: {} {slope}",
                    gradient[k]
                );
            }
            let (value, _) = walled.value(&x, f64::INFINITY).unwrap();
            assert!(walled.value(&x, value).is_some() && walled.value(&x, value - 1e-9).is_none());
            assert_eq!(prepared.scaled(&prepared.joints(&x)).len(), x.len());
            assert!(walled.value(&[5.0; 7], f64::INFINITY).is_none());
        }
    }
}
