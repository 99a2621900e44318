//! The distance between two solids, with a proven lower bound.
//!
//! GJK [Gilbert, Johnson, Keerthi 1988] finds the nearest points. Independently of GJK, every unit vector n gives a lower bound:
//!
//! ```text
//! distance(A, B) >= min over A of n.x - max over B of n.x
//! ```
//! Both terms follow from support points. Only the direction of the GJK result is used. The bound along this direction is
//! computed independently, so a wrong distance from GJK cannot lead to a wrong bound.

use parry3d_f64::math::{Pose as ParryPose, Vector};
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points};
use parry3d_f64::shape::SupportMap;
use robot::Pose;

use crate::solid::{Core, Solid};
use robot::vector::{Vector3, dot, minus, norm, plus, scaled, turned, turned_back};

/// Required accuracy (m) of the nearest points if a search starts from a seed (the result of an earlier search). If the
/// accuracy is not reached, the search is repeated without the seed. A smaller value is not possible, because at the round side
/// of a cylinder any search stops some micrometres early.
const FOUND_WITHIN_M: f64 = 1e-5;

/// A solid together with its pose.
#[derive(Clone, Copy, Debug)]
pub struct PosedSolid<'a> {
    /// The solid in its own frame.
    pub solid: &'a Solid,
    /// Pose of the solid's frame in the base frame.
    pub pose: Pose,
}

/// The distance between two solids a and b; negative if they overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// Lower bound of the distance, m. It is proven up to rounding.
    pub at_least: f64,
    /// Distance between two points of the solids, m: an upper bound. If the cores overlap, it equals `at_least`.
    pub reached: f64,
    /// Unit vector from b to a, in the base frame.
    pub direction: Vector3,
    /// The nearest point of the core of a, and the nearest point of the core of b.
    pub nearest: [Vector3; 2],
}

impl PosedSolid<'_> {
    /// The point of the core (the solid without its radius) that is farthest along a direction. Direction and point are in the
    /// base frame.
    pub fn support(&self, along: Vector3) -> Vector3 {
        let own = self.solid.core.support(turned_back(&self.pose.rotation, along));
        plus(self.pose.position, turned(&self.pose.rotation, own))
    }

    /// Smallest value of n.x over the points x of the solid, m. n: unit vector in the base frame.
    pub(crate) fn least_along(&self, n: Vector3) -> f64 {
        dot(n, self.support(scaled(n, -1.0))) - self.solid.radius
    }
}

/// A lower bound of the distance between `a` and `b` (m) from one direction from b to a. It is far faster than [`separation`].
pub(crate) fn apart_along(a: PosedSolid, b: PosedSolid, towards_a: Vector3) -> f64 {
    let length = norm(towards_a);
    if length <= f64::EPSILON {
        return f64::NEG_INFINITY;
    }
    let n = scaled(towards_a, 1.0 / length);
    a.least_along(n) + b.least_along(scaled(n, -1.0))
}

/// The distance between `a` and `b`. `towards_a`: start direction of the search, from b to a.
pub fn separation(a: PosedSolid, b: PosedSolid, towards_a: Vector3) -> Separation {
    match nearest(a, b, towards_a, f64::INFINITY, &mut Seed::default()) {
        Nearest::At(found) => found,
        // This case does not occur, because no distance is larger than infinity.
        Nearest::Beyond(at_least, direction) => {
            let nearest = [a.pose.position, b.pose.position];
            Separation { at_least, reached: at_least, direction, nearest }
        }
    }
}

/// A lower bound of the distance between a and b (m) and the two support points that prove it. n: unit vector from b to a.
fn proved(a: PosedSolid, b: PosedSolid, n: Vector3) -> (f64, [Vector3; 2]) {
    let (on_a, on_b) = (a.support(scaled(n, -1.0)), b.support(n));
    (dot(n, on_a) - dot(n, on_b) - a.solid.radius - b.solid.radius, [on_a, on_b])
}

/// The start of a search for the nearest points: up to three pairs of points of the two cores (solids without their radii). Each
/// point is in the frame of its solid.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seed {
    count: usize,
    points: [[Vector3; 2]; 3],
}

/// The result of a search for the nearest points of two solids.
pub(crate) enum Nearest {
    /// The distance is larger than requested. Fields: a lower bound of the distance (m) and the unit vector from b to a.
    Beyond(f64, Vector3),
    /// The distance of the solids, which is not larger than requested.
    At(Separation),
}

