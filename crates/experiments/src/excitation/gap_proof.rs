//! Proves that the bodies of a robot keep their minimum distances along a motion, also between the samples.
//!
//! On an interval of time with middle t, the enclosures of [`crate::excitation::enclosure`] bound how far every coordinate moves
//! away from q(t). The distance on the interval is at least the distance at q(t) minus the motion of the bodies by the joints: a
//! Lipschitz bound, which an implementation of [`Surroundings`] computes. An interval is halved until the bound is above the
//! limit. The proof follows from the motion, the limits and the description alone.
//!
//! Not here: the shapes of the bodies and the computation of distances.

use std::any::Any;
use std::collections::VecDeque;

use claims::significant;
use numerics::interruption::Interruption;
use numerics::interval::Interval;

use crate::excitation::limits::LimitKind;
use crate::excitation::proof::{CertificateRow, LimitProof};
use crate::excitation::trajectory::Trajectory;

/// A pair of bodies (or a body and a region) whose distance has a lower bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Gap {
    /// Kind of limit: `Distance` for two links, `Region` for a link and a floor, wall or box.
    pub limit: LimitKind,
    /// Names of the two sides: `forearm and base`, or `forearm at the floor`.
    pub subject: String,
    /// Least allowed distance of the two sides, m; it includes `margin`.
    pub bound: f64,
    /// The part of `bound` that covers position errors of joints and bodies, m.
    pub margin: f64,
    /// Additional distance that a search keeps (m), because bodies move between the instants of the search.
    pub reserve: f64,
    /// Names of the moving links that carry the two sides.
    pub carriers: [String; 2],
}

impl Gap {
    /// The pair of bodies and its least allowed distance in words: `distance of forearm and base (0.01 m)`.
    pub fn in_words(&self) -> String {
        format!("{} of {} ({} m)", self.limit, self.subject, significant(self.bound, 3))
    }
}

/// The distance of a pair of bodies at a configuration, and a lower bound of this distance near the configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapSize {
    /// Distance at the configuration, m; negative if bodies overlap.
    pub reached: f64,
    /// Lower bound of the distance in the given neighbourhood of the configuration, m.
    pub at_least: f64,
}

/// Data that [`Surroundings::near`] keeps from one call to the next. Only the implementation of `Surroundings` knows the type of
/// these data. `None`: no data yet.
pub type GapCache = Option<Box<dyn Any + Send>>;

/// Computes distances between the bodies of a robot, and between them and the environment.
pub trait Surroundings: Sync {
    /// The pairs of bodies whose distances are limited (gaps), in a fixed order.
    fn gaps(&self) -> &[Gap];

    /// The distances at configuration `q` of the gaps with indices `which`. Each has a lower bound that holds while every
    /// coordinate k stays within `spread[k]` of `q`, rad (m).
    fn rooms(&self, q: &[f64], spread: &[f64], which: &[usize]) -> Vec<GapSize>;

    /// Visits every pair of solids whose distance exceeds its bound by less than `within` (m) or violates it.
    ///
    /// `each` receives the index of the gap, the distance above the bound (m) and its derivative by each coordinate, m/rad
    /// (m/m). `known`: data of the previous call at the same instant of a motion, which save most of the work; `None` in the
    /// first call.
    fn near(&self, q: &[f64], within: f64, known: &mut GapCache, each: &mut dyn FnMut(usize, f64, &[f64]));
}

/// Time intervals shorter than this value (s) are not halved, because no body moves by a micrometre in them.
const SHORTEST_PART_S: f64 = 1e-7;
/// Greatest number of evaluated distances in a proof, in addition to the first intervals. A distance that is not proved by then
/// stays unproven.
const MAX_DISTANCES: usize = 1_000_000;

/// Data of one gap along the motion: its least evaluated distance (m), the time of this distance (s) and the proved lower bound
/// of the distance (m).
struct Least {
    reached: f64,
    time: f64,
    proved: f64,
}

/// Evaluates the distances at both ends of the trajectory. A distance that is violated there needs no proof elsewhere.
fn reach_ends(course: &dyn Trajectory, surroundings: &dyn Surroundings, all: &[usize], found: &mut [Least]) {
    let stretches = course.stretches();
    let first = stretches.first().map(|s| (0, 0.0, s.start));
    let last = stretches.last().map(|s| (stretches.len() - 1, s.length, s.start + s.length));
    for (i, t, time) in first.into_iter().chain(last) {
        let q = course.positions(i, t);
        for (least, room) in found.iter_mut().zip(surroundings.rooms(&q, &vec![0.0; q.len()], all)) {
            if room.reached < least.reached {
                (least.reached, least.time) = (room.reached, time);
            }
        }
    }
}

