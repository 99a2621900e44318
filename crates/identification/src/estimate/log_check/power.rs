//! Computes, for a joint, the smallest zero offset that the search for faults would have detected, and the zero offset with
//! which the description fits best.
//!
//! An offset is detectable if it raises the misfit, the error with which the description predicts the torques, by enough. The
//! search would then have found and undone this offset. With a smaller offset u_k of joint k, the description may still fit
//! better. u_k is the minimum of e(u), the relative error of the description after joint k is turned by u, rad (friction and
//! rotors are fitted):
//! ```text
//! u_k = argmin e(u)        reported where e(u_k) < TURNED_ERROR_RATIO e(0)
//! ```

use std::f64::consts::PI;

use linear_model::regressor::Regressor;

use crate::estimate::log_check::change::Change;
use crate::estimate::log_check::regression::Partial;
use crate::estimate::log_check::search::{COUNTED_JOINT_SHARE, SMALLEST_MISFIT_GAIN, counts};
use crate::estimate::log_check::trials::Trials;

use super::change::misfits;

/// Zero offsets for which detection is tested, degrees.
const TRIED_OFFSETS_DEG: [f64; 10] = [5.0, 10.0, 15.0, 20.0, 30.0, 45.0, 60.0, 90.0, 135.0, 180.0];

/// Whether the search would have detected these faults, that is, whether they raise the sum of misfits (errors of the
/// description) by enough.
pub(super) fn shows(trials: &Trials, slopes: &[Partial], changes: &[Change]) -> bool {
    let sum = |changes: &[Change], partials: &[Partial]| {
        let left = misfits(partials, slopes, changes, 1.0);
        let counted = left.iter().zip(slopes).filter(|(_, p)| counts(p, 1.0, COUNTED_JOINT_SHARE));
        counted.map(|(left, _)| left).sum::<f64>()
    };
    sum(changes, &trials.partials(changes)) - sum(&[], slopes) >= SMALLEST_MISFIT_GAIN
}

/// Whether joint k carries no other joint. Then a zero offset of k is equivalent to a rotation of the body of joint k. The
/// test: if k carries joint j, the torque of k depends on all base parameters on which the torque of j depends.
pub(super) fn carries_none(regressor: &dyn Regressor, k: usize) -> bool {
    let n = regressor.coordinates().len();
    let felt =
        |j: usize| regressor.non_zeros().iter().filter(move |(row, _)| *row == j).map(|(_, c)| *c).collect::<Vec<_>>();
    let own = felt(k);
    (0..n).filter(|j| *j != k).all(|j| {
        let other = felt(j);
        other.is_empty() || other.iter().any(|c| !own.contains(c))
    })
}

/// The smallest zero offset of joint k that would be detected, rad; `None` if no tested offset would be detected.
pub(super) fn zero_power(trials: &Trials, slopes: &[Partial], k: usize) -> Option<f64> {
    let shows = |angle: f64| shows(trials, slopes, &[Change::turned(k, angle)]);
    let tried = TRIED_OFFSETS_DEG.map(f64::to_radians);
    // Starts from the largest offset and continues to smaller ones, as long as offsets of both signs are detected.
    tried.into_iter().rev().take_while(|&angle| shows(angle) && shows(-angle)).last()
}

/// A zero offset is reported if it multiplies the relative error of the description by less than this value.
const TURNED_ERROR_RATIO: f64 = 0.4;
/// Smallest zero offset that is reported, rad. The zeros of encoders are accurate to a few tenths of a degree.
const SMALLEST_TURN_RAD: f64 = 0.2 * PI / 180.0;
/// Largest zero offset that is reported, rad. The search for faults finds larger offsets.
const LARGEST_TURN_RAD: f64 = PI / 6.0;
/// Distance between the three points through which the parabola is fitted, rad.
const TURN_STEP_RAD: f64 = PI / 180.0;
/// Number of steps to the minimum of a fitted parabola. The error is nearly a parabola, so four steps are accurate to 0.001
/// degrees.
const PARABOLA_STEPS: usize = 4;

/// A joint with a zero offset that makes the description fit better.
#[derive(Clone, Debug, PartialEq)]
pub struct MisplacedJoint {
    /// Number of the coordinate.
    pub joint: usize,
    /// Zero offset with the smallest error of the description, rad.
    pub angle: f64,
    /// Relative errors of the description: (unchanged log, with the offset).
    pub errors: (f64, f64),
}

/// The joint among `joints` whose zero offset reduces the error of the description most; `None` if no offset reduces the error
/// enough.
pub(super) fn turned(trials: &Trials, joints: impl Iterator<Item = usize>) -> Option<MisplacedJoint> {
    // Squared residual and squared torque, summed over all joints.
    let sums = |changes: &[Change]| {
        let left = |p: &Partial| p.yy * p.residual(1.0);
        let partials = trials.partials(changes);
        (partials.iter().map(left).sum::<f64>(), partials.iter().map(|p| p.yy).sum::<f64>())
    };
    let (unchanged, whole) = sums(&[]);
    let one = |joint: usize| {
        let left = |angle: f64| sums(&[Change::turned(joint, angle)]).0;
        let mut angle = 0.0;
        for _ in 0..PARABOLA_STEPS {
            let (before, here, behind) = (left(angle - TURN_STEP_RAD), left(angle), left(angle + TURN_STEP_RAD));
            let bend = before - 2.0 * here + behind;
            if bend <= 0.0 {
                return None;
            }
            let step = 0.5 * TURN_STEP_RAD * (before - behind) / bend;
            angle = (angle + step).clamp(-LARGEST_TURN_RAD, LARGEST_TURN_RAD);
        }
        let errors = ((unchanged / whole).sqrt(), (left(angle) / whole).sqrt());
        let is_large = angle.abs() > SMALLEST_TURN_RAD && errors.1 < TURNED_ERROR_RATIO * errors.0;
        is_large.then_some(MisplacedJoint { joint, angle, errors })
    };
    joints.filter_map(one).min_by(|a, b| a.errors.1.total_cmp(&b.errors.1))
}
