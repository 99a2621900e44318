//! The object of a proof: positions of all coordinates over time, in segments that can be enclosed.
//!
//! There are two kinds: motions of `rist excite` ([`crate::excitation::motion`]) and trajectories of polynomials
//! ([`crate::excitation::polynomial_trajectory`]). Within a segment, position and four derivatives are bounded. Each of them may
//! jump between two segments.

use numerics::interval::Interval;

use crate::excitation::enclosure::{Derivatives, EnclosedMotion, MotionSegment};
use crate::excitation::motion::Motion;

/// A segment of a trajectory; its local time starts at 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrajectorySegment {
    /// Time of the trajectory at which the segment starts, s.
    pub start: f64,
    /// Duration of the segment, s.
    pub length: f64,
    /// Number of intervals of the segment at the start of a proof.
    pub parts: usize,
    /// Name of the method that encloses the segment.
    pub method: &'static str,
}

/// A trajectory: positions of all coordinates over time.
pub trait Trajectory: Sync {
    /// The segments, in the order of time.
    fn stretches(&self) -> Vec<TrajectorySegment>;

    /// Position of each coordinate at local time `t` of a segment, rad (m); t in s.
    fn positions(&self, stretch: usize, t: f64) -> Vec<f64>;

    /// The trajectory prepared for enclosures.
    fn enclosed(&self) -> Box<dyn EnclosedTrajectory + '_>;
}

/// A trajectory prepared for enclosures.
pub trait EnclosedTrajectory: Sync {
    /// Encloses position and derivatives of each coordinate on an interval of a segment, in local time, s.
    fn on(&self, stretch: usize, part: Interval) -> Vec<Derivatives>;
}

/// Number of intervals of a segment of a motion at the start of a proof.
const INITIAL_INTERVALS_PER_SEGMENT: usize = 128;

impl Trajectory for Motion {
    fn stretches(&self) -> Vec<TrajectorySegment> {
        let of = |piece: &MotionSegment| TrajectorySegment {
            start: piece.start(self),
            length: piece.span(&self.shape).high,
            parts: INITIAL_INTERVALS_PER_SEGMENT,
            method: piece.method(&self.shape),
        };
        MotionSegment::of(&self.shape).iter().map(of).collect()
    }

    fn positions(&self, stretch: usize, t: f64) -> Vec<f64> {
        let start = MotionSegment::of(&self.shape).get(stretch).map_or(0.0, |piece| piece.start(self));
        self.at(start + t).iter().map(|x| x[0]).collect()
    }

    fn enclosed(&self) -> Box<dyn EnclosedTrajectory + '_> {
        Box::new(EnclosedPieces { motion: EnclosedMotion::new(self), pieces: MotionSegment::of(&self.shape) })
    }
}

struct EnclosedPieces<'a> {
    motion: EnclosedMotion<'a>,
    pieces: &'static [MotionSegment],
}

impl EnclosedTrajectory for EnclosedPieces<'_> {
    fn on(&self, stretch: usize, part: Interval) -> Vec<Derivatives> {
        self.pieces.get(stretch).map_or(vec![], |piece| self.motion.on(*piece, part))
    }
}
