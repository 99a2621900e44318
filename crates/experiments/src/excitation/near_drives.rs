//! Linearises torques and powers near their bounds in the coefficients of a motion. The result is used for the Hessian of the
//! torque barrier and for the greatest step of a descent.
//!
//! B: Hessian of the kinematic barrier, block by block. v: the K torques and powers nearest to their bounds u. G: their gradients
//! by the N coefficients. D = diag(weight (1 / (u - v)^2 + 1 / (u + v)^2)). The Hessian is B + G' D G, without the second
//! derivatives of v. Its inverse is B^-1 - Y' (D^-1 + G Y')^-1 Y, Y = G B^-1 [Golub, Van Loan 2013, 2.1.4]. Without the term G' D
//! G, the line search for a chain of thirty joints near their effort limits halves each step three to fifteen times.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::excitation::barrier::Curvature;
use crate::excitation::problem::Prepared;
use crate::excitation::torque_barrier::{EnforcedDrive, TorqueBarrier};

/// A torque or power is linearised only if it is above this share of its bound.
const NEAR_SHARE: f64 = 0.7;
/// If the curvature of the torque barrier by a scaled coefficient is below this value, it is negligible compared with the
/// criterion. Then the barrier term is left out.
const NEGLIGIBLE_CURVATURE: f64 = 1e-3;
/// Share of the distance to a torque or power bound that one step may use; the kinematic barrier uses the same value.
const STEP_TO_BOUND_SHARE: f64 = 0.99;

/// Torques and powers near their bounds for one motion, with their gradients by its coefficients.
#[derive(Clone)]
pub(crate) struct NearDrives {
    held: Vec<EnforcedDrive>,
    /// Gradients G of the K torques and powers by the N coefficients of the motion, K x N, row by row.
    slopes: Vec<f64>,
    /// Number N of coefficients of the motion.
    width: usize,
}

impl NearDrives {
    /// Selects the torques and powers nearest to their bounds, at most as many as the criterion has instants. `height`: weight of
    /// the barriers; `states` and `rigid`: states and torques at all instants.
    pub(crate) fn new(prepared: &Prepared, height: f64, states: &[f64], rigid: &[f64]) -> NearDrives {
        let problem = prepared.problem;
        // With a low weight, only quantities very near their bounds matter: (distance / bound)^2 at most weight / negligible
        // curvature.
        let weight = height / problem.samples.max(1) as f64;
        let least_share = (1.0 - (weight / NEGLIGIBLE_CURVATURE).sqrt()).max(NEAR_SHARE);
        let near = |wall: &TorqueBarrier| wall.near(problem.limits, states, rigid, prepared.reliefs(), least_share);
        let mut held = problem.torque.map_or(vec![], near);
        // Torques and powers with temporarily raised bounds come first, because their barriers are the steepest. Equal ones stay
        // in the order of the instants.
        let rank = |held: &EnforcedDrive| (held.relief > 1.0, held.share());
        held.sort_by(|a, b| rank(b).0.cmp(&rank(a).0).then(rank(b).1.total_cmp(&rank(a).1)));
        held.truncate(problem.samples);
        let slopes = prepared.drive_slopes(states, &held);
        NearDrives { width: prepared.size(), held, slopes }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.held.is_empty()
    }

    fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.slopes.chunks_exact(self.width.max(1))
    }

    /// The greatest step along `direction` after which every torque and power still has 1 % of its distance to its bound, in
    /// linear approximation.
    pub(crate) fn greatest_step(&self, direction: &[f64]) -> f64 {
        let of = |(held, row): (&EnforcedDrive, &[f64])| {
            let rate = dot(row, direction);
            let room = if rate > 0.0 { held.bound - held.value } else { held.bound + held.value };
            if rate == 0.0 { f64::INFINITY } else { STEP_TO_BOUND_SHARE * room / rate.abs() }
        };
        self.held.iter().zip(self.rows()).map(of).fold(f64::INFINITY, f64::min)
    }

    /// Factors the sum of the Hessians of the kinematic barrier and of the torque barrier. `weight` computes the weight of the
    /// torque barrier from the factor that raises a bound. `None` if the factorisation fails.
    pub(crate) fn curvature(&self, kinematic: &Curvature, weight: impl Fn(f64) -> f64) -> Option<RaisedCurvature> {
        let bend = |held: &EnforcedDrive| {
            weight(held.relief) * ((held.bound - held.value).powi(-2) + (held.bound + held.value).powi(-2))
        };
        let mut solved = self.slopes.clone();
        solved.chunks_exact_mut(self.width.max(1)).for_each(|row| kinematic.solve(row));
        let k = self.held.len();
        let mut inner = DMatrix::zeros(k, k);
        for (i, (row, held)) in self.rows().zip(&self.held).enumerate() {
            for (j, solved) in solved.chunks_exact(self.width).enumerate().take(i + 1) {
                inner[(i, j)] = dot(row, solved);
                inner[(j, i)] = inner[(i, j)];
            }
            inner[(i, i)] += bend(held).recip();
        }
        Some(RaisedCurvature { solved, width: self.width, inner: Cholesky::new(inner)? })
    }
}

