//! A convex solid: a core together with all points within a radius of the core.
//!
//! ```text
//! S = core + ball(radius),   support: the point of the core farthest along a direction
//! ```
//! A ball is a point with a radius. A capsule is a segment with a radius. For a mesh, the core is the hull of some of its
//! vertices, and the radius is the smallest with which the solid contains the other vertices ([`Solid::around`]). So the solid
//! contains the hull of all vertices. Vertices are added to the core until the radius is below a tenth of a millimetre, or until
//! the core has too many vertices. The radius is kept small because a body that is too large restricts the motions.
//!
//! Not here: the pose of a solid.

use parry3d_f64::math::{Pose as ParryPose, Vector};
use parry3d_f64::query::details::closest_points_support_map_support_map_with_params;
use parry3d_f64::query::gjk::{GJKResult, VoronoiSimplex};
use parry3d_f64::shape::SupportMap;
use robot::CollisionShape;

use robot::vector::{Vector3, dot, minus, norm, scaled};

use crate::hull::{Hull, farthest};

/// A convex solid in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// The core: the solid without the radius.
    pub core: Core,
    /// Distance by which the solid extends beyond the core, m.
    pub radius: f64,
}

/// The shape of the core of a solid; lengths in m.
#[derive(Clone, Debug, PartialEq)]
pub enum Core {
    /// A point at the origin.
    Point,
    /// A segment along z, from -half to half.
    Segment {
        /// Half of the length of the segment.
        half: f64,
    },
    /// A cuboid with its centre at the origin.
    Cuboid {
        /// Half of the edge lengths along x, y and z.
        half: Vector3,
    },
    /// A cylinder along z, from -half to half.
    Cylinder {
        /// Radius of the circular cross-section.
        radius: f64,
        /// Half of the length of the cylinder.
        half: f64,
    },
    /// The convex hull of points.
    Hull(Hull),
}

/// Number of directions of the first step. The outermost vertices of a mesh in these directions are put into the core.
const KEPT_DIRECTIONS: usize = 400;
/// Vertices are added to the core until all other vertices are within this distance of the core, m.
const NEAR_ENOUGH_M: f64 = 1e-4;
/// No more vertices are added to a core that has this number of vertices.
const MAX_KEPT: usize = 1000;
/// In one step, vertices are added to the core for all points whose distance from the core exceeds this share of the largest
/// distance.
const WORST_SHARE: f64 = 0.7;
/// Two directions count as equal if the cosine of the angle between them is larger than this value. Then vertices are added for
/// only one of the two.
const SAME_DIRECTION: f64 = 0.995;

/// A mesh is scaled up before distances are measured if all its coordinates are below this value, m.
const RESCALED_MESH_SIZE_M: f64 = 1e-3;

impl Solid {
    /// The solid of a box, cylinder, sphere or capsule; `None` for a shape that needs a file.
    pub(crate) fn of_primitive(shape: &CollisionShape) -> Option<Solid> {
        let sharp = |core| Some(Solid { core, radius: 0.0 });
        match shape {
            CollisionShape::Box { size } => sharp(Core::Cuboid { half: size.map(|x| 0.5 * x) }),
            CollisionShape::Cylinder { radius, length } => {
                sharp(Core::Cylinder { radius: *radius, half: 0.5 * length })
            }
            CollisionShape::Capsule { radius, length } => {
                Some(Solid { core: Core::Segment { half: 0.5 * length }, radius: *radius })
            }
            CollisionShape::Sphere { radius } => Some(Solid { core: Core::Point, radius: *radius }),
            CollisionShape::Mesh { .. } | CollisionShape::Unread { .. } => None,
        }
    }

