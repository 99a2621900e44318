//! Which motions a plan may choose from, beside those within the limits of their coordinates.

use crate::plan::exciting_trajectory::ExcitingTrajectory;

/// What motions must keep beside the limits of their coordinates.
pub trait Permission: Sync {
    /// Whether the robot may stand there, rad (m).
    fn pose(&self, q: &[f64]) -> bool;
    /// Whether a motion may be made.
    fn motion(&self, trajectory: &ExcitingTrajectory) -> bool;
}

/// Nothing is refused.
pub struct Anything;

impl Permission for Anything {
    fn pose(&self, _: &[f64]) -> bool {
        true
    }

    fn motion(&self, _: &ExcitingTrajectory) -> bool {
        true
    }
}
