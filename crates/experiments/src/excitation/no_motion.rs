//! The reasons why a search finds no exciting motion.

use crate::excitation::limits::LimitKind;
use crate::excitation::problem::{Prepared, Problem};

/// The reason why there is no motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoMotion {
    /// No coordinate may move.
    AllLocked,
    /// No parameter is identifiable by any motion within the limits.
    NothingToTell,
    /// The limits, or the time, allow too little motion to separate the parameters.
    TooSmall {
        /// Index of the slowest coordinate.
        coordinate: usize,
        /// The limit that restricts it.
        limit: LimitKind,
        /// Distance from its least to its greatest position, rad (m).
        swing: f64,
        /// Its greatest speed, rad/s (m/s).
        speed: f64,
    },
    /// Even a very small motion takes more effort or power of this coordinate than is allowed.
    TooWeak {
        /// Index of the coordinate.
        coordinate: usize,
        /// The limit of effort or of power.
        limit: LimitKind,
        /// The least ratio to that limit of all tried motions.
        share: f64,
    },
    /// No motion keeps the distances of the bodies. The gap is the one that was nearest to being kept.
    TooNarrow {
        /// Index of the gap.
        gap: usize,
        /// Distance above its bound, m: too small for a search, and mostly negative.
        room: f64,
    },
}

/// The slowest coordinate of a motion that identifies too little, and the limit that it is nearest to.
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
