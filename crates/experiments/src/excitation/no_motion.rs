//! The reasons why a search finds no exciting motion. Each names the coordinate, or the pair of bodies (gap), that prevents it.

use crate::excitation::limits::LimitKind;
use crate::excitation::problem::{Prepared, Problem};

/// The reason why a search finds no exciting motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoMotion {
    /// All coordinates are locked.
    AllLocked,
    /// No motion within the limits makes any parameter identifiable.
    NothingToTell,
    /// The limits of the coordinates, or the duration, allow too little motion to separate the parameters.
    TooSmall {
        /// Index of the slowest coordinate.
        coordinate: usize,
        /// The limit of this coordinate that the motion uses most.
        limit: LimitKind,
        /// Range of positions of this coordinate in the motion that was found, rad (m).
        swing: f64,
        /// Greatest speed of this coordinate in the motion that was found, rad/s (m/s).
        speed: f64,
    },
    /// Every tried motion, however small, needs more effort or power of this coordinate than is allowed.
    TooWeak {
        /// Index of the coordinate whose drive is too weak.
        coordinate: usize,
        /// The violated limit of the drive: effort or power.
        limit: LimitKind,
        /// The least ratio of effort or power to this limit, over all tried motions.
        share: f64,
    },
    /// Every tried motion, however small, violates a distance of bodies. `gap` is the violated pair of bodies that came nearest
    /// to its bound.
    TooNarrow {
        /// Index of the gap (pair of bodies).
        gap: usize,
        /// Distance of this pair minus its bound, m. It is too small to start a search, and usually negative.
        room: f64,
    },
}

/// Describes a motion with too little information: its slowest coordinate, and the limit that this coordinate uses most. x:
/// scaled coefficients of the motion.
pub(crate) fn too_small(prepared: &Prepared, problem: &Problem, x: &[f64]) -> NoMotion {
    let barrier = prepared.barrier();
    let of_joint = |(j, &coordinate): (usize, &usize)| {
        let reached = |kind: LimitKind| barrier.reached(j, x, kind);
        let ((low, high), (back, forth)) = (reached(LimitKind::Position), reached(LimitKind::Velocity));
        let share = |kind: LimitKind| match (kind, problem.limits[coordinate].bounds(kind)) {
            (LimitKind::Position, Some((a, b))) => (high - low) / (b - a),
            (_, Some((_, b))) => reached(kind).1.max(-reached(kind).0) / b,
            (_, None) => 0.0,
        };
        let limit = LimitKind::KINEMATIC.into_iter().max_by(|a, b| share(*a).total_cmp(&share(*b)));
        let limit = limit.unwrap_or(LimitKind::Position);
        (coordinate, limit, high - low, forth.max(-back))
    };
    let slowest = prepared.moving().iter().enumerate().map(of_joint).min_by(|a, b| a.3.total_cmp(&b.3));
    slowest.map_or(NoMotion::AllLocked, |(coordinate, limit, swing, speed)| NoMotion::TooSmall {
        coordinate,
        limit,
        swing,
        speed,
    })
}
