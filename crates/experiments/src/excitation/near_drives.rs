//! The torques and powers that come near their bounds, linear in the coefficients: what the wall of torques adds to the
//! curvature of a descent, and how far a step may go.
//!
//! With B the curvature of the kinematic wall, block by block, G the slopes of the K nearest quantities v along the
//! coefficients and D = diag(weight (1 / (u - v)^2 + 1 / (u + v)^2)), the curvature is B + G' D G, up to what v bends by
//! itself. Its inverse is B^-1 - Y' (D^-1 + G Y')^-1 Y, Y = G B^-1 [Golub, Van Loan 2013, 2.1.4]. Without it a
//! chain of thirty joints, whose efforts bind first, halves each step three to fifteen times.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::excitation::barrier::Curvature;
use crate::excitation::problem::Prepared;
use crate::excitation::torque_wall::{HeldDrive, TorqueWall};

/// Share of its bound from which a quantity may count.
const NEAR_SHARE: f64 = 0.7;
/// Curvature along a scaled coefficient that is little beside that of the criterion.
const NEGLIGIBLE_CURVATURE: f64 = 1e-3;
/// Share of the room along a step that may be used of a quantity, as of the rows of the kinematic wall.
const ROOM_SHARE_OF_STEP: f64 = 0.99;

/// Quantities near their bounds at a motion x, with their slopes.
#[derive(Clone)]
pub(crate) struct NearDrives {
    held: Vec<HeldDrive>,
    /// K x N, row by row.
    slopes: Vec<f64>,
    /// N.
    width: usize,
}

impl NearDrives {
    /// Those of the greatest share of their bounds, at most as many as the criterion has instants.
    pub(crate) fn new(prepared: &Prepared, height: f64, states: &[f64], rigid: &[f64]) -> NearDrives {
        let problem = prepared.problem;
        // At low walls only the nearest bend them: where (room / bound)^2 is at most the weight over a small curvature.
        let weight = height / problem.samples.max(1) as f64;
        let least_share = (1.0 - (weight / NEGLIGIBLE_CURVATURE).sqrt()).max(NEAR_SHARE);
        let near = |wall: &TorqueWall| wall.near(problem.limits, states, rigid, prepared.reliefs(), least_share);
        let mut held = problem.torque.map_or(vec![], near);
        // Those with raised bounds first, whose walls are the steepest; equal ones in the order of the instants.
        let rank = |held: &HeldDrive| (held.relief > 1.0, held.share());
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

    /// The greatest step along a direction that keeps a hundredth of the room of every quantity, were it linear.
    pub(crate) fn greatest_step(&self, direction: &[f64]) -> f64 {
        let of = |(held, row): (&HeldDrive, &[f64])| {
            let rate = dot(row, direction);
            let room = if rate > 0.0 { held.bound - held.value } else { held.bound + held.value };
            if rate == 0.0 { f64::INFINITY } else { ROOM_SHARE_OF_STEP * room / rate.abs() }
        };
        self.held.iter().zip(self.rows()).map(of).fold(f64::INFINITY, f64::min)
    }

    /// The curvature of the kinematic wall together with that of the torques of this weight.
    pub(crate) fn curvature(&self, kinematic: &Curvature, weight: impl Fn(f64) -> f64) -> Option<RaisedCurvature> {
        let bend = |held: &HeldDrive| {
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

/// A curvature of the kinematic wall, raised by K rows.
pub(crate) struct RaisedCurvature {
    /// Y, K x N.
    solved: Vec<f64>,
    width: usize,
    /// The factor of D^-1 + G Y'.
    inner: Cholesky<f64, Dyn>,
}

impl RaisedCurvature {
    /// Solves in place.
    pub(crate) fn solve(&self, kinematic: &Curvature, x: &mut [f64]) {
        let along = self.solved.chunks_exact(self.width).map(|row| -dot(row, x)).collect();
        kinematic.solve(x);
        let shares = self.inner.solve(&DVector::from_vec(along));
        for (row, share) in self.solved.chunks_exact(self.width).zip(shares.iter()) {
            x.iter_mut().zip(row).for_each(|(x, y)| *x += share * y);
        }
    }
}

/// In four sums, so that none waits for the other.
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
        let held = |value: f64, relief: f64| HeldDrive {
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

    /// What the raised curvature solves, times B + G' D G, is the right-hand side.
    #[test]
    fn the_raised_curvature_is_the_sum() {
        let (near, x) = (near(), [0.1, 0.1, -0.2, 0.05, 0.1, 0.3, -0.1, 0.0, 0.1, 0.02]);
        let kinematic = Curvature::of_joints(barrier().bends(&x, 1.0, 0.0, 1)).unwrap();
        let weight = |relief: f64| 0.3 * relief;
        let mut found: Vec<f64> = (0..10).map(|k| 1.0 - 0.2 * f64::from(k)).collect();
        let right = found.clone();
        near.curvature(&kinematic, weight).unwrap().solve(&kinematic, &mut found);
        // B^-1 (right - G' D G found) is found again.
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
