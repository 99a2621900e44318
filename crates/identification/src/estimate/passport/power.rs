//! The least zero offset of a joint that the search would have found in this log, and the one that suits it best.
//!
//! An offset that makes the description leave so much more of the torques is one that the search would have turned back.
//! A smaller one is no mistake that the search names, and yet the description may ask for it: with
//! e(u) the error of the description whose joint k is turned by u, its own friction and rotors fitted,
//! ```text
//! u_k = argmin e(u)        told where e(u_k) < TURNED_ERROR_RATIO e(0)
//! ```

use std::f64::consts::PI;

use linear_model::regressor::Regressor;

use crate::estimate::passport::change::Change;
use crate::estimate::passport::regression::Partial;
use crate::estimate::passport::search::{COUNTED_JOINT_SHARE, SMALLEST_MISFIT_GAIN, counts};
use crate::estimate::passport::trials::Trials;

use super::change::misfits;

/// Offsets that are tried, degrees.
const TRIED_DEG: [f64; 10] = [5.0, 10.0, 15.0, 20.0, 30.0, 45.0, 60.0, 90.0, 135.0, 180.0];

/// Whether the search would have undone these changes.
pub(super) fn shows(trials: &Trials, slopes: &[Partial], changes: &[Change]) -> bool {
    let sum = |changes: &[Change], partials: &[Partial]| {
        let left = misfits(partials, slopes, changes, 1.0);
        let counted = left.iter().zip(slopes).filter(|(_, p)| counts(p, 1.0, COUNTED_JOINT_SHARE));
        counted.map(|(left, _)| left).sum::<f64>()
    };
    sum(changes, &trials.partials(changes)) - sum(&[], slopes) >= SMALLEST_MISFIT_GAIN
}

/// Whether joint k carries no other joint: another zero is then a turn of its body, and bodies explain it always. What such a
/// joint feels, each joint that carries it feels too.
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

/// rad; `None` where no offset of joint k would have been found.
pub(super) fn zero_power(trials: &Trials, slopes: &[Partial], k: usize) -> Option<f64> {
    let shows = |angle: f64| shows(trials, slopes, &[Change::turned(k, angle)]);
    let tried = TRIED_DEG.map(f64::to_radians);
    // From the largest down, as long as each shows both ways.
    tried.into_iter().rev().take_while(|&angle| shows(angle) && shows(-angle)).last()
}

/// An offset with which the description leaves less than this of what it leaves as it is, is one that it asks for.
const TURNED_ERROR_RATIO: f64 = 0.4;
/// Least offset that is told, rad: encoders are referenced to a few tenths of a degree.
const SMALLEST_TURN_RAD: f64 = 0.2 * PI / 180.0;
/// Largest, rad: beyond it the search for mistakes looks.
const LARGEST_TURN_RAD: f64 = PI / 6.0;
/// Step of the parabola through three errors, rad.
const TURN_STEP_RAD: f64 = PI / 180.0;
/// The error of a turned joint is a parabola near its minimum: four steps settle to a thousandth of a degree.
const PARABOLA_STEPS: usize = 4;

/// A joint that the description would rather have elsewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Turned {
    /// The coordinate.
    pub joint: usize,
    /// rad.
    pub angle: f64,
    /// Error of the description, relative, as it is and with the joint turned.
    pub errors: (f64, f64),
}

/// The joint of these whose offset mends the description most; `None` where none mends it by far.
pub(super) fn turned(trials: &Trials, joints: impl Iterator<Item = usize>) -> Option<Turned> {
    // What is left of all torques, and all of them, in squares.
    let sums = |changes: &[Change]| {
        let left = |p: &Partial| p.yy * p.left(1.0);
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
        let is_told = angle.abs() > SMALLEST_TURN_RAD && errors.1 < TURNED_ERROR_RATIO * errors.0;
        is_told.then_some(Turned { joint, angle, errors })
    };
    joints.filter_map(one).min_by(|a, b| a.errors.1.total_cmp(&b.errors.1))
}