/// Proves the distances along a trajectory and gives one certificate row per gap, in the order of the gaps.
pub fn prove_gaps(course: &dyn Trajectory, surroundings: &dyn Surroundings) -> Vec<CertificateRow> {
    let gaps = surroundings.gaps();
    let (enclosed, stretches, interruption) = (course.enclosed(), course.stretches(), Interruption::here());
    let most = MAX_DISTANCES + gaps.len() * stretches.iter().map(|stretch| stretch.parts).sum::<usize>();
    let nothing = |_| Least { reached: f64::INFINITY, time: 0.0, proved: f64::INFINITY };
    let mut found: Vec<Least> = (0..gaps.len()).map(nothing).collect();
    let mut looked_at = 0;
    let all: Vec<usize> = (0..gaps.len()).collect();
    reach_ends(course, surroundings, &all, &mut found);
    for (i, stretch) in stretches.into_iter().enumerate() {
        let at = |k: usize| {
            if k == stretch.parts { stretch.length } else { stretch.length * (k as f64 / stretch.parts as f64) }
        };
        // Intervals are processed first in, first out, so wide intervals come first: a violation is found before a neighbouring
        // interval is halved many times.
        let mut left: VecDeque<(Interval, Vec<usize>)> =
            (0..stretch.parts).map(|k| (Interval::new(at(k), at(k + 1)), all.clone())).collect();
        while let Some((part, which)) = left.pop_front() {
            if interruption.is_raised() {
                which.iter().for_each(|&g| found[g].proved = f64::NEG_INFINITY);
                continue;
            }
            let middle = part.middle();
            let time = stretch.start + middle;
            let q = course.positions(i, middle);
            let spread: Vec<f64> = enclosed
                .on(i, part)
                .iter()
                .zip(&q)
                .map(|(held, q)| (held[0].high - q).max(q - held[0].low).max(0.0))
                .collect();
            let is_point = part.width() < SHORTEST_PART_S;
            looked_at += which.len();
            let mut open = Vec::new();
            for (&g, room) in which.iter().zip(surroundings.rooms(&q, &spread, &which)) {
                let (least, bound) = (&mut found[g], gaps[g].bound);
                if room.reached < least.reached {
                    (least.reached, least.time) = (room.reached, time);
                }
                // If a distance is violated at any instant, its proof cannot succeed, so no more intervals are halved for it.
                let settled = room.at_least >= bound || least.reached < bound;
                if settled || is_point || looked_at >= most {
                    least.proved = least.proved.min(room.at_least);
                } else {
                    open.push(g);
                }
            }
            if !open.is_empty() {
                left.push_back((Interval::new(part.low, middle), open.clone()));
                left.push_back((Interval::new(middle, part.high), open));
            }
        }
    }
    gaps.iter().zip(found).map(|(gap, least)| row(gap, least)).collect()
}

fn row(gap: &Gap, least: Least) -> CertificateRow {
    CertificateRow {
        limit: gap.limit,
        subject: gap.subject.clone(),
        time_s: least.time,
        value: least.reached,
        bound: gap.bound,
        margin: gap.margin,
        nowhere_beyond: least.proved,
        kept: match (least.proved >= gap.bound, least.reached < gap.bound) {
            (_, true) => LimitProof::Violated,
            (true, false) => LimitProof::Proven,
            (false, false) => LimitProof::Open,
        },
        how: "distance at instants less the bound of the motion in between (joint motion times radius)".into(),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::excitation::motion::tests::motions;

    /// A body at the end of a rod of length 1 m, which the first coordinate rotates; a wall is at y = `height`, m.
    pub(crate) struct Rod {
        pub(crate) height: f64,
        pub(crate) gaps: [Gap; 1],
    }

    impl Rod {
        pub(crate) fn new(height: f64) -> Rod {
            let gap = Gap {
                limit: LimitKind::Region,
                subject: "rod at the wall".into(),
                bound: 0.0,
                margin: 0.0,
                reserve: 0.004,
                carriers: ["rod".into(), "rod".into()],
            };
            Rod { height, gaps: [gap] }
        }
    }

    impl Surroundings for Rod {
        fn gaps(&self) -> &[Gap] {
            &self.gaps
        }

        fn rooms(&self, q: &[f64], spread: &[f64], which: &[usize]) -> Vec<GapSize> {
            let reached = self.height - q[0].sin();
            which.iter().map(|_| GapSize { reached, at_least: reached - spread[0] }).collect()
        }

        fn near(&self, q: &[f64], within: f64, _: &mut GapCache, each: &mut dyn FnMut(usize, f64, &[f64])) {
            let room = self.height - q[0].sin();
            if room < within {
                let mut slope = vec![0.0; q.len()];
                slope[0] = -q[0].cos();
                each(0, room, &slope);
            }
        }
    }

    #[test]
    fn proofs_of_gaps_are_sharp() {
        for motion in motions() {
            let height = |i: u32| motion.at(motion.duration() * f64::from(i) / 100_000.0)[0][0].sin();
            let greatest = (0..=100_000).map(height).fold(f64::NEG_INFINITY, f64::max);
            let [kept] = &prove_gaps(&motion, &Rod::new(greatest + 1e-4))[..] else { panic!() };
            assert!(kept.kept == LimitProof::Proven && kept.nowhere_beyond >= 0.0 && kept.value >= 9e-5, "{kept:?}");
            let [broken] = &prove_gaps(&motion, &Rod::new(greatest - 1e-4))[..] else { panic!() };
            assert!(broken.kept == LimitProof::Violated && broken.value < 0.0, "{broken:?}");
            let there = greatest - 1e-4 - motion.at(broken.time_s)[0][0].sin();
            assert!((there - broken.value).abs() < 1e-12, "{broken:?} {there}");
            assert!(broken.to_string().starts_with("region of rod at the wall: -0.0"), "{broken}");
        }
    }
}
