//! Finds pairs of solids that are near each other. A cache per instant makes repeated evaluations fast while a search
//! changes a motion.
//!
//! The distance d of two bodies (a gap) changes at most by
//!
//! ```text
//! |d(q + dq) - d(q)| <= sum over the coordinates of |dq_k| R_k,   R_k = sum over the joints of |m_jk| reach_j
//! ```
//! m_jk: multiple of coordinate k in joint j. reach_j: largest distance of a point of the body from the axis of joint j at any
//! configuration, from the link lengths in between and the bounding ball of the body; 1 for a prismatic joint. So one evaluation
//! of a pair shows for which q no new evaluation is needed. In most other cases a lower bound along one direction suffices: the
//! direction between the nearest points that were found last.
//!
//! The results do not depend on the cache, except that the distance of near solids can differ by up to 0.02 mm.

use robot::{JointKind, Pose};

use crate::bodies::BodyShape;
use crate::clearance::{Against, Clearance, Gap};
use crate::half_space::HalfSpace;
use crate::kinematic_tree::axis;
use crate::separation::{Nearest, PosedSolid, Seed, apart_along, nearest};
use robot::vector::{Vector3, cross, dot, minus, norm, scaled};

/// Cached results for one instant of a motion, for the next evaluation. Empty before the first evaluation.
#[derive(Clone, Debug, Default)]
pub struct InstantCache {
    q: Vec<f64>,
    /// For every pair of solids, a lower bound of its room, m. Room: distance minus the least allowed distance (the bound of its
    /// gap).
    rooms: Vec<f64>,
    /// For every pair of solids, its nearest points; `None` if they were never searched.
    looks: Vec<Option<Box<NearestPoints>>>,
}

/// Cached result of a search for the nearest points of two solids.
#[derive(Clone, Debug)]
struct NearestPoints {
    /// Unit vector from the second solid to the first.
    along: Vector3,
    seed: Seed,
}

/// The rates of change of the distances hold for |coordinate| up to this factor times its largest value in the sampled poses.
const SAMPLED_RANGE_FACTOR: f64 = 2.0;

/// If the cached room (distance minus bound) exceeds this share of the requested room, a cheap bound is tried first: the lower
/// bound along the cached direction. Otherwise the nearest points are searched at once.
const HOPEFUL_SHARE: f64 = 0.5;

impl Clearance {
    /// Largest rate of change of each gap (distance) with each coordinate (m/rad or m/m) while |coordinate| is at most its
    /// value in `ranges`.
    pub(crate) fn rates(&self, ranges: &[f64]) -> Vec<Vec<f64>> {
        let of_gap = |gap: &Gap| {
            let mut by_coordinate = vec![0.0; ranges.len()];
            let fixed_normal = match gap.against {
                Against::HalfSpace(wall) => Some(self.half_spaces[wall].normal),
                Against::Body(_) => None,
            };
            let own: Vec<&BodyShape> = gap.shapes.iter().map(|&s| &self.bodies[gap.body].shapes[s]).collect();
            let other: Vec<&BodyShape> = match gap.against {
                Against::Body(b) => self.bodies[b].shapes.iter().collect(),
                Against::HalfSpace(_) => vec![],
            };
            for (joints, shapes) in gap.joints.iter().zip([own, other]) {
                let mut reach = shapes.iter().map(|s| norm(s.centre) + s.ball).fold(0.0, f64::max);
                for &j in joints {
                    let rate = match self.tree.kind(j) {
                        JointKind::Fixed => 0.0,
                        JointKind::Prismatic => 1.0,
                        // A joint that turns about the normal of a half-space moves no point along this normal.
                        JointKind::Revolute => {
                            reach * fixed_normal.zip(self.tree.standing_axis(j)).map_or(1.0, |(n, z)| norm(cross(n, z)))
                        }
                    };
                    self.tree.terms(j).iter().for_each(|(k, m)| by_coordinate[*k] += m.abs() * rate);
                    reach += self.tree.length(j, ranges);
                }
            }
            by_coordinate
        };
        self.gaps.iter().map(of_gap).collect()
    }

