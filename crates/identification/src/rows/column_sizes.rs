//! Computes the typical magnitude of each column of a regressor when all joints move. If a column of a record is much smaller
//! than this magnitude, the column contains only rounding errors.
//!
//! If a joint is at standstill, its columns are zero up to rounding, about 1e-16 of their typical magnitude. Least squares
//! scales columns to unit norm, so without this comparison, rounding would determine the parameters of these columns.

use linear_model::regressor::Regressor;
use random::Random;

/// A column of a record is set to zero if its rms is below this share of the typical magnitude of the column. Two facts set the
/// limit. Rounding is about 1e-15 of the typical magnitude, so a larger column has at least seven correct digits. And a joint
/// that is held at a right angle, in a log with six digits, has columns of 1e-7 or more that would be zero at the exact angle.
/// Such columns are small in all blocks, but above the limit, and are kept.
pub(super) const NEGLIGIBLE_COLUMN_SHARE: f64 = 1e-8;

/// Number of random states at which the columns are evaluated.
const REFERENCE_STATES: usize = 15;

/// The typical magnitude of each base column: the largest entry over the coordinates, as the median over random states. In
/// these states, each joint moves at up to `speed`, rad/s (m/s), and `acceleration`, rad/s^2 (m/s^2). The median is used
/// because a column has no upper bound near a singularity of a kinematic loop. A state at which a loop cannot be closed counts
/// with magnitude zero.
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
