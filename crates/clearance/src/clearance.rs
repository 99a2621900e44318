//! The gaps that a robot must keep: between its own links, and to half-spaces.
//!
//! Near a configuration q, while every coordinate stays within s of it, a gap certainly stays above
//!
//! ```text
//! d(q) - sum over the joints between the two bodies of |dq_j| R_j
//! ```
//! |dq_j| is the largest motion of joint j, and R_j is the largest distance of a point of the body from its axis. Let the joints
//! move one after the other, the outermost first. The inner joints then are still at q, so R_j is the distance at q plus the
//! motion due to the outer joints. A joint that slides has R_j = 1. Along the normal n of a half-space a point moves by this
//! times |n x z_j|, with z_j the axis, or times |n . z_j| where the joint slides. So a joint that turns about the normal changes
//! nothing.
//!
//! Not here: the list of gaps of a robot ([`crate::gaps`]), and the configurations along a motion.

use robot::{JointKind, Pose};

use crate::bodies::{BodyShape, FileLink};
use crate::half_space::HalfSpace;
use crate::kinematic_tree::{KinematicTree, axis};
use crate::separation::{PosedSolid, separation};
use crate::solid::Core;
use claims::LeftOut;
use robot::vector::{Vector3, cross, dot, minus, norm, plus, turned};

/// A distance with a lower bound.
#[derive(Clone, Debug)]
pub struct Gap {
    /// `forearm and base`, or `forearm at the floor`.
    pub subject: String,
    /// Whether both sides are links of the robot.
    pub is_own: bool,
    /// Lower bound of the distance including the margin, m.
    pub bound: f64,
    /// Part of the bound for errors of joints and bodies, m.
    pub margin: f64,
    /// Distance above the bound that a search keeps for the motion between its instants, m.
    pub reserve: f64,
    /// The moving links, by name, that carry the two bodies; for a gap of one body its link twice.
    pub carriers: [String; 2],
    /// Index of the body, and of its shapes.
    pub(crate) body: usize,
    pub(crate) shapes: Vec<usize>,
    pub(crate) against: Against,
    /// Links with joints that move the body relative to the other, the outermost first; and links with joints that move the other
    /// body.
    pub(crate) joints: [Vec<usize>; 2],
    /// Whether no pose changes it: it needs no margin.
    pub(crate) is_constant: bool,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Against {
    Body(usize),
    HalfSpace(usize),
}

/// A gap at a configuration and near it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapRange {
    /// The gap at the configuration, m; negative where bodies overlap.
    pub reached: f64,
    /// Lower bound of the gap near the configuration, m.
    pub at_least: f64,
}

/// A robot's bodies with the gaps that they must keep.
pub struct Clearance {
    pub(crate) tree: KinematicTree,
    pub(crate) bodies: Vec<FileLink>,
    pub(crate) half_spaces: Vec<HalfSpace>,
    pub(crate) gaps: Vec<Gap>,
    /// Largest rates of gaps, by gap and coordinate, m/rad (m/m).
    pub(crate) rates: Vec<Vec<f64>>,
    /// Largest distance of each coordinate from zero for these rates, rad (m).
    pub(crate) given_ranges: Vec<f64>,
    pub(crate) floor: Option<f64>,
    pub(crate) left_out: Vec<LeftOut>,
    /// Bodies with cut meshes, and the number of shapes of each.
    pub(crate) cut_bodies: Vec<(String, usize)>,
}

/// Allowance, with room to spare, for the rounding of positions a few metres from the base and of distances, m.
pub(crate) const PLACE_ROUNDING_M: f64 = 1e-9;
/// Allowance for the rounding of the sine between an axis and a normal.
const PARALLEL_ROUNDING: f64 = 1e-12;

impl Clearance {
    /// The gaps, in a fixed order.
    pub fn gaps(&self) -> &[Gap] {
        &self.gaps
    }

    /// Gaps and bodies that are not checked.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    /// The coordinates that change a gap.
    pub fn moved_by(&self, gap: usize) -> Vec<usize> {
        let rates = self.rates.get(gap).into_iter().flatten();
        rates.enumerate().filter(|(_, rate)| **rate > 0.0).map(|(k, _)| k).collect()
    }

    /// Height of the floor, m: the requested one, or the floor of the base.
    pub fn floor(&self) -> Option<f64> {
        self.floor
    }

