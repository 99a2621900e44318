//! The objective of the search (criterion plus barriers) as a function of the motion's coefficients, with an exact gradient.
//!
//! f(x) = J(W(x)) + mu (B(x) + S(x) + T(x)): J is the criterion of the rows W at the instants of a period
//! ([`crate::excitation::criterion`]), B the barrier of the kinematic limits ([`crate::excitation::barrier`]), S the barrier of
//! the distances between bodies ([`crate::excitation::distance_barrier`]), T the barrier of torques and powers at the instants of
//! the period and the blends ([`crate::excitation::torque_barrier`]). mu is the weight of the barriers.
//!
//! One pass in reverse mode through the regressor Y gives the derivatives of J and T by the states (q, dq, ddq). They are exact,
//! because the derivatives of Y by the states are exact.

use std::cell::RefCell;

use crate::excitation::barrier::Curvature;
use crate::excitation::descent::Objective;
use crate::excitation::distance_barrier::Seen;
use crate::excitation::near_drives::NearDrives;
use crate::excitation::near_gaps::{Basis, NearGaps};
use crate::excitation::problem::Prepared;
use crate::excitation::rows::RegressorRows;

/// Approximate second derivative of the criterion J by a scaled coefficient. It is added to the Hessian of the barriers.
const CRITERION_CURVATURE: f64 = 0.1;

/// Weight of the torque barrier at instants with temporarily raised bounds. It is high enough that torques decrease to some
/// hundredths below their raised bounds.
const RELIEVED_WEIGHT: f64 = 10.0;
/// The weight of the torque barrier at instants with raised bounds, if the other barriers have low weights. At low weights a
/// motion hardly moves, and a higher weight of this barrier would only make it oscillate.
const RELIEVED_WEIGHT_AMONG_LOW_BARRIERS: f64 = 0.2;

/// Least weight of the barriers at which a descent can bring back torques that are far above their bounds.
pub(crate) const RETURN_HEIGHT: f64 = 1e-2;

/// The objective f = J + mu (sum of barriers) of a search, for one weight mu of the barriers. J: optimality criterion.
pub struct WithBarriers<'a> {
    /// The search problem with the precomputed data that all starts share.
    pub prepared: &'a Prepared<'a>,
    /// The weight mu of the barriers.
    pub height: f64,
    /// Intermediate results of earlier distance evaluations of this start.
    pub seen: &'a Seen,
    last: RefCell<Option<Last>>,
}

/// Data of the last evaluated motion. `None` in `WithBarriers`: no motion inside all barriers was evaluated yet.
struct Last {
    x: Vec<f64>,
    states: Vec<f64>,
    /// Torque of each coordinate without friction, N m (N), instant after instant.
    rigid: Vec<f64>,
    /// Pairs of bodies whose distance is in the range of the distance barrier.
    gaps: NearGaps,
    /// Torques and powers near their bounds. `None`: not yet computed.
    near: Option<NearDrives>,
}

