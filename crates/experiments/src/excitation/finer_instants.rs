//! A time grid that is finer than the grid of a search by an integer factor.
//!
//! Every `factor`-th instant of the finer grid is an instant of the search. The finer instants are numbered through the period,
//! then through each blend (motion from rest or to rest) including both its ends. The period is cyclic, so each of its instants
//! has two neighbours; the ends of a blend have only one.

use crate::excitation::motion::MotionShape;
use crate::excitation::problem::{Prepared, TORQUE_INSTANTS_PER_BLEND};

impl Prepared<'_> {
    /// Numbers, in the finer grid, of the instants at which the search evaluates the motion. The finer grid has `factor` steps
    /// per step of the search.
    pub(super) fn own_instants(&self, factor: usize) -> impl Iterator<Item = usize> {
        let (of_period, of_blend) = self.finer_counts(factor);
        let blends = if self.problem.shape.blend() > 0.0 { 2 } else { 0 };
        let of_blends =
            (0..blends).flat_map(move |b| (0..of_blend).step_by(factor).map(move |i| of_period + b * of_blend + i));
        (0..of_period).step_by(factor).chain(of_blends)
    }

    /// Whether instant number `at` of the finer grid is halfway between two instants of the search.
    pub(super) fn is_halfway(&self, at: usize, factor: usize) -> bool {
        let (of_period, of_blend) = self.finer_counts(factor);
        let local = if at < of_period { at } else { (at - of_period) % of_blend };
        local % factor == factor / 2
    }

    /// The numbers of all instants of the finer grid that are halfway between two instants of the search.
    pub(super) fn halfway_instants(&self, factor: usize) -> impl Iterator<Item = usize> {
        let half = factor as isize / 2;
        self.own_instants(factor).filter_map(move |at| self.neighbour(at, half, factor))
    }

    /// Number of instants of the finer grid in the period, and in each blend (motion from or to rest) including both ends.
    fn finer_counts(&self, factor: usize) -> (usize, usize) {
        (factor * self.problem.samples, factor * (TORQUE_INSTANTS_PER_BLEND - 1) + 1)
    }

    /// The number of the instant `by` steps after instant `at` of the finer grid, cyclic in the period. `None` beyond the end of
    /// a blend.
    pub(super) fn neighbour(&self, at: usize, by: isize, factor: usize) -> Option<usize> {
        let (of_period, of_blend) = self.finer_counts(factor);
        let moved = |local: usize| local as isize + by;
        if at < of_period {
            return Some(moved(at).rem_euclid(of_period as isize) as usize);
        }
        let (blend, local) = ((at - of_period) / of_blend, (at - of_period) % of_blend);
        usize::try_from(moved(local)).ok().filter(|i| *i < of_blend).map(|i| of_period + blend * of_blend + i)
    }

    /// Factors of a joint's coefficients in q, dq and ddq at instant `at` of the finer grid, in the period or in a blend (motion
    /// from or to rest).
    pub(super) fn finer_instant(&self, at: usize, factor: usize) -> [Vec<f64>; 3] {
        let (of_period, of_blend) = self.finer_counts(factor);
        let shape = &self.problem.shape;
        [0, 1, 2].map(|k| match shape {
            MotionShape::Fourier(series) if at >= of_period => {
                let (blend, local) = ((at - of_period) / of_blend, (at - of_period) % of_blend);
                series.blend_row(k, blend == 0, local as f64 / (of_blend - 1) as f64)
            }
            _ => shape.row(shape.period() * at as f64 / of_period as f64, k),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::criterion::SearchObjective;
    use crate::excitation::fourier_series::FourierSeries;
    use crate::excitation::problem::Problem;
    use crate::excitation::search::tests::pendulum_limits;
    use crate::pendulum::Pendulum;

    /// The instants of the search are in the finer grid. Each instant has two neighbours, except the ends of blends.
    #[test]
    fn own_instants_are_among_the_finer_ones() {
        let (arm, limits) = (Pendulum::new(), [pendulum_limits()]);
        let problem = Problem {
            regressor: &arm,
            friction: &[],
            limits: &limits,
            noise: &[0.1],
            aim: SearchObjective::Determinant,
            torque: None,
            columns: &[true; 3],
            shape: MotionShape::Fourier(FourierSeries { period: 5.0, blend: 1.0, harmonics: 3 }),
            samples: 20,
            surroundings: None,
            prior: &[],
        };
        let prepared = Prepared::new(&problem);
        let own: Vec<usize> = prepared.own_instants(4).collect();
        assert_eq!(own.len(), prepared.instants.len());
        for (at, rows) in own.iter().zip(&prepared.instants) {
            let finer = prepared.finer_instant(*at, 4);
            for (a, b) in rows.iter().flatten().zip(finer.iter().flatten()) {
                assert!((a - b).abs() < 1e-12, "{at}");
            }
        }
        assert_eq!((prepared.neighbour(0, -1, 4), prepared.neighbour(79, 1, 4)), (Some(79), Some(0)));
        assert_eq!((prepared.neighbour(80, -1, 4), prepared.neighbour(80, 60, 4)), (None, Some(140)));
        assert_eq!((prepared.neighbour(140, 1, 4), prepared.neighbour(141, -1, 4)), (None, None));
        // Twenty halfway instants in the period and fifteen in each of the two blends.
        assert_eq!(prepared.halfway_instants(4).count(), 50);
    }
}
