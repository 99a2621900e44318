//! Computes the distance and time of stopping from any instant of a motion, and whether position limits and distances of bodies
//! suffice for it.
//!
//! A joint at position q with velocity v that brakes with its acceleration limit a stops after the time |v|/a (s) at the
//! position
//!
//! ```text
//! q + v |v| / (2 a)
//! ```
//! Each joint brakes independently, so the configuration stays in the box between all q and all stop positions. The distance of
//! bodies in the box is at least the distance at its middle minus the motion of the bodies towards its sides (Lipschitz bounds by
//! joint); the true distance may be greater. The bounds hold on each interval of the motion, not only at instants.
//!
//! Not here: how a real drive stops. It may brake with less than its limit of acceleration, or not at all after a power failure.

use claims::significant;
use numerics::interruption::Interruption;
use numerics::interval::Interval;
use numerics::range::{Enclosed, Extreme, RangeGoal, Subdivision, ranges};
use serde::{Deserialize, Serialize};

use crate::excitation::gap_proof::Surroundings;
use crate::excitation::limits::{CoordinateLimits, LimitKind};
use crate::excitation::proof::CertificateRow;
use crate::excitation::trajectory::{Trajectory, TrajectorySegment};

/// The longest stop of one joint, with the proved greatest velocity of this joint in the motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stopping {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Time after the start of the motion at which braking starts, s.
    pub at_s: f64,
    /// Proved velocity of the joint when braking starts, the greatest of the motion, rad/s (m/s).
    pub velocity: f64,
    /// Time from the start of braking to rest, s.
    pub time_s: f64,
    /// Distance from the start of braking to rest, rad (m).
    pub path: f64,
}

/// The least distance to a position limit, or between bodies, when the robot stops from any instant of the motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoppingMargin {
    /// Name of the coordinate; or names of two bodies, or of a body and a wall.
    pub subject: String,
    /// Time after the start of the motion at which braking starts, s.
    pub at_s: f64,
    /// Least distance to the position limit (rad or m) or between bodies (m). Negative: stopping may violate the limit.
    pub room: f64,
}

/// Summary of the distances between bodies when the robot stops from any instant of the motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StopBodies {
    /// Number of checked distances (pairs of bodies).
    pub distances: usize,
    /// Number of distances that are proved to stay at least as large as their error margins while stopping.
    pub covered: usize,
    /// The pair of bodies with the least distance minus error margin while stopping.
    pub least: StoppingMargin,
}

/// Distances and times that the robot needs to stop, over all instants of a motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StoppingMotions {
    /// The joint with the longest stopping distance, then the joint with the longest stopping time if it is another one. Empty if
    /// no acceleration is limited.
    pub joints: Vec<Stopping>,
    /// The least distance to a position limit while stopping. `None`: no moving joint has finite limits of position and
    /// acceleration.
    pub positions: Option<StoppingMargin>,
    /// The distances between bodies while stopping. `None`: there are no bodies, or the check was interrupted.
    pub bodies: Option<StopBodies>,
}

/// Tolerance of the computed distance to a position limit while stopping, relative to the width of the limits.
const RANGE_TOLERANCE: f64 = 1e-3;
/// Greatest number of interval evaluations per segment for the distance to position limits.
const MAX_ENCLOSURES_PER_SEGMENT: usize = 4000;
/// Relative rounding error of a stopping distance.
const STOPPING_DISTANCE_ROUNDING: f64 = 1e-14;

/// Computes distances and times of stopping along a trajectory. `rows`: the certificate, which has the proved velocities.
pub fn stops(
    course: &dyn Trajectory,
    rows: &[CertificateRow],
    limits: &[CoordinateLimits],
    names: &[String],
    surroundings: Option<&dyn Surroundings>,
) -> StoppingMotions {
    let joints = farthest_and_longest(rows, limits, names);
    if joints.is_empty() {
        return StoppingMotions::default();
    }
    let positions = room_of_positions(course, limits, names);
    StoppingMotions { joints, positions, bodies: surroundings.and_then(|s| room_of_bodies(course, limits, s)) }
}

