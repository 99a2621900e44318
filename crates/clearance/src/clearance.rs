//! The gaps that a robot must keep: between its own links, and to half-spaces.
//!
//! Near a configuration q, with every coordinate within s of it, a gap certainly stays above
//!
//! ```text
//! d(q) - sum over the joints between the two bodies of |dq_j| R_j
//! ```
//! |dq_j| is the most that joint j moves, and R_j is the largest distance of a point of the body from its axis. Let the
//! joints move one after the other, the outermost first. The joints further in then still stand as at q, so R_j is the
//! distance at q plus what the joints further out have added. A joint that slides has R_j = 1. Along the normal n of a
//! half-space a point moves by |n x z_j| of that, with z_j the axis, or by |n . z_j| where the joint slides. So a joint
//! that turns about the normal changes nothing.
//!
//! Not here: which gaps a robot has ([`crate::gaps`]), which configurations a motion goes through.

use robot::{JointKind, Pose};

use crate::bodies::{Body, Shape};
use crate::half_space::HalfSpace;
use crate::kinematic_tree::{KinematicTree, axis};
use crate::separation::{Standing, separation};
use crate::solid::Core;
use claims::LeftOut;
use robot::vector::{Vector3, cross, dot, minus, norm, plus, turned};

/// A distance that must not become too small.
#[derive(Clone, Debug)]
pub struct Gap {
    /// `forearm and base`, or `forearm at the floor`.
    pub subject: String,
    /// Whether both sides are links of the robot.
    pub is_own: bool,
    /// m, with the margin.
    pub bound: f64,
    /// What of the bound is there for errors of joints and bodies, m.
    pub margin: f64,
    /// Room above the bound that a search keeps for what happens between its instants, m.
    pub reserve: f64,
    /// The moving links, by name, that the two bodies belong to; of one body its own twice.
    pub carriers: [String; 2],
    /// Index of the body, and of its shapes.
    pub(crate) body: usize,
    pub(crate) shapes: Vec<usize>,
    pub(crate) against: Against,
    /// Links whose joints move the body against the other, the outermost first, and those that move the other against
    /// it.
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
pub struct Room {
    /// At the configuration, m; negative where bodies overlap.
    pub reached: f64,
    /// Lower bound of the gap near the configuration, m.
    pub at_least: f64,
}

/// A robot's bodies with the gaps that they must keep.
pub struct Clearance {
    pub(crate) tree: KinematicTree,
    pub(crate) bodies: Vec<Body>,
    pub(crate) half_spaces: Vec<HalfSpace>,
    pub(crate) gaps: Vec<Gap>,
    /// How fast gaps change at most, by gap and coordinate, m/rad (m/m).
    pub(crate) rates: Vec<Vec<f64>>,
    /// Farthest each coordinate may be from zero for that.
    pub(crate) told_ranges: Vec<f64>,
    pub(crate) floor: Option<f64>,
    pub(crate) left_out: Vec<LeftOut>,
    /// Bodies whose meshes are cut, and into how many shapes.
    pub(crate) cut_bodies: Vec<(String, usize)>,
}

/// Allowance for the rounding of places a few metres from the base and of distances between them, m, with room to
/// spare.
pub(crate) const PLACE_ROUNDING_M: f64 = 1e-9;

impl Clearance {
    /// The gaps, in a fixed order.
    pub fn gaps(&self) -> &[Gap] {
        &self.gaps
    }

    /// What the gaps do not cover.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    /// The coordinates that change a gap.
    pub fn moved_by(&self, gap: usize) -> Vec<usize> {
        let rates = self.rates.get(gap).into_iter().flatten();
        rates.enumerate().filter(|(_, rate)| **rate > 0.0).map(|(k, _)| k).collect()
    }

    /// Height of the floor, m: the one that was asked for, or that of the base.
    pub fn floor(&self) -> Option<f64> {
        self.floor
    }