    /// The range of each coordinate for which [`Self::rates`] are computed, rad (m): a multiple of the largest absolute value of
    /// the coordinate in `poses`.
    pub(crate) fn ranges(count: usize, poses: &[Vec<f64>]) -> Vec<f64> {
        (0..count).map(|k| SAMPLED_RANGE_FACTOR * poses.iter().map(|q| q[k].abs()).fold(0.0, f64::max)).collect()
    }

    /// Lowers the cached rooms (distance minus bound) by the largest possible displacement since the last evaluation. Clears the
    /// cache if a coordinate is outside the range for which this displacement is known.
    fn recall(&self, q: &[f64], known: &mut InstantCache) {
        let is_known = known.q.len() == q.len() && q.iter().zip(&self.given_ranges).all(|(x, most)| x.abs() <= *most);
        if !is_known {
            let count = self.gaps.iter().map(|gap| self.pair_count(gap)).sum();
            known.rooms.clear();
            known.rooms.resize(count, f64::NEG_INFINITY);
            known.looks.resize(count, None);
            known.q = q.to_vec();
            return;
        }
        known.q.iter_mut().zip(q).for_each(|(old, new)| *old = (*new - *old).abs());
        let mut at = 0;
        for (gap, rate) in self.gaps.iter().zip(&self.rates) {
            let moved: f64 = rate.iter().zip(&known.q).map(|(rate, step)| rate * step).sum();
            let count = self.pair_count(gap);
            known.rooms[at..at + count].iter_mut().for_each(|room| *room -= moved);
            at += count;
        }
        known.q.copy_from_slice(q);
    }

    /// Number of pairs of solids of the two bodies of a gap.
    fn pair_count(&self, gap: &Gap) -> usize {
        match gap.against {
            Against::HalfSpace(_) => gap.shapes.len(),
            Against::Body(other) => gap.shapes.len() * self.bodies[other].shapes.len(),
        }
    }

    /// Calls `each` for every pair of solids whose room (distance minus the bound of its gap) is less than `within`, m.
    ///
    /// `known`: the cache of this instant. Arguments of `each`: index of the gap; room, m; derivative of the room by each
    /// coordinate, m/rad (m/m).
    pub fn near(&self, q: &[f64], within: f64, known: &mut InstantCache, each: &mut dyn FnMut(usize, f64, &[f64])) {
        self.recall(q, known);
        // Most calls end here: no pair can have come nearer than `within` since the last evaluation.
        if known.rooms.iter().all(|room| *room > within) {
            return;
        }
        let poses = self.tree.poses(q);
        let mut slope = vec![0.0; q.len()];
        let (mut rooms, mut looks) = (&mut known.rooms[..], &mut known.looks[..]);
        for (g, gap) in self.gaps.iter().enumerate() {
            let count = self.pair_count(gap);
            let (own_rooms, own_looks);
            (own_rooms, rooms) = rooms.split_at_mut(count);
            (own_looks, looks) = looks.split_at_mut(count);
            if own_rooms.iter().all(|room| *room > within) {
                continue;
            }
            match gap.against {
                Against::HalfSpace(wall) => {
                    let wall = &self.half_spaces[wall];
                    self.near_wall((g, gap), wall, within, &poses, own_rooms, &mut slope, each);
                }
                Against::Body(_) => {
                    self.near_body((g, gap), within, &poses, (own_rooms, own_looks), &mut slope, each);
                }
            }
        }
    }

