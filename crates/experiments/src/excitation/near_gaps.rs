//! Linearises distances of bodies near their bounds in the coefficients of a motion. The result is used for the Hessian of the
//! distance barrier and for the greatest step of a descent.
//!
//! b: row of the basis functions at an instant. g: gradient of a distance by the coordinates. w'': second derivative of the
//! barrier by the distance. The Hessian is the sum over the distances of w'' (g x b)(g x b)', x the Kronecker product, without
//! the second derivatives of the distances. The distances of one instant share b, so their terms in g are added first. Without
//! this Hessian the line search halves every step when bodies are near each other.

use nalgebra::{Cholesky, DMatrix};
use numerics::information_matrix::add_products;

use crate::excitation::barrier::Curvature;

/// Share of the distance to its bound that one step of the minimizer may use; the kinematic barrier uses the same value.
const STEP_TO_BOUND_SHARE: f64 = 0.99;

/// A pair of bodies (gap) near its bound at one instant.
pub(crate) struct EnforcedGap {
    /// Index of the instant among the instants of the distance barrier.
    pub instant: usize,
    /// Distance of the bodies minus its bound, minus the reserve (additional distance that a search keeps), m.
    pub room: f64,
    /// Second derivative of the distance barrier by this distance, 1/m^2.
    pub bend: f64,
}

/// The pairs of bodies near their bounds along a motion, in the order of the instants.
#[derive(Default)]
pub(crate) struct NearGaps {
    held: Vec<EnforcedGap>,
    /// Gradient of the distance of each gap by the n coordinates, m/rad (m/m); n entries per gap.
    slopes: Vec<f64>,
}

impl NearGaps {
    /// Adds a pair of bodies near its bound. `room`: distance minus bound and reserve; `bend`: second derivative of the barrier;
    /// `slope`: gradient of the distance. `instant` must not be before the instant of the pair added last.
    pub(crate) fn push(&mut self, instant: usize, room: f64, bend: f64, slope: &[f64]) {
        self.held.push(EnforcedGap { instant, room, bend });
        self.slopes.extend_from_slice(slope);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.held.is_empty()
    }

    /// Each pair of bodies (gap) with the gradient of its distance by the coordinates.
    pub(crate) fn rooms(&self) -> impl Iterator<Item = (&EnforcedGap, &[f64])> {
        self.held.iter().zip(self.slopes.chunks_exact(self.slopes.len() / self.held.len().max(1)))
    }

    /// The greatest step along `direction` (of the coefficients) after which the distance of every gap still exceeds its bound
    /// plus reserve by 1 % of the present excess, in linear approximation.
    pub(crate) fn greatest_step(&self, basis: &Basis, direction: &[f64]) -> f64 {
        let mut step = f64::INFINITY;
        let (mut seen, mut rates) = (usize::MAX, vec![]);
        for (held, slope) in self.rooms() {
            if seen != held.instant {
                (seen, rates) = (held.instant, basis.rates(direction, held.instant));
            }
            let opening: f64 = basis.moving.iter().zip(&rates).map(|(&k, rate)| slope[k] * rate).sum();
            if opening < 0.0 {
                step = step.min(-STEP_TO_BOUND_SHARE * held.room / opening);
            }
        }
        step
    }

    /// Factors the sum of the Hessians of the kinematic barrier (`kinematic`, one block per joint) and of the distance barrier.
    /// `None` if the factorisation fails.
    pub(crate) fn curvature(&self, basis: &Basis, kinematic: &[DMatrix<f64>]) -> Option<Curvature> {
        let (m, size) = (basis.m(), basis.scale.len());
        let mut whole = DMatrix::zeros(size, size);
        for (j, block) in kinematic.iter().enumerate() {
            whole.view_mut((j * m, j * m), (m, m)).copy_from(block);
        }
        let mut instants: Vec<usize> = self.held.iter().map(|held| held.instant).collect();
        instants.dedup();
        let rows: Vec<f64> = instants.iter().flat_map(|&i| &basis.rows[i]).copied().collect();
        for (j, &of_j) in basis.moving.iter().enumerate() {
            for (k, &of_k) in basis.moving.iter().enumerate().take(j + 1) {
                let mut weights = vec![0.0; instants.len()];
                let mut at = 0;
                for (held, slope) in self.rooms() {
                    at += usize::from(instants[at] != held.instant);
                    weights[at] += held.bend * slope[of_j] * slope[of_k];
                }
                // Most distances depend on few joints, so the blocks of most pairs of joints are zero.
                if weights.iter().all(|weight| *weight == 0.0) {
                    continue;
                }
                let mut products = vec![0.0; m * m];
                add_products(&mut products, m, &rows, |i| weights[i]);
                for (a, c) in (0..m).flat_map(|a| (0..m).map(move |c| (a, c))) {
                    let (row, column) = (j * m + a, k * m + c);
                    whole[(row, column)] += basis.scale[row] * basis.scale[column] * products[a.max(c) * m + a.min(c)];
                }
            }
        }
        // Only the lower triangle of the Hessian is filled, because the factorisation reads no other entry.
        Cholesky::new(whole).map(Curvature::of_all)
    }
}