impl<'a> WithBarriers<'a> {
    /// Makes the objective with barriers of weight mu = `height`.
    pub fn new(prepared: &'a Prepared<'a>, height: f64, seen: &'a Seen) -> WithBarriers<'a> {
        WithBarriers { prepared, height, seen, last: RefCell::new(None) }
    }

    /// Applies `of` to the torques and powers near their bounds, for the motion with the scaled coefficients x. `None` if there
    /// are none.
    fn with_near<T>(&self, x: &[f64], of: impl FnOnce(&NearDrives) -> T) -> Option<T> {
        self.prepared.problem.torque?;
        let mut last = self.last.borrow_mut();
        if last.as_ref().is_none_or(|last| last.x != x) {
            let (states, rigid) = self.prepared.states_and_torques(x);
            *last = Some(Last { x: x.to_vec(), states, rigid, gaps: NearGaps::default(), near: None });
        }
        let Last { states, rigid, near, .. } = last.as_mut()?;
        let near = near.get_or_insert_with(|| NearDrives::new(self.prepared, self.height, states, rigid));
        (!near.is_empty()).then(|| of(near))
    }

    /// Applies `of` to the pairs of bodies near their distance bounds, for the motion with the scaled coefficients x. `None` if
    /// no pair is near.
    fn with_gaps<T>(&self, x: &[f64], of: impl FnOnce(&Basis, &NearGaps) -> T) -> Option<T> {
        let (prepared, last) = (self.prepared, self.last.borrow());
        let rows = prepared.space.as_ref()?.rows();
        let basis = Basis { rows, moving: prepared.moving(), scale: prepared.scale() };
        last.as_ref().filter(|last| last.x == x && !last.gaps.is_empty()).map(|last| of(&basis, &last.gaps))
    }

    /// Weight of the torque barrier at an instant whose bounds are raised by the factor `relief`; 1: not raised.
    fn torque_weight(&self, relief: f64) -> f64 {
        let height = match (relief > 1.0, self.height >= RETURN_HEIGHT) {
            (false, _) => self.height,
            (true, true) => RELIEVED_WEIGHT,
            (true, false) => RELIEVED_WEIGHT_AMONG_LOW_BARRIERS,
        };
        height / self.prepared.problem.samples as f64
    }

    fn evaluate(&self, x: &[f64], at_most: f64) -> Option<(f64, Vec<f64>)> {
        let (prepared, problem, height) = (self.prepared, self.prepared.problem, self.height);
        let mut gradient = vec![0.0; x.len()];
        let mut value = height * prepared.barrier().value(x, height, &mut gradient, prepared.threads)?;
        let (n, moving) = (problem.limits.len(), prepared.moving());
        let (states, rigid) = prepared.states_and_torques(x);
        let of_torque = match problem.torque {
            Some(wall) => {
                let weight = |relief| self.torque_weight(relief);
                let (of_torque, slopes) = wall.value(problem.limits, weight, (&states, &rigid), prepared.reliefs())?;
                value += of_torque;
                slopes
            }
            None => vec![],
        };

        // Add the optimality criterion J.
        let RegressorRows { of_joints, friction } = prepared.rows(&states, &prepared.filled(&states)?);
        let found = prepared.criterion_of_rows(of_joints)?;
        value += found.value;
        // The distance barrier comes last, because it takes half of the time and can only increase the value.
        if !(value.is_finite() && value <= at_most) {
            return None;
        }
        let mut gaps = NearGaps::default();
        if let Some(space) = &prepared.space {
            value += space.value(
                self.seen,
                &|row| prepared.positions(x, row),
                height,
                at_most - value,
                &mut gaps,
                &mut |row, slope| {
                    moving.iter().enumerate().for_each(|(j, &k)| prepared.add_slope(j, row, slope[k], &mut gradient));
                },
            )?;
        }

        // Reverse mode: the derivatives by torques and by regressor rows give the derivatives by the states, and these give the
        // gradient by the coefficients.
        let along_torques: Vec<f64> = of_torque.iter().map(|[along_tau, _]| *along_tau).collect();
        let mut through = prepared.torques_pulled_back(&states, &along_torques);
        for (at, [_, along_dq]) in of_torque.iter().enumerate() {
            through[at / n * 3 * n + n + at % n] += along_dq;
        }
        let of_rows = prepared.rows_pulled_back(&states, &RegressorRows { of_joints: found.slope(), friction });
        through.iter_mut().zip(&of_rows).for_each(|(x, of_rows)| *x += of_rows);
        for (rows, of_state) in prepared.instants.iter().zip(through.chunks_exact(3 * n)) {
            prepared.add_slopes(rows, of_state, &mut gradient);
        }
        *self.last.borrow_mut() = Some(Last { x: x.to_vec(), states, rigid, gaps, near: None });
        Some((value, gradient))
    }

    fn curvature(&self, x: &[f64]) -> Option<Curvature> {
        let bends = self.prepared.barrier().bends(x, self.height, CRITERION_CURVATURE, self.prepared.threads);
        match self.with_gaps(x, |basis, gaps| gaps.curvature(basis, &bends)) {
            Some(whole) => whole,
            None => Curvature::of_joints(bends),
        }
    }
}

impl Objective for WithBarriers<'_> {
    fn value(&self, x: &[f64], at_most: f64) -> Option<(f64, Vec<f64>)> {
        self.evaluate(x, at_most)
    }