    fn near_wall(
        &self,
        (g, gap): (usize, &Gap),
        &HalfSpace { normal, offset, .. }: &HalfSpace,
        within: f64,
        poses: &[Pose],
        rooms: &mut [f64],
        slope: &mut [f64],
        each: &mut dyn FnMut(usize, f64, &[f64]),
    ) {
        let body = &self.bodies[gap.body];
        for (&s, known) in gap.shapes.iter().zip(rooms).filter(|(_, room)| **room <= within) {
            let shape = &body.shapes[s];
            // The bounding ball of the shape gives a fast test: if the ball is far from the plane, the shape is far too.
            *known = dot(normal, self.centre(body, shape, poses)) - shape.ball - offset - gap.bound;
            if *known > within {
                continue;
            }
            let on_body = self.standing(body, shape, poses).support(scaled(normal, -1.0));
            *known = dot(normal, on_body) - shape.solid.radius - offset - gap.bound;
            if *known < within {
                self.slope(&gap.joints[0], normal, on_body, poses, slope);
                each(g, *known, slope);
                slope.fill(0.0);
            }
        }
    }

    fn near_body(
        &self,
        (g, gap): (usize, &Gap),
        within: f64,
        poses: &[Pose],
        (rooms, looks): (&mut [f64], &mut [Option<Box<NearestPoints>>]),
        slope: &mut [f64],
        each: &mut dyn FnMut(usize, f64, &[f64]),
    ) {
        let Against::Body(other) = gap.against else { return };
        let (body, other) = (&self.bodies[gap.body], &self.bodies[other]);
        let all = gap.shapes.iter().flat_map(|s| other.shapes.iter().map(move |opposite| (&body.shapes[*s], opposite)));
        for (((shape, opposite), room), look) in all.zip(rooms).zip(looks).filter(|((_, room), _)| **room <= within) {
            let towards = minus(self.centre(body, shape, poses), self.centre(other, opposite, poses));
            // The bounding balls are tested first, because most pairs are far from each other.
            let between_balls = norm(towards) - shape.ball - opposite.ball - gap.bound;
            if between_balls > within {
                *room = between_balls;
                continue;
            }
            let both = [self.standing(body, shape, poses), self.standing(other, opposite, poses)];
            if let Some((reached, n, [on_a, on_b])) = near_pair(both, towards, gap.bound, within, room, look) {
                self.slope(&gap.joints[0], n, on_a, poses, slope);
                self.slope(&gap.joints[1], scaled(n, -1.0), on_b, poses, slope);
                each(g, reached, slope);
                slope.fill(0.0);
            }
        }
    }

    /// Adds to `slope` the derivative of n . x with respect to each coordinate. x: position of `point`, which `joints` move.
    fn slope(&self, joints: &[usize], n: Vector3, point: Vector3, poses: &[Pose], slope: &mut [f64]) {
        for &j in joints {
            let z = axis(&poses[j]);
            let rate = match self.tree.kind(j) {
                JointKind::Fixed => continue,
                JointKind::Prismatic => dot(n, z),
                JointKind::Revolute => dot(n, cross(z, minus(point, poses[j].position))),
            };
            self.tree.terms(j).iter().for_each(|(k, m)| slope[*k] += m * rate);
        }
    }
}

