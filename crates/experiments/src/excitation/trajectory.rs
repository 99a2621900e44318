//! Interface of trajectories whose limits can be proved: positions of all coordinates over time, in segments that can be
//! enclosed.
//!
//! There are two kinds: motions of `rist excite` ([`crate::excitation::motion`]) and trajectories of polynomials
//! ([`crate::excitation::polynomial_trajectory`]). Within a segment, position and four derivatives are bounded. Each of them may
//! jump between two segments.

use numerics::interval::Interval;

use crate::excitation::enclosure::{Derivatives, EnclosedMotion, MotionSegment};
use crate::excitation::motion::Motion;

/// A segment of a trajectory. Local time in a segment starts at 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrajectorySegment {
    /// Time after the start of the trajectory at which the segment starts, s.
    pub start: f64,
    /// Duration of the segment, s.
    pub length: f64,
    /// Number of equal intervals into which a proof first divides the segment.
    pub parts: usize,
    /// Name of the enclosure method for the segment, which a certificate states.
    pub method: &'static str,
}

/// Positions of all coordinates over time, of which a proof can enclose the derivatives.
pub trait Trajectory: Sync {
    /// The segments, in the order of time.
    fn stretches(&self) -> Vec<TrajectorySegment>;

    /// Position of each coordinate at local time `t` (s) of segment number `stretch`, rad (m).
    fn positions(&self, stretch: usize, t: f64) -> Vec<f64>;

    /// Precomputes the data for enclosures of the trajectory.
    fn enclosed(&self) -> Box<dyn EnclosedTrajectory + '_>;
}

/// A trajectory with precomputed data for enclosures of its positions and derivatives.
pub trait EnclosedTrajectory: Sync {
    /// Encloses position and four derivatives of each coordinate on the interval `part` of segment number `stretch`; local time,
    /// s.
    fn on(&self, stretch: usize, part: Interval) -> Vec<Derivatives>;
}

/// Number of equal intervals into which a proof first divides each segment of a motion.
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