/// The core of solid b (the solid without its radius), with its pose in the frame of solid a.
struct Seen<'a> {
    core: &'a Core,
    pose: Pose,
}

impl SupportMap for Seen<'_> {
    fn local_support_point(&self, along: Vector) -> Vector {
        let own = self.core.support(turned_back(&self.pose.rotation, along.to_array()));
        Vector::from_array(plus(self.pose.position, turned(&self.pose.rotation, own)))
    }

    /// Both cores are already in one frame, so the transform from parry3d is not used.
    fn support_point(&self, _: &ParryPose, along: Vector) -> Vector {
        self.local_support_point(along)
    }
}

/// Computes the distance between `a` and `b` and the nearest points, unless the distance is larger than `within`, m.
///
/// `seed`: result of an earlier search for these two solids; it is updated. With a good seed the search ends after one
/// or two steps.
pub(crate) fn nearest(a: PosedSolid, b: PosedSolid, towards_a: Vector3, within: f64, seed: &mut Seed) -> Nearest {
    let radii = a.solid.radius + b.solid.radius;
    let was_seeded = seed.count > 0;
    let rotation = a.pose.rotation;
    let in_a = |x: Vector3| Vector::from_array(x);
    let offset = turned_back(&rotation, minus(b.pose.position, a.pose.position));
    let columns = [0, 1, 2].map(|k| turned_back(&rotation, b.pose.rotation.map(|row| row[k])));
    let pose = Pose { rotation: [0, 1, 2].map(|i| [0, 1, 2].map(|k| columns[k][i])), position: offset };
    let seen = Seen { core: &b.solid.core, pose };
    // Start points of GJK in the Minkowski difference of the cores: the points of the seed, or the farthest point along the line
    // of centres.
    let mut simplex = VoronoiSimplex::new();
    let point =
        |[on_a, on_b]: [Vector3; 2]| CsoPoint::new(in_a(on_a), in_a(plus(pose.position, turned(&pose.rotation, on_b))));
    match &seed.points[..seed.count] {
        [] => {
            let away = scaled(turned_back(&rotation, towards_a), -1.0);
            let along = if norm(away) > 0.0 { scaled(away, 1.0 / norm(away)) } else { [1.0, 0.0, 0.0] };
            simplex.reset(CsoPoint::from_shapes(&ParryPose::identity(), &a.solid.core, &seen, in_a(along)));
        }
        [first, others @ ..] => {
            simplex.reset(point(*first));
            others.iter().for_each(|both| {
                simplex.add_point(point(*both));
            });
        }
    }
    let most = (within + radii).min(f64::MAX);
    let found = closest_points(&ParryPose::identity(), &a.solid.core, &seen, most, true, &mut simplex);
    let in_b = |x: Vector3| turned_back(&pose.rotation, minus(x, pose.position));
    seed.count = (simplex.dimension() + 1).min(seed.points.len());
    for (k, place) in seed.points.iter_mut().enumerate().take(seed.count) {
        let point = simplex.point(k);
        *place = [point.orig1.to_array(), in_b(point.orig2.to_array())];
    }
    let in_base = |x: Vector3| plus(a.pose.position, turned(&rotation, x));
    match found {
        GJKResult::ClosestPoints(on_a, on_b, _) => {
            let between = (on_a - on_b).to_array();
            let length = norm(between);
            if length > f64::EPSILON {
                let direction = turned(&rotation, scaled(between, 1.0 / length));
                let (reached, nearest) = (length - radii, [in_base(on_a.to_array()), in_base(on_b.to_array())]);
                let (at_least, _) = proved(a, b, direction);
                if was_seeded && reached - at_least > FOUND_WITHIN_M {
                    seed.count = 0;
                    return self::nearest(a, b, towards_a, within, seed);
                }
                return Nearest::At(Separation { at_least, reached, direction, nearest });
            }
        }
        // GJK returns the direction from a to b in which it found that the solids are far apart.
        GJKResult::NoIntersection(towards_b) if within < f64::INFINITY => {
            let direction = turned(&rotation, scaled(towards_b.to_array(), -1.0));
            let (at_least, _) = proved(a, b, direction);
            if at_least > within {
                return Nearest::Beyond(at_least, direction);
            }
        }
        _ => {}
    }
    seed.count = 0;
    Nearest::At(overlap(a, b, towards_a))
}

