//! The angle by which a joint is turned, of all the one that leaves least: a grid, then a golden section.

use std::f64::consts::TAU;

/// Angles of the grid.
const GRID: u32 = 24;
/// The section ends below this, rad.
const PRECISION: f64 = 1e-4;
/// Smaller angles are no mistake, rad.
const LEAST: f64 = 0.1;
/// The least part of what is left that an angle mends.
const WORTHWHILE: f64 = 0.02;

/// rad, from -pi to pi; `None` where the best is nearly none. `left`: of an angle.
pub(super) fn turned_joint(left: &impl Fn(f64) -> f64) -> Option<f64> {
    let step = TAU / f64::from(GRID);
    let grid = (0..GRID).map(|k| step * f64::from(k)).map(|angle| (left(angle), angle));
    let (_, coarse) = grid.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    let (mut low, mut high) = (coarse - step, coarse + step);
    while high - low > PRECISION {
        let part = golden * (high - low);
        if left(high - part) < left(low + part) { high = low + part } else { low = high - part }
    }
    let angle = f64::midpoint(low, high);
    let angle = angle - TAU * (angle / TAU).round();
    (angle.abs() > LEAST && left(angle) < (1.0 - WORTHWHILE) * left(0.0)).then_some(angle)
}
