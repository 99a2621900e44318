//! Typical magnitudes of the columns of a regressor when all joints move. They are the reference for the columns of a
//! record.
//!
//! If a joint is at standstill, its columns are zero up to rounding, about 1e-16 of their typical magnitude. Least squares
//! scales columns to unit norm, so without this reference rounding would determine their parameters.

use linear_model::regressor::Regressor;
use random::Random;

/// A column is neglected if it is below this share of its typical magnitude. With rounding of 1e-15, a larger column has at
/// least seven correct digits. If right angles are written with six digits in a log, columns are 1e-7 or more: such a small
/// column is small in every block, and is kept.
pub(super) const NEGLIGIBLE_COLUMN_SHARE: f64 = 1e-8;

/// Number of random states at which the columns are evaluated.
const REFERENCE_STATES: usize = 15;

/// The typical magnitude of each base column: the largest entry over coordinates, and of it the median over random states.
/// In these, each joint moves at up to `speed`, rad/s (m/s), and `acceleration`, rad/s^2 (m/s^2). Near a singularity of a
/// loop a column has no upper bound, but the median is not affected. A state at which no loop closes counts as zero.
pub(super) fn column_sizes(regressor: &dyn Regressor, speed: f64, acceleration: f64) -> Vec<f64> {
    let (n, p) = (regressor.coordinates().len(), regressor.parameters().len());
    let mut random = Random::new(61);
    let mut entries = vec![0.0; n * p];
    let mut sizes = vec![Vec::with_capacity(REFERENCE_STATES); p];
    for _ in 0..REFERENCE_STATES {
        let position = |k: usize| if regressor.is_prismatic(k) { 0.5 } else { std::f64::consts::PI };
        let q: Vec<f64> = (0..n).map(|k| random.between(-position(k), position(k))).collect();
        let mut rates = |most: f64| (0..n).map(|_| random.between(-most, most)).collect::<Vec<f64>>();
        let (dq, ddq) = (rates(speed), rates(acceleration));
        regressor.fill(&q, &dq, &ddq, &mut entries);
        for (c, sizes) in sizes.iter_mut().enumerate() {
            sizes.push(entries.iter().skip(c).step_by(p).fold(0.0, |most: f64, x| most.max(x.abs())));
        }
    }
    let median = |mut sizes: Vec<f64>| {
        sizes.sort_by(f64::total_cmp);
        sizes[REFERENCE_STATES / 2]
    };
    sizes.into_iter().map(median).collect()
}