    /// The lowest point of the bodies that move, m, and the name of its body; `None` where there are none.
    pub fn lowest(&self, q: &[f64]) -> Option<(f64, &str)> {
        let poses = self.tree.poses(q);
        let heights = self.bodies.iter().filter(|b| b.link.is_some()).flat_map(|body| {
            let height = |shape: &BodyShape| self.standing(body, shape, &poses).least_along([0.0, 0.0, 1.0]);
            body.shapes.iter().map(height).map(|z| (z, body.name.as_str()))
        });
        heights.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The bodies with meshes that were cut for lack of room, by name, with the number of convex shapes of each.
    pub fn cut_bodies(&self) -> &[(String, usize)] {
        &self.cut_bodies
    }

    /// Largest excess of a body over the hull of its mesh, m, with the body's name; `None` where there is no mesh.
    pub fn mesh_error(&self) -> Option<(f64, &str)> {
        let of = |body: &FileLink| {
            let hulls = body.shapes.iter().filter(|shape| matches!(shape.solid.core, Core::Hull(_)));
            hulls.map(|shape| shape.solid.radius).reduce(f64::max)
        };
        let all = self.bodies.iter().filter_map(|body| Some((of(body)?, body.name.as_str())));
        all.max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The joints from `a` inward to the link that carries both `a` and `b`, the outermost first; and the joints from `b`.
    pub(crate) fn between(&self, a: Option<usize>, b: Option<usize>) -> [Vec<usize>; 2] {
        let (a, b) = (self.tree.inward(a), self.tree.inward(b));
        let common = a.iter().rev().zip(b.iter().rev()).take_while(|(x, y)| x == y).count();
        [&a, &b].map(|chain| chain[..chain.len() - common].to_vec())
    }

    pub(crate) fn standing<'a>(&'a self, body: &FileLink, shape: &'a BodyShape, poses: &[Pose]) -> PosedSolid<'a> {
        let pose = body.link.map_or(shape.pose, |j| poses[j].compose(&shape.pose));
        PosedSolid { solid: &shape.solid, pose }
    }

    pub(crate) fn centre(&self, body: &FileLink, shape: &BodyShape, poses: &[Pose]) -> Vector3 {
        let at = |pose: &Pose| plus(pose.position, turned(&pose.rotation, shape.centre));
        body.link.map_or(shape.centre, |j| at(&poses[j]))
    }

    /// Largest displacement of a shape while joints move by `spread` of their coordinates, m; along `normal` only, if given.
    fn displacement(
        &self,
        joints: &[usize],
        centre: Vector3,
        shape: &BodyShape,
        poses: &[Pose],
        spread: &[f64],
        normal: Option<Vector3>,
    ) -> f64 {
        let (mut moved, mut along) = (0.0, 0.0);
        for (k, &j) in joints.iter().enumerate() {
            let by = self.tree.spread(j, spread);
            let z = axis(&poses[j]);
            let step = match self.tree.kind(j) {
                JointKind::Fixed => continue,
                JointKind::Prismatic => by,
                JointKind::Revolute => {
                    // A shape keeps its distance from the axis of the joint that carries it.
                    let from_axis = norm(cross(z, minus(centre, poses[j].position))) + shape.ball;
                    let radius = if k == 0 { shape.max_axis_distance.min(from_axis) } else { from_axis + moved };
                    by * radius
                }
            };
            moved += step;
            along += normal.map_or(step, |n| match self.tree.kind(j) {
                JointKind::Prismatic => step * dot(n, z).abs(),
                // The sine plus an allowance, so that rounding does not make an oblique axis parallel.
                _ => step * (norm(cross(n, z)) + PARALLEL_ROUNDING),
            });
        }
        along
    }

    /// A gap with the links at `poses`, and its lower bound while coordinates move by `spread`.
    pub(crate) fn apart(&self, gap: &Gap, poses: &[Pose], spread: Option<&[f64]>) -> GapRange {
        let spread = spread.unwrap_or(&[]);
        let body = &self.bodies[gap.body];
        // Without a spread nothing moves, and the bound is the gap itself.
        let moved = |joints: &[usize], centre: Vector3, shape: &BodyShape, normal: Option<Vector3>| match spread {
            [] => 0.0,
            spread => self.displacement(joints, centre, shape, poses, spread, normal),
        };
        let mut room = GapRange { reached: f64::INFINITY, at_least: f64::INFINITY };
        let mut take = |reached: f64, at_least: f64| {
            room = GapRange {
                reached: room.reached.min(reached),
                at_least: room.at_least.min(at_least - PLACE_ROUNDING_M),
            };
        };
        for &s in &gap.shapes {
            let shape = &body.shapes[s];
            let centre = self.centre(body, shape, poses);
            match gap.against {
                // The lowest point along the normal, minus the displacement of the shape along it.
                Against::HalfSpace(wall) => {
                    let HalfSpace { normal, offset, .. } = self.half_spaces[wall];
                    let at = self.standing(body, shape, poses).least_along(normal) - offset;
                    take(at, at - moved(&gap.joints[0], centre, shape, Some(normal)));
                }
                Against::Body(other) => {
                    // The distance of two shapes, minus the displacements of both due to their joints.
                    let other = &self.bodies[other];
                    let own = moved(&gap.joints[0], centre, shape, None);
                    for opposite in &other.shapes {
                        let place = self.centre(other, opposite, poses);
                        let (a, b) = (self.standing(body, shape, poses), self.standing(other, opposite, poses));
                        let found = separation(a, b, minus(centre, place));
                        take(found.reached, found.at_least - own - moved(&gap.joints[1], place, opposite, None));
                    }
                }
            }
        }
        room
    }

    /// The gaps `which` at `q`, and their lower bounds while each coordinate stays within `spread` of it.
    pub fn rooms(&self, q: &[f64], spread: &[f64], which: &[usize]) -> Vec<GapRange> {
        let poses = self.tree.poses(q);
        which.iter().map(|&g| self.apart(&self.gaps[g], &poses, Some(spread))).collect()
    }
}
