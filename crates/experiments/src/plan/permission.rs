//! Conditions on the motions of a plan in addition to the limits of their coordinates.

use crate::plan::exciting_trajectory::ExcitingTrajectory;

/// Conditions on poses and motions in addition to the limits of the coordinates.
pub trait Permission: Sync {
    /// Whether the robot may be at the position q, rad (m).
    fn pose(&self, q: &[f64]) -> bool;
    /// Whether a motion is permitted.
    fn motion(&self, trajectory: &ExcitingTrajectory) -> bool;
}

/// The permission that refuses nothing.
pub struct AllowAll;

impl Permission for AllowAll {
    fn pose(&self, _: &[f64]) -> bool {
        true
    }

    fn motion(&self, _: &ExcitingTrajectory) -> bool {
        true
    }
}
