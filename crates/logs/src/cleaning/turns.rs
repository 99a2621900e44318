//! Removes jumps by a full turn from angles that were logged within one turn.
//!
//! A single-turn encoder gives angles between -pi and pi, or between 0 and 2 pi, and jumps by a turn at the ends of this range.
//! A series with a larger range has no such jumps: a motor with a gear ratio of 121 may move by 40 rad between two samples at
//! 50 Hz, so some of its steps are near a full turn by chance.

use std::f64::consts::TAU;

/// Largest range of a series that was logged within one turn, rad. It exceeds a full turn by a rounding error.
const MAX_ONE_TURN_RANGE_RAD: f64 = 1.001 * TAU;
/// A smaller step cannot be a jump by a turn, rad.
const SMALL_STEP_RAD: f64 = 3.0;
/// A jump is one full turn, so a step of more turns than this is no jump.
const MAX_JUMP_TURNS: f64 = 1.5;
/// A jump differs from a full turn by at most this value (rad), because no joint turns more between two samples.
const MAX_STEP_BETWEEN_SAMPLES_RAD: f64 = 0.5;

/// Smallest and largest number of a series; (inf, -inf) of an empty one.
pub fn extremes(x: &[f64]) -> (f64, f64) {
    // The search uses eight SIMD lanes. In a single series, each comparison would wait for the previous one.
    let (eights, rest) = x.as_chunks::<8>();
    let (mut low, mut high) = ([f64::INFINITY; 8], [f64::NEG_INFINITY; 8]);
    for eight in eights {
        low.iter_mut().zip(eight).for_each(|(low, x)| *low = low.min(*x));
        high.iter_mut().zip(eight).for_each(|(high, x)| *high = high.max(*x));
    }
    let all = |lanes: [f64; 8]| lanes.into_iter().chain(rest.iter().copied());
    (all(low).fold(f64::INFINITY, f64::min), all(high).fold(f64::NEG_INFINITY, f64::max))
}

/// Whether a series with this smallest and largest value may have been logged within one turn.
pub(crate) fn may_be_wrapped((low, high): (f64, f64)) -> bool {
    high - low <= MAX_ONE_TURN_RANGE_RAD
}

/// Removes the jumps by a turn from an angle that was logged within one turn; returns their number. A series with a larger range
/// is unchanged.
pub fn unwrap_angle(q: &mut [f64]) -> usize {
    if may_be_wrapped(extremes(q)) { unwrap(q) } else { 0 }
}

/// Removes the jumps by a turn, for any range of the angle; returns their number.
///
/// A step within 0.5 rad of one whole turn counts as such a jump, because no joint turns so far from one sample to the next.
pub(crate) fn unwrap(q: &mut [f64]) -> usize {
    let (mut turns, mut count) = (0.0, 0);
    for i in 1..q.len() {
        let step = q[i] + turns * TAU - q[i - 1];
        // Most steps are far from a turn, so the slow division is avoided for them.
        let back = if step.abs() < SMALL_STEP_RAD { 0.0 } else { (step / TAU).round() };
        if back != 0.0 && back.abs() < MAX_JUMP_TURNS && (step - back * TAU).abs() < MAX_STEP_BETWEEN_SAMPLES_RAD {
            turns -= back;
            count += 1;
        }
        q[i] += turns * TAU;
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrapped(smooth: &[f64]) -> Vec<f64> {
        smooth.iter().map(|x| x - TAU * (x / TAU).round()).collect()
    }

    #[test]
    fn turns_are_taken_back() {
        let smooth: Vec<f64> = (0..2000).map(|i| 8.0 * (0.005 * f64::from(i)).sin()).collect();
        let mut logged = wrapped(&smooth);
        assert!(unwrap_angle(&mut logged) > 3);
        // The angles must be equal up to the rounding of a few turns.
        assert!(smooth.iter().zip(&logged).all(|(a, b)| (a - b).abs() < 1e-12));
        for mut alone in [smooth, vec![1.0], vec![]] {
            let before = alone.clone();
            assert_eq!((unwrap_angle(&mut alone), alone), (0, before));
        }
    }

    /// A series with a range of more than a turn was not logged within one turn, so it is not changed.
    #[test]
    fn three_turns_stay_as_they_are() {
        let mut logged = vec![0.0, 2.0, 4.0, 6.0, 6.0 + TAU, 8.0 + TAU, 10.0 + TAU];
        let before = logged.clone();
        assert_eq!((unwrap_angle(&mut logged), logged), (0, before));
    }

    /// A motor with a gear ratio of 121 has steps near a full turn, which are no jumps.
    #[test]
    fn a_motor_behind_its_gear_does_not_jump() {
        let motor: Vec<f64> = (0..1000).map(|i| 121.0 * 1.1 * (0.05 * f64::from(i)).sin()).collect();
        let near_a_turn = motor.windows(2).filter(|w| ((w[1] - w[0]).abs() - TAU).abs() < 0.5).count();
        assert!(near_a_turn > 20, "{near_a_turn}");
        let mut logged = motor.clone();
        assert_eq!((unwrap_angle(&mut logged), logged), (0, motor.clone()));
        // The angle of the joint (after the gear) is unwrapped as usual.
        let mut joint = wrapped(&motor.iter().map(|q| 3.0 + q / 121.0).collect::<Vec<f64>>());
        assert!(unwrap_angle(&mut joint) > 10);
        assert!(joint.iter().zip(&motor).all(|(q, m)| (q - joint[0] - (m - motor[0]) / 121.0).abs() < 1e-9));
    }
}
