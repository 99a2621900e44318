//! Friction torque over speed for plots: measured points, at most one per cell of a grid, and the curve of the identified
//! friction law.

use std::collections::BTreeMap;

use linear_model::friction::terms::{FrictionTerm, columns_before, columns_of, sign};
use linear_model::linear_model::Model;

/// Largest number of grid cells along each axis. With enough points, at least half of these cells are used.
const MAX_CELLS_PER_AXIS: i64 = 48;
/// Smallest extent of an axis, in its unit.
const SMALLEST_AXIS_EXTENT: f64 = 1e-9;
/// Number of points of the friction law for each direction of motion.
const LAW_POINTS_PER_SIDE: usize = 60;

/// Points (speed, torque), thinned by a grid. The cell size grows with the extent of the points.
#[derive(Clone, Debug, Default)]
pub struct FrictionCloud {
    /// For each cell, by its two indices: the first point (speed, torque) that fell into the cell.
    cells: BTreeMap<(i64, i64), (f64, f64)>,
    /// `size`: exponents k of the cell sizes 2^k along both axes. `range`: largest |speed| and largest |torque| so far.
    size: (i32, i32),
    range: (f64, f64),
}

impl FrictionCloud {
    /// Adds a point: a speed, rad/s (m/s), and the friction torque at that speed, N m (N).
    pub fn push(&mut self, speed: f64, torque: f64) {
        if !(speed.is_finite() && torque.is_finite()) {
            return;
        }
        let reach = (self.range.0.max(speed.abs()), self.range.1.max(torque.abs()));
        if reach != self.range {
            self.range = reach;
            // The factor is 2 because the grid covers positive and negative values.
            let exponent =
                |extent: f64| (2.0 * extent.max(SMALLEST_AXIS_EXTENT) / MAX_CELLS_PER_AXIS as f64).log2().ceil() as i32;
            let size = (exponent(reach.0), exponent(reach.1));
            if size != self.size {
                self.size = size;
                let points: Vec<(f64, f64)> = std::mem::take(&mut self.cells).into_values().collect();
                points.into_iter().for_each(|(x, y)| self.place(x, y));
            }
        }
        self.place(speed, torque);
    }

    fn place(&mut self, x: f64, y: f64) {
        let cell = ((x / 2f64.powi(self.size.0)).floor() as i64, (y / 2f64.powi(self.size.1)).floor() as i64);
        self.cells.entry(cell).or_insert((x, y));
    }

    /// The points (speed, torque), in the order of their cells.
    pub fn points(&self) -> Vec<(f64, f64)> {
        self.cells.values().copied().collect()
    }
}

/// The friction law of joint j at speeds from -speed to speed, rad/s (m/s), at zero load and acceleration: points (speed, torque
/// in N m (N)). Empty if the model has no friction.
///
/// `x`: the parameters that follow the base parameters.
pub fn law(model: &Model, x: &[f64], j: usize, speed: f64) -> Vec<(f64, f64)> {
    let terms: Vec<FrictionTerm> = model.friction.to_vec();
    let per_joint = columns_of(&terms, j);
    let x = &x[columns_before(&terms, j)..][..per_joint];
    if per_joint == 0 || speed.is_nan() || speed <= 0.0 {
        return Vec::new();
    }
    let at = |dq: f64| {
        let mut torque = 0.0;
        let mut first = 0;
        for term in &terms {
            // A term has at most four columns.
            let mut columns = [0.0; 4];
            let width = term.parameters_of(j).len();
            term.fill(dq, 0.0, 0.0, sign(dq), &mut columns[..width]);
            torque += columns[..width].iter().zip(&x[first..]).map(|(a, b)| a * b).sum::<f64>();
            first += width;
        }
        (dq, torque)
    };
    // Points are dense near zero speed, to show the Stribeck effect. There is no point at zero speed, where dry friction
    // jumps.
    let side =
        |s: f64| (1..=LAW_POINTS_PER_SIDE).map(move |i| s * speed * (i as f64 / LAW_POINTS_PER_SIDE as f64).powi(2));
    side(-1.0).collect::<Vec<_>>().into_iter().rev().chain(side(1.0)).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;
    use random::Random;

    #[test]
    fn a_cloud_keeps_its_outline_and_little_else() {
        let mut random = Random::new(4);
        let mut cloud = FrictionCloud::default();
        for _ in 0..200_000 {
            let speed = random.normal();
            cloud.push(speed, 0.3 * speed + speed.signum() + 0.05 * random.normal());
        }
        let points = cloud.points();
        // The points lie near a line, so there are about as many points as cells along one axis.
        let (cells, count) = (MAX_CELLS_PER_AXIS as usize, points.len());
        assert!((cells / 2..20 * cells).contains(&count), "{count}");
        assert!(points.iter().any(|p| p.0 > 3.0) && points.iter().any(|p| p.0 < -3.0));
    }

    #[test]
    fn the_law_jumps_at_rest() {
        let arm = Pendulum::new();
        let friction = FrictionTerm::STANDARD;
        let model = Model::new(&arm, &friction, &[]);
        let law = law(&model, &[0.5, 2.0, 0.1], 0, 3.0);
        let expected = [(-3.0, -3.4), (3.0, 3.6)];
        for (found, expected) in [law[0], law[law.len() - 1]].iter().zip(expected) {
            assert!((found.0 - expected.0).abs() < 1e-12 && (found.1 - expected.1).abs() < 1e-12, "{found:?}");
        }
        assert!(law.windows(2).all(|w| w[0].0 < w[1].0));
    }
}