/// The room (distance minus `bound`, m) of two solids, the unit vector from b to a, and the nearest points. `None` if the room
/// is not below `within`. `room`, `look`: cached results, which are updated.
fn near_pair(
    [a, b]: [PosedSolid; 2],
    towards: Vector3,
    bound: f64,
    within: f64,
    room: &mut f64,
    look: &mut Option<Box<NearestPoints>>,
) -> Option<(f64, Vector3, [Vector3; 2])> {
    // The lower bound of the distance along the cached direction, or else along the line of centres, is tested first. For most
    // pairs this bound proves that the two solids are far apart.
    let along = look.as_ref().map_or(towards, |look| look.along);
    if look.is_none() || *room > HOPEFUL_SHARE * within {
        *room = apart_along(a, b, along) - bound;
        if *room > within {
            return None;
        }
    }
    let look = look.get_or_insert_with(|| Box::new(NearestPoints { along, seed: Seed::default() }));
    match nearest(a, b, towards, within + bound, &mut look.seed) {
        Nearest::Beyond(at_least, along) => {
            (*room, look.along) = (at_least - bound, along);
            None
        }
        Nearest::At(found) => {
            (*room, look.along) = (found.at_least - bound, found.direction);
            let reached = found.reached - bound;
            (reached < within).then_some((reached, found.direction, found.nearest))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::gaps::{ClearanceRules, FloorRule, Situation};

    /// A robot with three revolute joints, a prismatic joint at the end, and a fingertip.
    const ARM: &str = r#"<robot name="arm">
  <link name="post"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="q1" type="revolute"><parent link="post"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <link name="upper"><collision><origin xyz="0.4 0 0" rpy="0 1.5707963267948966 0"/><geometry><cylinder radius="0.05" length="0.5"/></geometry></collision></link>
  <joint name="q2" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.8 0 0.1"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <link name="fore"><collision><origin xyz="0.3 0 0"/><geometry><box size="0.4 0.1 0.08"/></geometry></collision></link>
  <joint name="q3" type="prismatic"><parent link="fore"/><child link="rod"/><origin xyz="0.5 0 0"/><axis xyz="1 0 0"/>
    <limit lower="-0.2" upper="0.2" velocity="1" effort="1"/></joint>
  <link name="rod"><collision><origin xyz="0.1 0 0"/><geometry><box size="0.2 0.02 0.02"/></geometry></collision></link>
  <joint name="q4" type="revolute"><parent link="rod"/><child link="tip"/><origin xyz="0.25 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <link name="tip"><collision><origin xyz="0.06 0 0"/><geometry><capsule radius="0.02" length="0.08"/></geometry></collision></link>
</robot>"#;

    #[test]
    fn what_is_remembered_changes_nothing() {
        let robot = robot::format::read_urdf(ARM, "arm.urdf").unwrap();
        let wave = |k: usize, m: f64| (m * k as f64).sin();
        let pose = |k: usize| vec![3.0 * wave(k, 0.7), 3.0 * wave(k, 1.3), 0.2 * wave(k, 2.1), 3.0 * wave(k, 0.9)];
        let poses: Vec<Vec<f64>> = (0..300).map(pose).collect();
        let situation = Situation { rest: vec![0.0; 4], zero: vec![0.0; 4], moves: vec![true; 4], poses };
        let rules = ClearanceRules { distance: Some(0.01), floor: FloorRule::At(-0.5), ..ClearanceRules::default() };
        let clearance = Clearance::new(&robot, Path::new("."), &rules, &situation).unwrap();
        let (mut known, mut q) = (InstantCache::default(), pose(0));
        let (mut visits, mut skipped) = (0, 0);
        for step in 0..4000 {
            // Most steps are small. Some steps leave the sampled range.
            let size = [1e-3, 1e-3, 1e-2, 0.3][step % 4];
            q.iter_mut().enumerate().for_each(|(k, x)| *x += size * wave(step + 31 * k, 1.7));
            q[2] = q[2].clamp(-0.45, 0.45);
            if step % 500 == 499 {
                q = pose(step);
            }
            let look = |known: &mut InstantCache| {
                let mut seen: Vec<(usize, f64, Vec<f64>)> = vec![];
                clearance.near(&q, 0.1, known, &mut |g, room, slope| seen.push((g, room, slope.to_vec())));
                seen
            };
            let afresh = look(&mut InstantCache::default());
            skipped += usize::from(known.rooms.iter().filter(|room| **room > 0.1).count() > 0);
            let again = look(&mut known);
            visits += again.len();
            let gaps = |seen: &[(usize, f64, Vec<f64>)]| seen.iter().map(|s| s.0).collect::<Vec<_>>();
            assert_eq!(gaps(&again), gaps(&afresh), "{step}");
            for (a, b) in again.iter().zip(&afresh) {
                // Allowed difference: at a round surface, a search is accurate to a few micrometres without the cache, and to
                // ten micrometres with the cache.
                assert!((a.1 - b.1).abs() < 2e-5 || a.1 < 0.0, "{step}: {a:?} {b:?}");
            }
        }
        assert!(visits > 2000 && skipped > 3000, "{visits} {skipped}");
    }
}