/// The separation of two solids with overlapping cores. Every direction gives a lower bound of the (negative) distance. Some
/// directions are tried, and the best bound is used.
fn overlap(a: PosedSolid, b: PosedSolid, towards_a: Vector3) -> Separation {
    let radii = a.solid.radius + b.solid.radius;
    let unit = |v: Vector3| (norm(v) > f64::EPSILON).then(|| scaled(v, 1.0 / norm(v)));
    let axes = [a, b].into_iter().flat_map(|s| {
        (0..3).flat_map(move |k| {
            let axis = s.pose.rotation.map(|row| row[k]);
            [axis, scaled(axis, -1.0)]
        })
    });
    let tried = unit(towards_a).into_iter().chain(axes).map(|n| (n, proved(a, b, n)));
    let best = tried.reduce(|best, other| if other.1.0 > best.1.0 { other } else { best });
    let (direction, (at_least, nearest)) = best.unwrap_or(([0.0, 0.0, 1.0], (-radii, [a.pose.position; 2])));
    // The cores touch, so their distance is at most zero; rounding must not make it positive.
    let at_least = at_least.min(-radii);
    Separation { at_least, reached: at_least, direction, nearest }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::Core;

    fn at(position: Vector3) -> Pose {
        Pose { position, ..Pose::IDENTITY }
    }

    fn ball(radius: f64) -> Solid {
        Solid { core: Core::Point, radius }
    }

    fn apart(a: &Solid, pose_a: Pose, b: &Solid, pose_b: Pose) -> Separation {
        let towards = minus(pose_a.position, pose_b.position);
        separation(PosedSolid { solid: a, pose: pose_a }, PosedSolid { solid: b, pose: pose_b }, towards)
    }

    #[test]
    fn distances_of_known_places() {
        let sharp = |core| Solid { core, radius: 0.0 };
        let cube = sharp(Core::Cuboid { half: [0.5; 3] });
        let cylinder = sharp(Core::Cylinder { radius: 0.2, half: 1.0 });
        let corners = (0..8).map(|k: u8| [1, 2, 4].map(|bit| if k & bit == 0 { 0.5 } else { -0.5 })).collect();
        let hull = sharp(Core::Hull(crate::hull::Hull::new(corners)));
        let quarter =
            Pose { rotation: [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]], position: [2.0, 0.0, 0.0] };
        let diagonal = 3.0_f64.sqrt();
        for (a, pose_a, b, pose_b, expected) in [
            (&ball(0.3), at([1.0, 0.0, 0.0]), &ball(0.2), at([0.0, 0.0, 0.0]), 0.5),
            (&cube, at([2.0, 2.0, 2.0]), &cube, at([0.0; 3]), diagonal),
            (&hull, at([2.0, 2.0, 2.0]), &cube, at([0.0; 3]), diagonal),
            (&ball(0.25), at([1.0, 1.0, 1.0]), &hull, at([0.0; 3]), 0.5 * diagonal - 0.25),
            // Two crossed cylinders with a distance of 2 between their axes.
            (&cylinder, at([0.0; 3]), &cylinder, quarter, 1.6),
            (&cylinder, at([0.0, 0.0, 3.0]), &cube, at([0.0; 3]), 1.5),
        ] {
            let found = apart(a, pose_a, b, pose_b);
            // Allowed error: the search stops at an error of a few roundings of numbers as large as the solids.
            assert!((found.reached - expected).abs() < 1e-9, "{found:?} {expected}");
            assert!(found.at_least <= expected + 1e-12 && found.at_least > expected - 1e-7, "{found:?} {expected}");
        }
    }

    #[test]
    fn overlaps_are_negative() {
        let found = apart(&ball(0.3), at([0.4, 0.0, 0.0]), &ball(0.2), at([0.0; 3]));
        assert!((found.reached + 0.1).abs() < 1e-12, "{found:?}");
        let cube = Solid { core: Core::Cuboid { half: [0.5; 3] }, radius: 0.0 };
        let found = apart(&cube, at([0.8, 0.1, 0.0]), &cube, at([0.0; 3]));
        assert!((found.reached + 0.2).abs() < 1e-12, "{found:?}");
        assert!(apart(&cube, at([0.0; 3]), &cube, at([0.0; 3])).reached < -0.9);
    }
}
