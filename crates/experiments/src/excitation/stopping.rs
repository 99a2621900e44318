//! Where stopping begins at any instant: how far the joints go on, and whether the room there covers it.
//!
//! A joint of the velocity v that brakes at its limit of acceleration a stands v/a s later, at
//!
//! ```text
//! q + v |v| / (2 a)
//! ```
//! Each joint brakes on its own, so that the bodies are somewhere in the box between all q and all ends. The room in it is the
//! distance at its middle less what joints times reach take the bodies to its sides: more room than that may be there. Told of
//! each part of the motion, not of instants, so that nothing is missed between them.
//!
//! Not here: how a drive stops. It may be slower than its limit of acceleration, and a power failure is no braking.

use claims::significant;
use numerics::interruption::Interruption;
use numerics::interval::Interval;
use numerics::range::{Enclosed, Extreme, Sought, Subdivision, ranges};
use serde::{Deserialize, Serialize};

use crate::excitation::course::{Course, Stretch};
use crate::excitation::gap_proof::Surroundings;
use crate::excitation::limits::{CoordinateLimits, LimitKind};
use crate::excitation::proof::CertificateRow;

/// How far a joint goes on, at most, where stopping begins at any instant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stopping {
    /// Its coordinate.
    pub coordinate: String,
    /// Where stopping would begin, after the start of the motion, s.
    pub at_s: f64,
    /// The velocity that it is nowhere beyond, rad/s (m/s).
    pub velocity: f64,
    /// From then until it stands, s.
    pub time_s: f64,
    /// rad (m).
    pub way: f64,
}

/// The least room while stopping.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StopRoom {
    /// A coordinate, or two bodies, or one at a wall.
    pub subject: String,
    /// Where stopping would begin, after the start of the motion, s.
    pub at_s: f64,
    /// rad (m) to the limit of position, or m between bodies; negative: less than stopping takes.
    pub room: f64,
}

/// The rooms of bodies while stopping.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StopBodies {
    /// Distances that are looked at.
    pub distances: usize,
    /// Those of them that are shown to stay above zero, with their margins.
    pub covered: usize,
    /// The one with the least room.
    pub least: StopRoom,
}

/// What stopping takes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Stops {
    /// The coordinate that goes on farthest, and the one that goes on longest; none where no acceleration is limited.
    pub joints: Vec<Stopping>,
    /// Of the limits of position.
    pub positions: Option<StopRoom>,
    /// Of the distances.
    pub bodies: Option<StopBodies>,
}

/// How near the room to a limit of position is found, relative to the size of the limit.
const ROOM_TOLERANCE: f64 = 1e-3;
/// Most enclosures of a stretch.
const ENCLOSURES: usize = 4000;
/// Rounding of the few operations of a way.
const WAY_ROUNDING: f64 = 1e-14;

/// What stopping takes on a course. `rows`: of its certificate, with what is proven of velocities.
pub fn stops(
    course: &dyn Course,
    rows: &[CertificateRow],
    limits: &[CoordinateLimits],
    names: &[String],
    surroundings: Option<&dyn Surroundings>,
) -> Stops {
    let joints = farthest_and_longest(rows, limits, names);
    if joints.is_empty() {
        return Stops::default();
    }
    let positions = room_of_positions(course, limits, names);
    Stops { joints, positions, bodies: surroundings.and_then(|s| room_of_bodies(course, limits, s)) }
}

fn farthest_and_longest(rows: &[CertificateRow], limits: &[CoordinateLimits], names: &[String]) -> Vec<Stopping> {
    let one = |(name, limits): (&String, &CoordinateLimits)| {
        let row = rows.iter().find(|row| row.limit == LimitKind::Velocity && row.subject == *name)?;
        // The row has the end that is nearest to its limit.
        let (v, a) = (row.nowhere_beyond.abs(), limits.acceleration);
        a.is_finite().then(|| Stopping {
            coordinate: name.clone(),
            at_s: row.time_s,
            velocity: row.nowhere_beyond,
            time_s: v / a,
            way: 0.5 * v * v / a,
        })
    };
    let all: Vec<Stopping> = names.iter().zip(limits).filter_map(one).collect();
    let farthest = all.iter().max_by(|a, b| a.way.total_cmp(&b.way));
    let longest = all.iter().max_by(|a, b| a.time_s.total_cmp(&b.time_s)).filter(|long| Some(*long) != farthest);
    farthest.into_iter().chain(longest).cloned().collect()
}

