//! What a proof goes along: positions of all coordinates over time, in stretches that have enclosures.
//!
//! A motion of `rist excite` is one ([`crate::excitation::motion`]), and so is what is made of polynomials
//! ([`crate::excitation::polynomial_course`]). Within a stretch position and four derivatives are bounded; where two
//! stretches meet, any of them may jump.

use numerics::interval::Interval;

use crate::excitation::enclosure::{Derivatives, EnclosedMotion, Piece};
use crate::excitation::motion::Motion;

/// A stretch of a course, with its own clock from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Time of the course at which its clock starts, s.
    pub start: f64,
    /// s.
    pub length: f64,
    /// Parts to begin a proof with.
    pub parts: usize,
    /// How its enclosures are found, in words.
    pub method: &'static str,
}

/// Positions of all coordinates over time.
pub trait Course: Sync {
    /// In the order of time.
    fn stretches(&self) -> Vec<Stretch>;

    /// Position of each coordinate at `t` s of a stretch's own clock, rad (m).
    fn positions(&self, stretch: usize, t: f64) -> Vec<f64>;

    /// With what its enclosures need.
    fn enclosed(&self) -> Box<dyn EnclosedCourse + '_>;
}

/// A course with what its enclosures need.
pub trait EnclosedCourse: Sync {
    /// Encloses position and derivatives of each coordinate on a part of a stretch.
    fn on(&self, stretch: usize, part: Interval) -> Vec<Derivatives>;
}

/// Parts of a piece of a motion to begin with.
const FIRST_PARTS_PER_PIECE: usize = 128;

impl Course for Motion {
    fn stretches(&self) -> Vec<Stretch> {
        let of = |piece: &Piece| Stretch {
            start: piece.start(self),
            length: piece.span(&self.shape).high,
            parts: FIRST_PARTS_PER_PIECE,
            method: piece.method(&self.shape),
        };
        Piece::of(&self.shape).iter().map(of).collect()
    }

    fn positions(&self, stretch: usize, t: f64) -> Vec<f64> {
        let start = Piece::of(&self.shape).get(stretch).map_or(0.0, |piece| piece.start(self));
        self.at(start + t).iter().map(|x| x[0]).collect()
    }

    fn enclosed(&self) -> Box<dyn EnclosedCourse + '_> {
        Box::new(EnclosedPieces { motion: EnclosedMotion::new(self), pieces: Piece::of(&self.shape) })
    }
}

struct EnclosedPieces<'a> {
    motion: EnclosedMotion<'a>,
    pieces: &'static [Piece],
}

impl EnclosedCourse for EnclosedPieces<'_> {
    fn on(&self, stretch: usize, part: Interval) -> Vec<Derivatives> {
        self.pieces.get(stretch).map_or(vec![], |piece| self.motion.on(*piece, part))
    }
}