    /// The lowest point of the bodies that move, m, and whose it is; `None` where there are none.
    pub fn lowest(&self, q: &[f64]) -> Option<(f64, &str)> {
        let poses = self.tree.poses(q);
        let heights = self.bodies.iter().filter(|b| b.link.is_some()).flat_map(|body| {
            let height = |shape: &Shape| self.standing(body, shape, &poses).least_along([0.0, 0.0, 1.0]);
            body.shapes.iter().map(height).map(|z| (z, body.name.as_str()))
        });
        heights.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The bodies that little room made cut, by name, and how many convex shapes each has.
    pub fn cut_bodies(&self) -> &[(String, usize)] {
        &self.cut_bodies
    }

    /// How much larger a body may be than the hull of its mesh, m, and whose it is: the largest; `None` where there is no mesh.
    pub fn mesh_error(&self) -> Option<(f64, &str)> {
        let of = |body: &Body| {
            let hulls = body.shapes.iter().filter(|shape| matches!(shape.solid.core, Core::Hull(_)));
            hulls.map(|shape| shape.solid.radius).reduce(f64::max)
        };
        let all = self.bodies.iter().filter_map(|body| Some((of(body)?, body.name.as_str())));
        all.max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The joints from `a` inward to the link that carries both `a` and `b`, the outermost first, and those from `b`.
    pub(crate) fn between(&self, a: Option<usize>, b: Option<usize>) -> [Vec<usize>; 2] {
        let (a, b) = (self.tree.inward(a), self.tree.inward(b));
        let common = a.iter().rev().zip(b.iter().rev()).take_while(|(x, y)| x == y).count();
        [&a, &b].map(|chain| chain[..chain.len() - common].to_vec())
    }

    pub(crate) fn standing<'a>(&'a self, body: &Body, shape: &'a Shape, poses: &[Pose]) -> Standing<'a> {
        let pose = body.link.map_or(shape.pose, |j| poses[j].compose(&shape.pose));
        Standing { solid: &shape.solid, pose }
    }

    pub(crate) fn centre(&self, body: &Body, shape: &Shape, poses: &[Pose]) -> Vector3 {
        let at = |pose: &Pose| plus(pose.position, turned(&pose.rotation, shape.centre));
        body.link.map_or(shape.centre, |j| at(&poses[j]))
    }

    /// How far a shape moves at most while joints move by `spread` of their coordinates; along `normal` only, if given.
    fn displacement(
        &self,
        joints: &[usize],
        centre: Vector3,
        shape: &Shape,
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
                    let reach = if k == 0 { shape.reach.min(from_axis) } else { from_axis + moved };
                    by * reach
                }
            };
            moved += step;
            along += normal.map_or(step, |n| match self.tree.kind(j) {
                JointKind::Prismatic => step * dot(n, z).abs(),
                // The sine and a small margin, so that rounding does not make an axis parallel that is not.
                _ => step * (norm(cross(n, z)) + 1e-12),
            });
        }
        along
    }

    /// A gap with the links at `poses`, and its lower bound while coordinates move by `spread`.
    pub(crate) fn apart(&self, gap: &Gap, poses: &[Pose], spread: Option<&[f64]>) -> Room {
        let spread = spread.unwrap_or(&[]);
        let body = &self.bodies[gap.body];
        // Without a spread nothing moves, and the bound is the room itself.
        let moved = |joints: &[usize], centre: Vector3, shape: &Shape, normal: Option<Vector3>| match spread {
            [] => 0.0,
            spread => self.displacement(joints, centre, shape, poses, spread, normal),
        };
        let mut room = Room { reached: f64::INFINITY, at_least: f64::INFINITY };
        let mut take = |reached: f64, at_least: f64| {
            room =
                Room { reached: room.reached.min(reached), at_least: room.at_least.min(at_least - PLACE_ROUNDING_M) };
        };
        for &s in &gap.shapes {
            let shape = &body.shapes[s];
            let centre = self.centre(body, shape, poses);
            match gap.against {
                // The lowest point along the normal, less how far the shape moves along it.
                Against::HalfSpace(wall) => {
                    let HalfSpace { normal, offset, .. } = self.half_spaces[wall];
                    let at = self.standing(body, shape, poses).least_along(normal) - offset;
                    take(at, at - moved(&gap.joints[0], centre, shape, Some(normal)));
                }
                Against::Body(other) => {
                    // The distance of two shapes, less how far either moves while its own joints do.
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

    /// The gaps `which` at `q`, and the least they can be while each coordinate stays within `spread` of it.
    pub fn rooms(&self, q: &[f64], spread: &[f64], which: &[usize]) -> Vec<Room> {
        let poses = self.tree.poses(q);
        which.iter().map(|&g| self.apart(&self.gaps[g], &poses, Some(spread))).collect()
    }
}