fn farthest_and_longest(rows: &[CertificateRow], limits: &[CoordinateLimits], names: &[String]) -> Vec<Stopping> {
    let one = |(name, limits): (&String, &CoordinateLimits)| {
        let row = rows.iter().find(|row| row.limit == LimitKind::Velocity && row.subject == *name)?;
        // The certificate row has the proved velocity bound (lower or upper) that is nearest to its limit.
        let (v, a) = (row.nowhere_beyond.abs(), limits.acceleration);
        a.is_finite().then(|| Stopping {
            coordinate: name.clone(),
            at_s: row.time_s,
            velocity: row.nowhere_beyond,
            time_s: v / a,
            path: 0.5 * v * v / a,
        })
    };
    let all: Vec<Stopping> = names.iter().zip(limits).filter_map(one).collect();
    let farthest = all.iter().max_by(|a, b| a.path.total_cmp(&b.path));
    let longest = all.iter().max_by(|a, b| a.time_s.total_cmp(&b.time_s)).filter(|long| Some(*long) != farthest);
    farthest.into_iter().chain(longest).cloned().collect()
}

/// Interval of the positions at which a joint stops, if it brakes with this acceleration from the given intervals of position and
/// velocity. It equals `position` if the joint has no limit of acceleration.
fn stand(position: Interval, velocity: Interval, acceleration: f64) -> Interval {
    if !acceleration.is_finite() {
        return position;
    }
    let way = |v: f64| 0.5 * v * v.abs() / acceleration;
    let (low, high) = (way(velocity.low), way(velocity.high));
    let off = STOPPING_DISTANCE_ROUNDING * low.abs().max(high.abs());
    position + Interval::new(low - off, high + off)
}

/// The least distance to a position limit while the robot stops from any instant of the trajectory. `None` if no joint can be
/// checked.
fn room_of_positions(course: &dyn Trajectory, limits: &[CoordinateLimits], names: &[String]) -> Option<StoppingMargin> {
    // Only a moving joint with finite limits of position and acceleration can be checked.
    let is_given = |l: &CoordinateLimits| {
        l.acceleration.is_finite() && l.position.0.is_finite() && l.position.1.is_finite() && l.locked.is_none()
    };
    let given: Vec<usize> = (0..limits.len()).filter(|&k| is_given(&limits[k])).collect();
    let width = |k: usize| limits[k].position.1 - limits[k].position.0;
    let sought: Vec<RangeGoal> = given.iter().map(|&k| RangeGoal::to(RANGE_TOLERANCE * width(k))).collect();
    let enclosed = course.enclosed();
    let mut least: Option<StoppingMargin> = None;
    for (i, stretch) in course.stretches().into_iter().enumerate() {
        let subdivision =
            Subdivision { parts: stretch.parts, enclosures: MAX_ENCLOSURES_PER_SEGMENT, enclosures_within: 0 };
        let on = |part| {
            let held = enclosed.on(i, part);
            given.iter().map(|&k| stand(held[k][0], held[k][1], limits[k].acceleration)).collect()
        };
        let enclose = |part: Interval| Enclosed { over: on(part), middle: on(Interval::point(part.middle())) };
        let found = ranges(Interval::new(0.0, stretch.length), subdivision, &sought, enclose);
        for (&k, range) in given.iter().zip(&found) {
            let (low, high) = limits[k].position;
            // The proved ends of the range of stop positions are used, not the values that were evaluated.
            let mut take = |end: &Extreme, room: f64| {
                if least.as_ref().is_none_or(|known| room < known.room) {
                    least = Some(StoppingMargin { subject: names[k].clone(), at_s: stretch.start + end.time, room });
                }
            };
            take(&range.least, range.least.proved - low);
            take(&range.greatest, high - range.greatest.proved);
        }
    }
    least
}

