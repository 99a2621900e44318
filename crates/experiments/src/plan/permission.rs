//! Conditions on poses and motions of a plan, in addition to the limits of the coordinates. Other packages implement them, for
//! example to exclude collisions of bodies.

use crate::plan::exciting_trajectory::ExcitingTrajectory;

/// Decides which poses and motions a plan may use, in addition to the limits of the coordinates.
pub trait Permission: Sync {
    /// Whether the robot may be at the configuration q, rad (m).
    fn pose(&self, q: &[f64]) -> bool;
    /// Whether the robot may perform this motion.
    fn motion(&self, trajectory: &ExcitingTrajectory) -> bool;
}

/// A permission that allows everything.
pub struct AllowAll;

impl Permission for AllowAll {
    fn pose(&self, _: &[f64]) -> bool {
        true
    }

    fn motion(&self, _: &ExcitingTrajectory) -> bool {
        true
    }
}