/// The Hessian of kinematic and torque barrier, factored: B + G' D G. B: Hessian of the kinematic barrier; G' D G: update of rank
/// K by the K torques and powers near their bounds.
pub(crate) struct RaisedCurvature {
    /// Y = G B^-1, K x N. G: gradients of the K torques and powers by the N coefficients; B: Hessian of the kinematic barrier.
    solved: Vec<f64>,
    width: usize,
    /// The Cholesky factor of the K x K matrix D^-1 + G Y'; D: weights of the K torques and powers in the Hessian.
    inner: Cholesky<f64, Dyn>,
}

impl RaisedCurvature {
    /// Solves (B + G' D G) y = x, with the Hessian of both barriers, by the matrix inversion lemma; y replaces x. `kinematic`:
    /// the factored B.
    pub(crate) fn solve(&self, kinematic: &Curvature, x: &mut [f64]) {
        let along = self.solved.chunks_exact(self.width).map(|row| -dot(row, x)).collect();
        kinematic.solve(x);
        let shares = self.inner.solve(&DVector::from_vec(along));
        for (row, share) in self.solved.chunks_exact(self.width).zip(shares.iter()) {
            x.iter_mut().zip(row).for_each(|(x, y)| *x += share * y);
        }
    }
}

/// Dot product of two vectors in four independent sums, for instruction-level parallelism.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (fours, rest) = a.as_chunks::<4>();
    let (others, other_rest) = b.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (a, b) in fours.iter().zip(others) {
        for l in 0..4 {
            sums[l] += a[l] * b[l];
        }
    }
    let rest: f64 = rest.iter().zip(other_rest).map(|(a, b)| a * b).sum();
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::barrier::tests::barrier;
    use crate::excitation::limit_kind::LimitKind;

    fn near() -> NearDrives {
        let held = |value: f64, relief: f64| EnforcedDrive {
            instant: 0,
            coordinate: 0,
            limit: LimitKind::Effort,
            value,
            bound: 2.0,
            relief,
            along: [0.0; 2],
        };
        let slopes = (0..30).map(|k| (0.7 * f64::from(k * k)).sin()).collect();
        NearDrives { held: vec![held(1.9, 1.0), held(-1.5, 1.2), held(1.0, 1.0)], slopes, width: 10 }
    }

    /// Checks the solution: the Hessian B + G' D G times the solution must equal the right-hand side.
    #[test]
    fn the_raised_curvature_is_the_sum() {
        let (near, x) = (near(), [0.1, 0.1, -0.2, 0.05, 0.1, 0.3, -0.1, 0.0, 0.1, 0.02]);
        let kinematic = Curvature::of_joints(barrier().bends(&x, 1.0, 0.0, 1)).unwrap();
        let weight = |relief: f64| 0.3 * relief;
        let mut found: Vec<f64> = (0..10).map(|k| 1.0 - 0.2 * f64::from(k)).collect();
        let right = found.clone();
        near.curvature(&kinematic, weight).unwrap().solve(&kinematic, &mut found);
        // Equivalent check: B^-1 (right - G' D G found) must equal the solution `found`.
        let mut rest = right.clone();
        for (held, row) in near.held.iter().zip(near.rows()) {
            let bend = (held.bound - held.value).powi(-2) + (held.bound + held.value).powi(-2);
            let along = weight(held.relief) * bend * dot(row, &found);
            rest.iter_mut().zip(row).for_each(|(x, g)| *x -= along * g);
        }
        kinematic.solve(&mut rest);
        let largest = found.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        for (a, b) in rest.iter().zip(&found) {
            assert!((a - b).abs() < 1e-10 * largest, "{a} {b}");
        }
    }

    #[test]
    fn a_step_ends_before_the_first_bound() {
        let near = near();
        let direction: Vec<f64> = (0..10).map(|k| 0.1 * f64::from(k) - 0.3).collect();
        let step = near.greatest_step(&direction);
        let left = near.held.iter().zip(near.rows()).map(|(held, row)| {
            let rate = dot(row, &direction);
            let room = if rate > 0.0 { held.bound - held.value } else { held.bound + held.value };
            1.0 - step * rate.abs() / room
        });
        let least = left.fold(f64::INFINITY, f64::min);
        assert!((least - 0.01).abs() < 1e-12, "{least}");
    }
}