/// The least distances of bodies while the robot stops from any instant of the trajectory. `None` if interrupted.
fn room_of_bodies(
    course: &dyn Trajectory,
    limits: &[CoordinateLimits],
    surroundings: &dyn Surroundings,
) -> Option<StopBodies> {
    let gaps = surroundings.gaps();
    let all: Vec<usize> = (0..gaps.len()).collect();
    let mut least = vec![(f64::INFINITY, 0.0); gaps.len()];
    let (enclosed, interruption) = (course.enclosed(), Interruption::here());
    for (i, stretch) in course.stretches().into_iter().enumerate() {
        for part in parts_of(&stretch) {
            if interruption.is_raised() {
                return None;
            }
            // Interval of each joint that contains its positions in this time interval and its stop positions.
            let boxes = enclosed.on(i, part).into_iter().zip(limits).map(|(held, limits)| {
                let reached = held[0].hull(stand(held[0], held[1], limits.acceleration));
                (reached.middle(), 0.5 * reached.width() * (1.0 + STOPPING_DISTANCE_ROUNDING))
            });
            let (q, spread): (Vec<f64>, Vec<f64>) = boxes.unzip();
            let rooms = surroundings.rooms(&q, &spread, &all);
            for ((room, gap), least) in rooms.iter().zip(gaps).zip(&mut least) {
                let room = room.at_least - gap.margin;
                if room < least.0 {
                    *least = (room, stretch.start + part.middle());
                }
            }
        }
    }
    // The error margin of a distance is reserved for errors, so stopping must not use this margin. It was subtracted above.
    let covered = least.iter().filter(|(room, _)| *room >= 0.0).count();
    let (gap, (room, at_s)) = gaps.iter().zip(least).min_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
    Some(StopBodies {
        distances: gaps.len(),
        covered,
        least: StoppingMargin { subject: format!("{} of {}", gap.limit, gap.subject), at_s, room },
    })
}

fn parts_of(stretch: &TrajectorySegment) -> impl Iterator<Item = Interval> {
    let (parts, length) = (stretch.parts.max(1), stretch.length);
    let at = move |k: usize| if k == parts { length } else { length * (k as f64 / parts as f64) };
    (0..parts).map(move |k| Interval::new(at(k), at(k + 1)))
}

impl StoppingMotions {
    /// The distances and times of stopping as text for users, one line for each statement.
    pub fn text(&self) -> String {
        let mut text = String::new();
        // One line for each listed joint.
        for Stopping { coordinate, at_s, velocity, time_s, path: way } in &self.joints {
            text += &format!(
                "stopping at {} s, at the limit of acceleration from {} rad/s (m/s): {coordinate} stands after {} s and {} rad (m)\n",
                significant(*at_s, 4),
                significant(velocity.abs(), 3),
                significant(*time_s, 2),
                significant(*way, 2)
            );
        }
        if let Some(StoppingMargin { subject, at_s, room }) = &self.positions {
            let (size, at) = (significant(room.abs(), 2), significant(*at_s, 4));
            text += &match *room >= 0.0 {
                true => format!(
                    "the limits of position cover stopping at any instant: {size} rad (m) remain ({subject} at {at} s)\n"
                ),
                false => format!(
                    "the limits of position do not cover stopping: {subject} goes up to {size} rad (m) beyond, from {at} s\n"
                ),
            };
        }
        // The check of distances between bodies is one line: covered, or the pair that is not covered.
        if let Some(StopBodies { distances, covered, least }) = &self.bodies {
            let at = significant(least.at_s, 4);
            text += &match covered == distances {
                true => format!(
                    "the room between bodies covers stopping at any instant: {} m remain ({} at {at} s)\n",
                    significant(least.room, 2),
                    least.subject
                ),
                false => format!(
                    "the room between bodies is shown to cover stopping for {covered} of {distances} distances, not for {} at {at} s\n",
                    least.subject
                ),
            };
        }
        text
    }
}