    fn precondition(&self, x: &[f64], direction: &mut [f64]) {
        // Inside the barriers the Hessian is positive definite. If rounding prevents its factorisation, the direction stays the
        // negative gradient.
        let Some(curvature) = self.curvature(x) else { return };
        let weight = |relief| self.torque_weight(relief);
        let raised = self.with_near(x, |near| near.curvature(&curvature, weight)).flatten();
        match raised {
            Some(raised) => raised.solve(&curvature, direction),
            None => curvature.solve(direction),
        }
    }

    fn greatest_step(&self, x: &[f64], direction: &[f64]) -> f64 {
        let of_torques = self.with_near(x, |near| near.greatest_step(direction));
        let of_gaps = self.with_gaps(x, |basis, gaps| gaps.greatest_step(basis, direction));
        let others = [of_torques, of_gaps].into_iter().flatten();
        others.fold(self.prepared.barrier().step(x, direction), f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::criterion::SearchObjective;
    use crate::excitation::fourier_series::FourierSeries;
    use crate::excitation::gap_proof::tests::Rod;
    use crate::excitation::limits::CoordinateLimits;
    use crate::excitation::motion::MotionShape;
    use crate::excitation::problem::Problem;
    use crate::excitation::quintic_spline::QuinticSpline;
    use crate::excitation::search::tests::{pendulum_limits, pendulum_torque};
    use crate::pendulum::Pendulum;
    use linear_model::friction::terms::FrictionTerm;

    #[test]
    fn the_gradient_is_exact() {
        let (arm, wall) = (Pendulum::new(), pendulum_torque());
        let limits = [CoordinateLimits { power: Some(12.0), ..pendulum_limits() }];
        // The least distance to the wall at 0.55 is less than 0.05 m, so the distance barrier acts.
        let rod = Rod::new(0.55);
        let series = MotionShape::Fourier(FourierSeries { period: 5.0, blend: 1.0, harmonics: 3 });
        let spline = MotionShape::Spline(QuinticSpline { period: 5.0, spans: 7 });
        let (of_series, of_spline) = ([0.1, 0.15, -0.1, 0.1, 0.2, 0.05, -0.1], [0.1, 0.2, -0.2, 0.2, -0.1, 0.2, 0.1]);
        let all = [SearchObjective::Determinant, SearchObjective::Condition];
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
            let barriers = WithBarriers::new(&prepared, 0.01, &seen);
            let (_, gradient) = barriers.value(&x, f64::INFINITY).unwrap();
            // Three threads share 50 instants as 24, 24 and 2; the gradient must be the same, bit for bit.
            let (shared, fresh) = (Prepared::new(&problem).with_threads(3), Seen::default());
            assert_eq!(WithBarriers::new(&shared, 0.01, &fresh).value(&x, f64::INFINITY).unwrap().1, gradient);
            for k in 0..x.len() {
                let h = 1e-6;
                let moved = |h: f64| {
                    let mut x = x;
                    x[k] += h;
                    barriers.value(&x, f64::INFINITY).unwrap().0
                };
                let (found, slope) = (gradient[k], (moved(h) - moved(-h)) / (2.0 * h));
                // Errors of the central differences: rounding, 1e-16 / 1e-6, and h^2 times the third derivative of the smooth
                // sign.
                let allowed = 1e-6 * (1.0 + slope.abs());
                assert!((found - slope).abs() < allowed, "{aim:?} {shape:?} {k}: {found} {slope}");
            }
            let (value, _) = barriers.value(&x, f64::INFINITY).unwrap();
            assert!(barriers.value(&x, value + 1e-12).is_some() && barriers.value(&x, value - 1e-9).is_none());
            assert_eq!(prepared.scaled(&prepared.joints(&x)).len(), x.len());
            assert!(barriers.value(&[5.0; 7], f64::INFINITY).is_none());
        }
    }
}