/// Where a joint stands that brakes on a part; a joint without a limit of acceleration goes on as it is.
fn stand(position: Interval, velocity: Interval, acceleration: f64) -> Interval {
    if !acceleration.is_finite() {
        return position;
    }
    let way = |v: f64| 0.5 * v * v.abs() / acceleration;
    let (low, high) = (way(velocity.low), way(velocity.high));
    let off = WAY_ROUNDING * low.abs().max(high.abs());
    position + Interval::new(low - off, high + off)
}

/// The least room to a limit of position.
fn room_of_positions(course: &dyn Course, limits: &[CoordinateLimits], names: &[String]) -> Option<StopRoom> {
    let is_told = |l: &CoordinateLimits| {
        l.acceleration.is_finite() && l.position.0.is_finite() && l.position.1.is_finite() && l.locked.is_none()
    };
    let told: Vec<usize> = (0..limits.len()).filter(|&k| is_told(&limits[k])).collect();
    let width = |k: usize| limits[k].position.1 - limits[k].position.0;
    let sought: Vec<Sought> = told.iter().map(|&k| Sought::to(ROOM_TOLERANCE * width(k))).collect();
    let enclosed = course.enclosed();
    let mut least: Option<StopRoom> = None;
    for (i, stretch) in course.stretches().into_iter().enumerate() {
        let subdivision = Subdivision { parts: stretch.parts, enclosures: ENCLOSURES, enclosures_within: 0 };
        let on = |part| {
            let held = enclosed.on(i, part);
            told.iter().map(|&k| stand(held[k][0], held[k][1], limits[k].acceleration)).collect()
        };
        let enclose = |part: Interval| Enclosed { over: on(part), middle: on(Interval::point(part.middle())) };
        let found = ranges(Interval::new(0.0, stretch.length), subdivision, &sought, enclose);
        for (&k, range) in told.iter().zip(&found) {
            let (low, high) = limits[k].position;
            let mut take = |end: &Extreme, room: f64| {
                if least.as_ref().is_none_or(|known| room < known.room) {
                    least = Some(StopRoom { subject: names[k].clone(), at_s: stretch.start + end.time, room });
                }
            };
            take(&range.least, range.least.proved - low);
            take(&range.greatest, high - range.greatest.proved);
        }
    }
    least
}

/// The least of the distances in the boxes of stopping.
fn room_of_bodies(
    course: &dyn Course,
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
            let boxes = enclosed.on(i, part).into_iter().zip(limits).map(|(held, limits)| {
                let reached = held[0].hull(stand(held[0], held[1], limits.acceleration));
                (reached.middle(), 0.5 * reached.width() * (1.0 + WAY_ROUNDING))
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
    let covered = least.iter().filter(|(room, _)| *room >= 0.0).count();
    let (gap, (room, at_s)) = gaps.iter().zip(least).min_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
    Some(StopBodies {
        distances: gaps.len(),
        covered,
        least: StopRoom { subject: format!("{} of {}", gap.limit, gap.subject), at_s, room },
    })
}

fn parts_of(stretch: &Stretch) -> impl Iterator<Item = Interval> {
    let (parts, length) = (stretch.parts.max(1), stretch.length);
    let at = move |k: usize| if k == parts { length } else { length * (k as f64 / parts as f64) };
    (0..parts).map(move |k| Interval::new(at(k), at(k + 1)))
}

impl Stops {
    /// In lines.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for Stopping { coordinate, at_s, velocity, time_s, way } in &self.joints {
            text += &format!(
                "stopping at {} s, at the limit of acceleration from {} rad/s (m/s): {coordinate} stands after {} s and {} rad (m)\n",
                significant(*at_s, 4),
                significant(velocity.abs(), 3),
                significant(*time_s, 2),
                significant(*way, 2)
            );
        }
        if let Some(StopRoom { subject, at_s, room }) = &self.positions {
            let (size, at) = (significant(room.abs(), 2), significant(*at_s, 4));
            text += &match *room >= 0.0 {
                true => format!(
                    "the limits of position cover stopping at any instant: {size} rad (m) are left ({subject} at {at} s)\n"
                ),
                false => format!(
                    "the limits of position do not cover stopping: {subject} goes up to {size} rad (m) beyond, from {at} s\n"
                ),
            };
        }
        if let Some(StopBodies { distances, covered, least }) = &self.bodies {
            let at = significant(least.at_s, 4);
            text += &match covered == distances {
                true => format!(
                    "the room between bodies covers stopping at any instant: {} m are left ({} at {at} s)\n",
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
