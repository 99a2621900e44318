//! The angle of a joint with the smallest residual: a grid, then a golden section search.

use std::f64::consts::TAU;

/// Angles of the grid.
const GRID_ANGLES: u32 = 24;
/// Width at which the golden section ends, rad.
const PRECISION_RAD: f64 = 1e-4;
/// Smaller angles are no mistake, rad.
const LEAST_ANGLE_RAD: f64 = 0.1;
/// Least share of the residual that an angle must remove.
const LEAST_IMPROVEMENT: f64 = 0.02;

/// The angle with the smallest `residual`, from -pi to pi, rad; `None` where it is nearly zero or improves little.
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
