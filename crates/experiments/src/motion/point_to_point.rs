//! Random point-to-point motions for validation of an identified model; they are independent of any plan.
//!
//! Each move follows p(s) = 10 s^3 - 15 s^4 + 6 s^5, s = t/T, over the distance L in the time T, with peak velocity 1.875 L/T and
//! peak acceleration 5.7735 L/T^2. All joints use the duration T of the slowest joint.

use random::Random;

use crate::motion::reference_motion::Reference;

/// Peak velocity of a point-to-point move in units of L/T; L: distance, T: duration.
const PEAK_VELOCITY_FACTOR: f64 = 1.875;
/// Peak acceleration of a point-to-point move in units of L/T^2; L: distance, T: duration.
const PEAK_ACCELERATION_FACTOR: f64 = 5.7735;
/// Settings of a validation motion: shares of the limits, and number of moves.
#[derive(Clone, Debug, PartialEq)]
pub struct ValidationMotion {
    /// Share of each joint's position range, about its middle, in which the random points lie.
    pub range: f64,
    /// Share of the velocity limit that a move uses.
    pub velocity: f64,
    /// Share of the acceleration limit that a move uses.
    pub acceleration: f64,
    /// Number of point-to-point moves in one validation motion.
    pub moves: usize,
}

impl Default for ValidationMotion {
    fn default() -> ValidationMotion {
        ValidationMotion { range: 0.8, velocity: 0.8, acceleration: 0.7, moves: 3 }
    }
}

impl ValidationMotion {
    /// Duration of a move over `distance` (s) that uses the shares of `self` of the given velocity and acceleration limits.
    pub fn seconds(&self, distance: f64, velocity: f64, acceleration: f64) -> f64 {
        let by_velocity = PEAK_VELOCITY_FACTOR * distance / (self.velocity * velocity);
        by_velocity.max((PEAK_ACCELERATION_FACTOR * distance / (self.acceleration * acceleration)).sqrt())
    }
}

/// Draws point-to-point moves between random points. Limits: one per coordinate, rad, rad/s, rad/s^2 (m ..); `sample_time`: s.
pub fn validation_trajectory(
    motion: &ValidationMotion,
    position: &[(f64, f64)],
    velocity: &[f64],
    acceleration: &[f64],
    sample_time: f64,
    random: &mut Random,
) -> Reference {
    let n = position.len();
    // Draws a point within the share `range` of the position range of each joint.
    let mut point = || -> Vec<f64> {
        let within = |&(low, high): &(f64, f64)| (0.5 * (low + high), 0.5 * motion.range * (high - low));
        position.iter().map(within).map(|(middle, half)| random.between(middle - half, middle + half)).collect()
    };
    let mut r =
        Reference { sample_time, q: vec![vec![]; n], dq: vec![vec![]; n], ddq: vec![vec![]; n], windows: vec![] };
    let mut from = point();
    for _ in 0..motion.moves {
        let to = point();
        // The slowest joint determines the duration T of the move, which is rounded up to whole samples.
        let time =
            (0..n).map(|k| motion.seconds((to[k] - from[k]).abs(), velocity[k], acceleration[k])).fold(0.0, f64::max);
        let count = (time / sample_time).ceil().max(1.0) as usize;
        let time = count as f64 * sample_time;
        // Position p(s) and its time derivatives. Each move starts at the end of the previous move.
        for i in 0..count {
            let s = i as f64 / count as f64;
            let p = s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s);
            let dp = 30.0 * (s * (1.0 - s)).powi(2) / time;
            let ddp = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (time * time);
            for k in 0..n {
                let l = to[k] - from[k];
                r.q[k].push(from[k] + l * p);
                r.dq[k].push(l * dp);
                r.ddq[k].push(l * ddp);
            }
        }
        from = to;
    }
    // The last sample of the motion is at rest at the last point.
    for (k, q) in from.into_iter().enumerate() {
        r.q[k].push(q);
        r.dq[k].push(0.0);
        r.ddq[k].push(0.0);
    }
    let count = r.q.first().map_or(0, Vec::len);
    r.windows = std::iter::once(0..count).collect();
    r
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moves_stay_within_their_limits() {
        let position = [(-2.0, 1.0), (-0.5, 0.5)];
        let motion = ValidationMotion::default();
        let r = validation_trajectory(&motion, &position, &[2.0, 3.0], &[20.0, 30.0], 1e-3, &mut Random::new(3));
        for k in 0..2 {
            let peak = |x: &[f64]| x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            assert_eq!([&r.dq[k], &r.ddq[k]].map(|x| (x[0], x.last().copied())), [(0.0, Some(0.0)); 2]);
            assert!(r.q[k].iter().all(|&q| q >= position[k].0 && q <= position[k].1));
            assert!(peak(&r.dq[k]) <= 0.8 * [2.0, 3.0][k] + 1e-9);
            assert!(peak(&r.ddq[k]) <= 0.7 * [20.0, 30.0][k] + 1e-2);
            for i in 1..r.q[k].len() - 1 {
                let v = (r.q[k][i + 1] - r.q[k][i - 1]) / 2e-3;
                // The error of the central difference is h^2 / 6 times the third derivative of the move.
                assert!((v - r.dq[k][i]).abs() < 1e-2);
            }
        }
    }
}
