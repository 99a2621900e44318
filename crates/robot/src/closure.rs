//! Checks that the loops of a robot close: 0T_cut(q) = 0T_twin(q) at every q. A loop is cut at one place: 0T_cut and 0T_twin are
//! the poses of the frames on both sides of the cut, in the base frame.
//!
//! Both poses are trigonometric polynomials in the coordinates. So if they agree at a few generic configurations, they agree
//! everywhere. A loop with passive coordinates closes only at solved positions of the passive coordinates, so its gap at other
//! points has no meaning.

use crate::inertial::Pose;
use crate::robot::{Loop, Robot};

/// The two frames of a loop coincide if their distance (m) and their angle (rad) are at most this value.
pub(crate) const CLOSURE_TOLERANCE: f64 = 1e-9;

/// Number of configurations at which the closure of a loop is tested.
const TESTED_CONFIGURATIONS: usize = 20;

/// The gap between the two frames of a loop at a configuration.
#[derive(Clone, Debug)]
pub struct ClosureGap {
    /// Distance between the origins of the two frames, m.
    pub position: f64,
    /// Angle of the rotation between the two frames, rad.
    pub orientation: f64,
    /// The configuration, rad (m): first the coordinates, then the passive coordinates.
    pub q: Vec<f64>,
}

/// The largest gap of a loop over a fixed set of pseudo-random configurations.
pub fn largest_gap(robot: &Robot, one: &Loop) -> ClosureGap {
    let mut worst = ClosureGap { position: 0.0, orientation: 0.0, q: vec![0.0; robot.n_variables()] };
    for q in configurations(robot.n_variables(), TESTED_CONFIGURATIONS) {
        let poses = robot.link_poses(&q);
        let cut = robot.loop_frame_pose(&one.cut, &poses, &q);
        let twin = robot.loop_frame_pose(&one.twin, &poses, &q);
        // Very large numbers in a description may overflow in f64. Then the gap is NaN and counts as infinite.
        let known = |x: f64| if x.is_nan() { f64::INFINITY } else { x };
        let (position, orientation) = distance(&cut, &twin);
        let (position, orientation) = (known(position), known(orientation));
        if position.max(orientation) > worst.position.max(worst.orientation) {
            worst = ClosureGap { position, orientation, q };
        }
    }
    worst
}

/// Checks that every loop without passive coordinates closes. If one does not, the error is the index of the first such loop and
/// a message.
pub(crate) fn check(robot: &Robot) -> Result<(), (usize, String)> {
    for (k, one) in robot.loops.iter().enumerate().filter(|l| !robot.is_implicit(l.1)) {
        let gap = largest_gap(robot, one);
        if gap.position > CLOSURE_TOLERANCE || gap.orientation > CLOSURE_TOLERANCE {
            let at: Vec<String> = gap.q.iter().map(|x| format!("{x:.3}")).collect();
            let message = format!(
                "loop {} does not close: its cut and twin frames are {:.3e} m and {:.3e} rad apart at q = [{}]; both \
                 must stay below {CLOSURE_TOLERANCE:e}",
                k + 1,
                gap.position,
                gap.orientation,
                at.join(", ")
            );
            return Err((k, message));
        }
    }
    Ok(())
}

/// Distance between the origins of two frames (m) and angle of the rotation between them (rad).
pub(crate) fn distance(a: &Pose, b: &Pose) -> (f64, f64) {
    let between = a.inverse().compose(b);
    let [x, y, z] = between.position;
    let r = between.rotation;
    // For a rotation matrix R with angle a: (R - R') / 2 is the skew-symmetric matrix of sin(a) times the axis; trace R = 1 + 2
    // cos(a).
    let skew = [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]].map(|s| s / 2.0);
    let sine = (skew[0] * skew[0] + skew[1] * skew[1] + skew[2] * skew[2]).sqrt();
    let cosine = (r[0][0] + r[1][1] + r[2][2] - 1.0) / 2.0;
    ((x * x + y * y + z * z).sqrt(), sine.atan2(cosine))
}

/// `count` pseudo-random points of [-pi, pi]^n. Every call returns the same points.
pub(crate) fn configurations(n: usize, count: usize) -> impl Iterator<Item = Vec<f64>> {
    let mut state: u64 = 0x1995_0521_0411_0018;
    (0..count).map(move |_| (0..n).map(|_| std::f64::consts::PI * (2.0 * uniform(&mut state) - 1.0)).collect())
}

/// A pseudo-random number in [0, 1) by splitmix64; `state` is advanced.
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}