    /// A solid that contains all these points and is only slightly larger than their hull; `None` without points.
    ///
    /// The core is the hull of the points that are outermost in many directions. If other points are outside of the core, the
    /// outermost points in their directions are added. The radius is the largest distance of a point from the core.
    pub fn around(points: &[Vector3]) -> Option<Solid> {
        let mut kept: Vec<usize> = directions(KEPT_DIRECTIONS).filter_map(|along| farthest(points, along)).collect();
        kept.sort_unstable();
        kept.dedup();
        if kept.is_empty() {
            return None;
        }
        let size = points.iter().flatten().fold(0.0, |size: f64, x| size.max(x.abs()));
        // GJK treats a point nearer than 2e-15 to the hull as inside it, so a small mesh is scaled up before
        // distances are measured.
        let scale = if size > 0.0 && size < RESCALED_MESH_SIZE_M {
            2.0_f64.powi((-size.log2().ceil() as i32).min(1000))
        } else {
            1.0
        };
        // The hull only grows. So the earlier distances of other points from it remain upper bounds.
        let mut hull = hull_of(points, &kept, scale);
        let measured = |hull: &Core, k: usize| Outside::of(hull, k, points[k], scale);
        let others = (0..points.len()).filter(|k| kept.binary_search(k).is_err());
        let mut outside: Vec<Outside> = others.map(|k| measured(&hull, k)).collect();
        loop {
            let most = outside.iter().map(|o| o.distance).fold(0.0, f64::max);
            if most <= NEAR_ENOUGH_M || kept.len() >= MAX_KEPT {
                break;
            }
            outside.sort_by(|a, b| b.distance.total_cmp(&a.distance));
            let added = standing_out(points, &kept, &outside, NEAR_ENOUGH_M.max(WORST_SHARE * most));
            // Only rounding leads here: a point is outside in some direction, but no new point is outermost in this direction.
            if added.is_empty() {
                break;
            }
            kept.extend(added);
            kept.sort_unstable();
            hull = hull_of(points, &kept, scale);
            outside.retain(|o| kept.binary_search(&o.point).is_err());
            outside.iter_mut().filter(|o| o.distance > NEAR_ENOUGH_M).for_each(|o| *o = measured(&hull, o.point));
        }
        let found = outside.iter().map(|o| o.distance).fold(0.0, f64::max);
        let solid = Solid { core: hull_of(points, &kept, 1.0), radius: found };
        // GJK can fail for a nearly flat hull. So the radius is also chosen to cover each point along its direction from the
        // centre.
        let (centre, _) = solid.ball();
        let stands_out = |p: &Vector3| {
            let out = minus(*p, centre);
            let along = scaled(out, 1.0 / norm(out));
            dot(minus(*p, solid.core.support(along)), along)
        };
        let radius = points.iter().map(stands_out).fold(found, f64::max);
        Some(Solid { radius, ..solid })
    }

    /// A ball that contains the solid: its centre in the frame of the solid (m) and its radius (m).
    pub fn ball(&self) -> (Vector3, f64) {
        let (centre, reach) = match &self.core {
            Core::Point => ([0.0; 3], 0.0),
            Core::Segment { half } => ([0.0; 3], *half),
            Core::Cuboid { half } => ([0.0; 3], norm(*half)),
            Core::Cylinder { radius, half } => ([0.0; 3], radius.hypot(*half)),
            Core::Hull(hull) => {
                let points = hull.points();
                let end = |k: usize, pick: fn(f64, f64) -> f64, from: f64| points.iter().map(|p| p[k]).fold(from, pick);
                let middle = |k| 0.5 * (end(k, f64::min, f64::INFINITY) + end(k, f64::max, f64::NEG_INFINITY));
                let centre = [0, 1, 2].map(middle);
                (centre, points.iter().map(|p| norm(minus(*p, centre))).fold(0.0, f64::max))
            }
        };
        (centre, reach + self.radius)
    }

    /// Largest distance of a point of the solid from the z axis of a frame, m. `pose`: pose of the solid in this frame.
    pub(crate) fn reach_from_z(&self, pose: &robot::Pose) -> f64 {
        let from_axis = |p: Vector3| {
            let at = pose.compose(&robot::Pose { position: p, ..robot::Pose::IDENTITY }).position;
            at[0].hypot(at[1])
        };
        let ends = |half: f64| from_axis([0.0, 0.0, half]).max(from_axis([0.0, 0.0, -half]));
        let of_core = match &self.core {
            Core::Point => from_axis([0.0; 3]),
            Core::Segment { half } => ends(*half),
            Core::Cylinder { radius, half } => ends(*half) + radius,
            Core::Cuboid { half: [x, y, z] } => {
                let corner = |k: u8| {
                    let side = |bit: u8, x: f64| if k & bit == 0 { x } else { -x };
                    from_axis([side(1, *x), side(2, *y), side(4, *z)])
                };
                (0..8).map(corner).fold(0.0, f64::max)
            }
            Core::Hull(hull) => hull.points().iter().map(|p| from_axis(*p)).fold(0.0, f64::max),
        };
        of_core + self.radius
    }
}

impl Core {
    /// The point of the core that is farthest along a direction.
    pub fn support(&self, along: Vector3) -> Vector3 {
        let sign = |x: f64, half: f64| if x >= 0.0 { half } else { -half };
        match self {
            Core::Point => [0.0; 3],
            Core::Segment { half } => [0.0, 0.0, sign(along[2], *half)],
            Core::Cuboid { half } => [0, 1, 2].map(|k| sign(along[k], half[k])),
            Core::Cylinder { radius, half } => {
                let across = along[0].hypot(along[1]);
                let share = if across > 0.0 { radius / across } else { 0.0 };
                [along[0] * share, along[1] * share, sign(along[2], *half)]
            }
            Core::Hull(hull) => hull.support(along),
        }
    }
}