/// The map from the scaled coefficients of a motion to the positions. Coefficients are ordered joint after joint.
pub(crate) struct Basis<'a> {
    /// The row of the basis functions at each instant.
    pub rows: &'a [Vec<f64>],
    /// Indices of the coordinates that move.
    pub moving: &'a [usize],
    /// Unit of each coefficient: factor from scaled to unscaled coefficients.
    pub scale: &'a [f64],
}

impl Basis<'_> {
    /// Number of coefficients of each coordinate.
    fn m(&self) -> usize {
        self.scale.len() / self.moving.len().max(1)
    }

    /// Change of each moving coordinate at an instant, per unit step of the scaled coefficients along `direction`.
    fn rates(&self, direction: &[f64], instant: usize) -> Vec<f64> {
        let (row, m) = (&self.rows[instant], self.m());
        let of_joint = |(x, scale): (&[f64], &[f64])| row.iter().zip(x).zip(scale).map(|((b, x), s)| b * x * s).sum();
        direction.chunks_exact(m).zip(self.scale.chunks_exact(m)).map(of_joint).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(k: usize, m: f64) -> f64 {
        (m * k as f64).sin()
    }

    /// Basis rows for five instants and three coefficients per coordinate.
    fn rows() -> Vec<Vec<f64>> {
        (0..5).map(|i| vec![1.0, wave(i, 1.1), wave(i + 3, 2.3)]).collect()
    }

    /// Two pairs of bodies at one instant and two at another; no moving joint changes the last distance.
    fn near() -> NearGaps {
        let mut near = NearGaps::default();
        near.push(1, 0.03, 4.0, &[0.3, 9.0, -0.2]);
        near.push(1, 0.002, 250.0, &[0.0, 9.0, 0.4]);
        near.push(4, 0.01, 30.0, &[-0.5, 9.0, 0.1]);
        near.push(4, 0.001, 90.0, &[0.0, 9.0, 0.0]);
        near
    }

    const SCALE: [f64; 6] = [1.0, 0.8, 0.6, 2.0, 0.5, 0.7];

    /// The gradient of a distance by all scaled coefficients.
    fn along_coefficients(basis: &Basis, held: &EnforcedGap, slope: &[f64]) -> Vec<f64> {
        let row = &basis.rows[held.instant];
        (0..6).map(|at| slope[basis.moving[at / 3]] * row[at % 3] * basis.scale[at]).collect()
    }

    /// Checks that the sum of the Hessians times the solution equals the right-hand side.
    #[test]
    fn the_curvature_is_the_sum() {
        let (rows, near) = (rows(), near());
        let basis = Basis { rows: &rows, moving: &[0, 2], scale: &SCALE };
        let kinematic = [2.0, 3.0].map(|d| DMatrix::from_fn(3, 3, |i, j| if i == j { d } else { 0.2 }));
        let right: Vec<f64> = (0..6).map(|k| wave(k, 0.9) + 0.5).collect();
        let mut found = right.clone();
        near.curvature(&basis, &kinematic).unwrap().solve(&mut found);
        let mut product: Vec<f64> =
            (0..6).map(|row| (0..3).map(|c| kinematic[row / 3][(row % 3, c)] * found[row / 3 * 3 + c]).sum()).collect();
        for (held, slope) in near.rooms() {
            let slope = along_coefficients(&basis, held, slope);
            let along: f64 = slope.iter().zip(&found).map(|(g, x)| g * x).sum();
            product.iter_mut().zip(&slope).for_each(|(p, g)| *p += held.bend * along * g);
        }
        for (a, b) in product.iter().zip(&right) {
            // Tolerance: rounding of a system of six equations whose second derivatives differ by a factor of a hundred.
            assert!((a - b).abs() < 1e-12, "{product:?} {right:?}");
        }
    }

    #[test]
    fn a_step_ends_before_the_first_bound() {
        let (rows, near) = (rows(), near());
        let basis = Basis { rows: &rows, moving: &[0, 2], scale: &SCALE };
        let direction: Vec<f64> = (0..6).map(|k| -wave(k, 2.1)).collect();
        let step = near.greatest_step(&basis, &direction);
        let left = near.rooms().map(|(held, slope)| {
            let along = along_coefficients(&basis, held, slope);
            1.0 + step * along.iter().zip(&direction).map(|(g, d)| g * d).sum::<f64>() / held.room
        });
        let least = left.fold(f64::INFINITY, f64::min);
        assert!((least - 0.01).abs() < 1e-12, "{least}");
    }
}
