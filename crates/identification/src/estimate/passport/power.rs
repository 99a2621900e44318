//! The least zero offset of a joint that the search would have found in this log.
//!
//! An offset that makes the description leave so much more of the torques is one that the search would have turned back.

use crate::estimate::passport::change::Change;
use crate::estimate::passport::regression::Partial;
use crate::estimate::passport::search::{COUNTED_JOINT_SHARE, SMALLEST_MISFIT_GAIN, counts};
use crate::estimate::passport::trials::Trials;

use super::change::misfits;

/// Offsets that are tried, degrees.
const TRIED_DEG: [f64; 10] = [5.0, 10.0, 15.0, 20.0, 30.0, 45.0, 60.0, 90.0, 135.0, 180.0];

/// rad; `None` where no offset of joint k would have been found.
pub(super) fn zero_power(trials: &Trials, slopes: &[Partial], k: usize) -> Option<f64> {
    let sum = |changes: &[Change], partials: &[Partial]| {
        let left = misfits(partials, slopes, changes, 1.0);
        let counted = left.iter().zip(slopes).filter(|(_, p)| counts(p, 1.0, COUNTED_JOINT_SHARE));
        counted.map(|(left, _)| left).sum::<f64>()
    };
    let unchanged = sum(&[], slopes);
    let shows = |angle: f64| {
        let change = [Change::Turned(k, angle)];
        sum(&change, &trials.partials(&change)) - unchanged >= SMALLEST_MISFIT_GAIN
    };
    let tried = TRIED_DEG.map(f64::to_radians);
    // From the largest down, as long as each shows both ways.
    tried.into_iter().rev().take_while(|&angle| shows(angle) && shows(-angle)).last()
}
