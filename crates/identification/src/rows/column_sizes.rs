//! How large the columns of a regressor are where any joint may move, beside which the columns of a record are looked at.
//!
//! A joint that stands still leaves columns that are zero but for rounding, 1e-16 of what they are elsewhere. Scaled to unit
//! norm, as least squares scales them, rounding would decide their parameters.

use linear_model::regressor::Regressor;
use random::Random;

/// A column below this share of its size elsewhere says nothing. Rounding is 1e-15 of it, so what is left has seven digits. Right
/// angles that a log has to six digits leave 1e-7 and more: such a column is small, is so in every part of a log, and is kept.
pub(super) const NEGLIGIBLE_COLUMN_SHARE: f64 = 1e-8;

/// States at which columns are looked at.
const STATES: usize = 15;

/// The size of each base column: its largest entry of all coordinates, the median of it over states anywhere at which every
/// joint moves with this speed, rad/s (m/s), and acceleration, rad/s^2 (m/s^2). Near a singularity of a loop a column is as
/// large as one likes, which the median does not see; a state at which no loop closes counts as zero.
pub(super) fn column_sizes(regressor: &dyn Regressor, speed: f64, acceleration: f64) -> Vec<f64> {
    let (n, p) = (regressor.coordinates().len(), regressor.parameters().len());
    let mut random = Random::new(61);
    let mut entries = vec![0.0; n * p];
    let mut sizes = vec![Vec::with_capacity(STATES); p];
    for _ in 0..STATES {
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
        sizes[STATES / 2]
    };
    sizes.into_iter().map(median).collect()
}
