//! How far two solids are apart, with a proof.
//!
//! GJK [Gilbert, Johnson, Keerthi 1988] finds the nearest points. Whatever it finds, every unit vector n gives a bound:
//!
//! ```text
//! distance(A, B) >= min over A of n.x - max over B of n.x
//! ```
//! Both sides are taken at support points. So the distance that GJK reports is not relied on. Only its direction is
//! used, and the bound that this direction proves is computed anew.

use parry3d_f64::math::{Pose as ParryPose, Vector};
use parry3d_f64::query::details::closest_points_support_map_support_map_with_params;
use parry3d_f64::query::gjk::{GJKResult, VoronoiSimplex};
use parry3d_f64::shape::SupportMap;
use robot::Pose;

use crate::solid::Solid;
use robot::vector::{Vector3, dot, minus, norm, plus, scaled, turned, turned_back};

/// A solid where it stands.
#[derive(Clone, Copy, Debug)]
pub struct Standing<'a> {
    /// About its own frame.
    pub solid: &'a Solid,
    /// Of its frame in the base frame.
    pub pose: Pose,
}

/// Two solids apart; negative where they overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// Lower bound of the distance, m, proved but for rounding.
    pub at_least: f64,
    /// Distance of two points of the solids, m. Where the cores overlap, it equals `at_least`.
    pub reached: f64,
    /// Unit vector from b to a.
    pub direction: Vector3,
    /// The nearest points of the cores of a and of b.
    pub nearest: [Vector3; 2],
}

impl Standing<'_> {
    /// The point of the core farthest along a direction, all in the base frame.
    pub fn support(&self, along: Vector3) -> Vector3 {
        let own = self.solid.core.support(turned_back(&self.pose.rotation, along));
        plus(self.pose.position, turned(&self.pose.rotation, own))
    }

    /// The least of n.x over the solid; n is a unit vector.
    pub(crate) fn least_along(&self, n: Vector3) -> f64 {
        dot(n, self.support(scaled(n, -1.0))) - self.solid.radius
    }
}

/// A lower bound of how far `a` is from `b`, m, along one direction from b to a: far cheaper than their distance.
pub(crate) fn apart_along(a: Standing, b: Standing, towards_a: Vector3) -> f64 {
    let length = norm(towards_a);
    if length <= f64::EPSILON {
        return f64::NEG_INFINITY;
    }
    let n = scaled(towards_a, 1.0 / length);
    a.least_along(n) + b.least_along(scaled(n, -1.0))
}

/// A solid seen in the base frame, so that both solids have the same frame.
struct InBase<'a>(Standing<'a>);

impl SupportMap for InBase<'_> {
    fn local_support_point(&self, along: Vector) -> Vector {
        Vector::from_array(self.0.support(along.to_array()))
    }
}

/// How far `a` is from `b`; `towards_a`: a direction to begin with, from b to a.
pub fn separation(a: Standing, b: Standing, towards_a: Vector3) -> Separation {
    let mut simplex = VoronoiSimplex::new();
    let start = Some(Vector::from_array(towards_a)).filter(|v| v.length() > 0.0);
    let (in_base, together) = ((InBase(a), InBase(b)), ParryPose::identity());
    let found = closest_points_support_map_support_map_with_params(
        &together,
        &in_base.0,
        &in_base.1,
        f64::MAX,
        &mut simplex,
        start,
    );
    let radii = a.solid.radius + b.solid.radius;
    let apart = match found {
        GJKResult::ClosestPoints(on_a, on_b, _) => Some([on_a.to_array(), on_b.to_array()]),
        _ => None,
    };
    let between = apart.map(|[on_a, on_b]| minus(on_a, on_b));
    let length = between.map_or(0.0, norm);
    let proved = |n: Vector3| {
        let (on_a, on_b) = (a.support(scaled(n, -1.0)), b.support(n));
        (dot(n, on_a) - dot(n, on_b) - radii, [on_a, on_b])
    };
    if let (Some(nearest), Some(between)) = (apart, between)
        && length > f64::EPSILON
    {
        let direction = scaled(between, 1.0 / length);
        return Separation { at_least: proved(direction).0, reached: length - radii, direction, nearest };
    }
    // The cores overlap. Every direction bounds how deep, and the best of a few is taken.
    let unit = |v: Vector3| (norm(v) > f64::EPSILON).then(|| scaled(v, 1.0 / norm(v)));
    let axes = [a, b].into_iter().flat_map(|s| {
        (0..3).flat_map(move |k| {
            let axis = s.pose.rotation.map(|row| row[k]);
            [axis, scaled(axis, -1.0)]
        })
    });
    let tried = unit(towards_a).into_iter().chain(axes).map(|n| (n, proved(n)));
    let best = tried.reduce(|best, other| if other.1.0 > best.1.0 { other } else { best });
    let (direction, (at_least, nearest)) = best.unwrap_or(([0.0, 0.0, 1.0], (-radii, [a.pose.position; 2])));
    // Touching cores have distance zero, whatever rounding says.
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
        separation(Standing { solid: a, pose: pose_a }, Standing { solid: b, pose: pose_b }, towards)
    }

    /// Distances that geometry tells, from both sides.
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
            // Crossed cylinders: their axes two apart.
            (&cylinder, at([0.0; 3]), &cylinder, quarter, 1.6),
            (&cylinder, at([0.0, 0.0, 3.0]), &cube, at([0.0; 3]), 1.5),
        ] {
            let found = apart(a, pose_a, b, pose_b);
            // The search stops within a few roundings of the size of the solids.
            assert!((found.reached - expected).abs() < 1e-9, "{found:?} {expected}");
            assert!(found.at_least <= expected + 1e-12 && found.at_least > expected - 1e-7, "{found:?} {expected}");
        }
    }

    /// Overlap is negative, and the bound holds it.
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