impl SupportMap for Core {
    fn local_support_point(&self, along: Vector) -> Vector {
        Vector::from_array(self.support(along.to_array()))
    }
}

/// The six directions along the axes, and `count` directions spread evenly over the sphere by the golden angle.
pub(crate) fn directions(count: usize) -> impl Iterator<Item = Vector3> {
    let axes = [0, 1, 2].into_iter().flat_map(|k| {
        [1.0, -1.0].map(|sign| {
            let mut axis = [0.0; 3];
            axis[k] = sign;
            axis
        })
    });
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let spiral = (0..count).map(move |k| {
        let z = 1.0 - (2 * k + 1) as f64 / count as f64;
        let (across, angle) = ((1.0 - z * z).sqrt(), golden * k as f64);
        [across * angle.cos(), across * angle.sin(), z]
    });
    axes.chain(spiral)
}

/// The convex hull of the points with the indices `kept`, multiplied by `scale`.
fn hull_of(points: &[Vector3], kept: &[usize], scale: f64) -> Core {
    Core::Hull(Hull::new(kept.iter().map(|&k| scaled(points[k], scale)).collect()))
}

/// A point that is not kept in the core.
struct Outside {
    point: usize,
    /// Distance of the point from the hull of the kept points, m.
    distance: f64,
    /// Unit vector from the nearest point of the hull to the point; zero if the distance is zero.
    along: Vector3,
}

impl Outside {
    fn of(hull: &Core, point: usize, place: Vector3, scale: f64) -> Outside {
        let (distance, along) = from_point(hull, scaled(place, scale));
        let along = if distance > 0.0 { scaled(along, 1.0 / distance) } else { [0.0; 3] };
        Outside { point, distance: distance / scale, along }
    }
}

/// The outermost points in the directions in which some point is outside of the hull by more than `by`, m. Points already in the
/// hull are left out.
fn standing_out(points: &[Vector3], kept: &[usize], outside: &[Outside], by: f64) -> Vec<usize> {
    let mut directions: Vec<Vector3> = Vec::new();
    for outside in outside.iter().take_while(|o| o.distance > by) {
        if directions.iter().all(|n| dot(*n, outside.along) < SAME_DIRECTION) {
            directions.push(outside.along);
        }
    }
    let mut added: Vec<usize> = directions.iter().filter_map(|along| farthest(points, *along)).collect();
    added.retain(|k| kept.binary_search(k).is_err());
    added.sort_unstable();
    added.dedup();
    added
}

