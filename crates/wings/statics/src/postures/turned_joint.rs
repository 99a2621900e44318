//! Finds the zero error of a joint (offset of its position, rad) that minimises a residual: grid search over a full turn, then
//! golden section search.

use std::f64::consts::TAU;

/// Number of grid angles per turn.
const GRID_ANGLES: u32 = 24;
/// The golden section search ends at this interval width, rad.
const PRECISION_RAD: f64 = 1e-4;
/// A zero error smaller than this value (rad) does not count as a mistake.
const LEAST_ANGLE_RAD: f64 = 0.1;
/// The zero error must reduce the residual by at least this fraction.
const LEAST_IMPROVEMENT: f64 = 0.02;

/// The zero error in (-pi, pi] for which `residual` is smallest, rad. `None` if this zero error is nearly zero, or if it hardly
/// reduces the residual.
pub(super) fn turned_joint(residual: &impl Fn(f64) -> f64) -> Option<f64> {
    let step = TAU / f64::from(GRID_ANGLES);
    let grid = (0..GRID_ANGLES).map(|k| step * f64::from(k)).map(|angle| (residual(angle), angle));
    let (_, coarse) = grid.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    let (mut low, mut high) = (coarse - step, coarse + step);
    while high - low > PRECISION_RAD {
        let part = golden * (high - low);
        if residual(high - part) < residual(low + part) { high = low + part } else { low = high - part }
    }
    let angle = f64::midpoint(low, high);
    let angle = angle - TAU * (angle / TAU).round();
    (angle.abs() > LEAST_ANGLE_RAD && residual(angle) < (1.0 - LEAST_IMPROVEMENT) * residual(0.0)).then_some(angle)
}
