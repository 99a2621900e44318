//! The gaps that are felt at a motion, linear in the coefficients: what the wall of distances adds to the curvature of a
//! descent, and how far a step may go.
//!
//! With b the row of the basis at an instant, g the slope of a room along the coordinates and w'' the bend of the wall
//! along the room, the curvature is the sum over the rooms of w'' (g x b)(g x b)', x the product of Kronecker, up to what
//! rooms bend by themselves. The rooms of one instant share b, so their g are added up first. Without it a descent whose
//! bodies are near each other halves every step.

use nalgebra::{Cholesky, DMatrix};
use numerics::information_matrix::add_products;

use crate::excitation::barrier::Curvature;

/// Share of a room along a step that may be used, as of the rows of the kinematic wall.
const ROOM_SHARE_OF_STEP: f64 = 0.99;

/// A room that is felt.
pub(crate) struct HeldGap {
    /// Index of its instant.
    pub instant: usize,
    /// Above its reserve, m.
    pub room: f64,
    /// Second derivative of the wall by the room, 1/m^2.
    pub bend: f64,
}

/// The rooms that are felt at a motion, instant after instant.
#[derive(Default)]
pub(crate) struct NearGaps {
    held: Vec<HeldGap>,
    /// Slope of each room along the n coordinates, room after room, m/rad (m/m).
    slopes: Vec<f64>,
}

impl NearGaps {
    /// Adds a room at an instant that is not before the last one.
    pub(crate) fn push(&mut self, instant: usize, room: f64, bend: f64, slope: &[f64]) {
        self.held.push(HeldGap { instant, room, bend });
        self.slopes.extend_from_slice(slope);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.held.is_empty()
    }

    /// Each room with its slope.
    pub(crate) fn rooms(&self) -> impl Iterator<Item = (&HeldGap, &[f64])> {
        self.held.iter().zip(self.slopes.chunks_exact(self.slopes.len() / self.held.len().max(1)))
    }

    /// The greatest step along a direction of the coefficients that keeps a hundredth of every room, were it linear.
    pub(crate) fn greatest_step(&self, basis: &Basis, direction: &[f64]) -> f64 {
        let mut step = f64::INFINITY;
        let (mut seen, mut rates) = (usize::MAX, vec![]);
        for (held, slope) in self.rooms() {
            if seen != held.instant {
                (seen, rates) = (held.instant, basis.rates(direction, held.instant));
            }
            let opening: f64 = basis.moving.iter().zip(&rates).map(|(&k, rate)| slope[k] * rate).sum();
            if opening < 0.0 {
                step = step.min(-ROOM_SHARE_OF_STEP * held.room / opening);
            }
        }
        step
    }

    /// The curvature of the kinematic wall, joint by joint, together with that of the rooms.
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
                // Most rooms turn with few joints.
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
        // Of the lower triangle alone.
        Cholesky::new(whole).map(Curvature::of_all)
    }
}

/// How positions follow from the scaled coefficients, joint after joint.
pub(crate) struct Basis<'a> {
    /// The row of the basis at each instant.
    pub rows: &'a [Vec<f64>],
    /// Coordinates that move.
    pub moving: &'a [usize],
    /// Unit of each coefficient.
    pub scale: &'a [f64],
}

impl Basis<'_> {
    /// Coefficients of a coordinate.
    fn m(&self) -> usize {
        self.scale.len() / self.moving.len().max(1)
    }

    /// How fast the coordinates that move change along a direction of the coefficients, at an instant.
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

    /// Three coordinates of which the second is locked, three coefficients each, five instants.
    fn rows() -> Vec<Vec<f64>> {
        (0..5).map(|i| vec![1.0, wave(i, 1.1), wave(i + 3, 2.3)]).collect()
    }

    /// Two rooms at one instant, one at another, one that nothing turns.
    fn near() -> NearGaps {
        let mut near = NearGaps::default();
        near.push(1, 0.03, 4.0, &[0.3, 9.0, -0.2]);
        near.push(1, 0.002, 250.0, &[0.0, 9.0, 0.4]);
        near.push(4, 0.01, 30.0, &[-0.5, 9.0, 0.1]);
        near.push(4, 0.001, 90.0, &[0.0, 9.0, 0.0]);
        near
    }

    const SCALE: [f64; 6] = [1.0, 0.8, 0.6, 2.0, 0.5, 0.7];

    /// The slope of a room along the coefficients.
    fn along_coefficients(basis: &Basis, held: &HeldGap, slope: &[f64]) -> Vec<f64> {
        let row = &basis.rows[held.instant];
        (0..6).map(|at| slope[basis.moving[at / 3]] * row[at % 3] * basis.scale[at]).collect()
    }

    /// What the curvature solves, times the sum of its parts, is the right-hand side.
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
            // Roundings of a system of six, its largest bend a hundred times its smallest.
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