/// Distance of a point from a core (m) and the vector from the nearest point of the core to the point (not normalised). The
/// distance is never too small, because it is measured to a point of the core.
fn from_point(core: &Core, point: Vector3) -> (f64, Vector3) {
    let here = ParryPose::from_translation(Vector::from_array(point));
    let from = Some(-Vector::from_array(point));
    let mut simplex = VoronoiSimplex::new();
    let infinity = f64::MAX;
    match closest_points_support_map_support_map_with_params(&here, core, &Core::Point, infinity, &mut simplex, from) {
        GJKResult::ClosestPoints(on_core, other, _) => ((on_core - other).length(), (other - on_core).to_array()),
        GJKResult::Intersection => (0.0, [0.0; 3]),
        // If GJK gives no answer, the distance to one point of the core is used. It is never too small.
        GJKResult::NoIntersection(_) | GJKResult::Proximity(_) => {
            let out = minus(point, core.support([-point[0], -point[1], -point[2]]));
            (norm(out), out)
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// A mesh with a size of 1e-35 m, found by fuzzing: GJK takes all its points for one point.
    #[test]
    fn the_smallest_mesh_is_held() {
        // The test has more points on the ball than there are directions.
        let on_ball = |k: usize| {
            let (turn, z) = (2.4 * k as f64, (0.7 * k as f64).sin());
            let across = (1.0 - z * z).sqrt();
            [across * turn.cos(), across * turn.sin(), z].map(|x| 1e-35 * x)
        };
        let points: Vec<Vector3> = (0..20 * KEPT_DIRECTIONS).map(on_ball).collect();
        let solid = Solid::around(&points).unwrap();
        for point in &points {
            let along = point.map(|x| 1e35 * x);
            // Allowed error: rounding of sums of three products.
            assert!(dot(solid.core.support(along), along) + solid.radius >= dot(*point, along) - 1e-47);
        }
    }

    /// A mesh of 1e-35 m that is nearly a line, found by fuzzing: GJK takes points outside of the hull for points inside.
    #[test]
    fn a_nearly_flat_mesh_is_held() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/meshes/nearly_flat.stl");
        let points = crate::mesh::parse_vertices(&std::fs::read(path).unwrap(), Path::new("nearly_flat.stl")).unwrap();
        let (centre, ball) = Solid::around(&points).unwrap().ball();
        // Allowed error: rounding of sums of three products.
        assert!(points.iter().all(|p| norm(minus(*p, centre)) <= ball * (1.0 + 1e-15)));
    }

    #[test]
    fn a_mesh_is_held() {
        // The mesh is a ball of radius 0.2 about (1, 0, 0), with more vertices than there are directions.
        let points: Vec<Vector3> = (0..5000)
            .map(|k| {
                let (z, angle) = (1.0 - (2 * k + 1) as f64 / 5000.0, 2.4 * f64::from(k));
                let across = (1.0 - z * z).sqrt();
                [1.0 + 0.2 * across * angle.cos(), 0.2 * across * angle.sin(), 0.2 * z]
            })
            .collect();
        let solid = Solid::around(&points).unwrap();
        let Core::Hull(kept) = &solid.core else { panic!("{solid:?}") };
        assert!(kept.points().len() < 2 * MAX_KEPT);
        for k in 0..50 {
            let along = [(0.7 * f64::from(k)).sin(), (1.3 * f64::from(k)).cos(), (0.4 * f64::from(k)).sin()];
            let outermost = points.iter().map(|p| dot(*p, along)).fold(f64::NEG_INFINITY, f64::max);
            let held = dot(solid.core.support(along), along) + solid.radius * norm(along);
            assert!(held >= outermost - 1e-12, "{k}: {held} {outermost}");
            // 1000 points on a ball: the diagonal of four neighbours is about 0.16 rad. So the uncovered cap between them has a
            // half angle below 0.1 rad and a height below 0.2 (1 - cos 0.1) = 1 mm.
            assert!(held < outermost + 1e-3 * norm(along), "{k}: {held} {outermost}");
        }
        // If the core has not reached its greatest number of vertices, no vertex is outside of it by more than a tenth of a
        // millimetre.
        let few: Vec<Vector3> = points.iter().step_by(6).copied().collect();
        assert!(few.len() > 2 * KEPT_DIRECTIONS && Solid::around(&few).unwrap().radius <= NEAR_ENOUGH_M);
        assert_eq!(Solid::around(&[]), None);
        assert_eq!(Solid::around(&[[1.0, 2.0, 3.0]; 4]).unwrap().radius, 0.0);
        // The hull of the corners of a cube is the cube.
        let corners: Vec<Vector3> =
            (0..8).map(|k: u8| [1, 2, 4].map(|bit| if k & bit == 0 { 0.5 } else { -0.5 })).collect();
        let cube = Solid::around(&corners).unwrap();
        assert!(cube.radius < 1e-9 && (cube.ball().1 - 0.75_f64.sqrt()).abs() < 1e-12, "{cube:?}");
    }

    #[test]
    fn reaches_hold_every_point() {
        let solids = [
            Core::Point,
            Core::Segment { half: 0.3 },
            Core::Cuboid { half: [0.1, 0.2, 0.3] },
            Core::Cylinder { radius: 0.1, half: 0.4 },
            Core::Hull(Hull::new(vec![[0.1, 0.2, 0.3], [-0.4, 0.0, 0.1]])),
        ]
        .map(|core| Solid { core, radius: 0.05 });
        let (s, c) = 0.7_f64.sin_cos();
        let pose = robot::Pose { rotation: [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]], position: [0.2, 0.1, 0.0] };
        for solid in solids {
            let reach = solid.reach_from_z(&pose);
            let (centre, ball) = solid.ball();
            for k in 0..200 {
                let along = [(0.7 * f64::from(k)).sin(), (1.3 * f64::from(k)).cos(), (0.4 * f64::from(k)).sin()];
                let p = solid.core.support(along);
                let far = [0, 1, 2].map(|i| p[i] + solid.radius * along[i] / norm(along));
                let at = pose.compose(&robot::Pose { position: far, ..robot::Pose::IDENTITY }).position;
                assert!(at[0].hypot(at[1]) <= reach + 1e-12 && norm(minus(far, centre)) <= ball + 1e-12);
            }
        }
    }
}
