//! The gaps (distances) that a robot must keep: between its own links, and to half-spaces.
//!
//! Let each coordinate j change by at most |dq_j| (its spread) from the configuration q. Then the distance of two bodies is at
//! least
//!
//! ```text
//! d(q) - sum over the joints between the two bodies of |dq_j| R_j
//! ```
//! d(q): the distance at q. R_j: largest distance of a point of the body from the axis of joint j; 1 for a prismatic joint. The
//! proof moves the joints one after the other, the outermost first. The inner joints are then still at q, so R_j is the distance
//! at q plus the motion due to the outer joints. Along the normal n of a half-space, a point moves by R_j |n x z_j| for a
//! revolute joint and by |n . z_j| for a prismatic joint, z_j: the joint axis. So a joint that turns about the normal does not
//! change the distance to the half-space.
//!
//! Not here: the list of the gaps of a robot ([`crate::gaps`]), and the configurations along a motion.

use robot::{JointKind, Pose};

use crate::bodies::{BodyShape, FileLink};
use crate::half_space::HalfSpace;
use crate::kinematic_tree::{KinematicTree, axis};
use crate::separation::{PosedSolid, separation};
use crate::solid::Core;
use claims::LeftOut;
use robot::vector::{Vector3, cross, dot, minus, norm, plus, turned};

/// A distance that the robot must keep: between two bodies, or between a body and a half-space.
#[derive(Clone, Debug)]
pub struct Gap {
    /// Name of the gap: `forearm and base`, or `forearm at the floor`.
    pub subject: String,
    /// Whether both bodies belong to the robot.
    pub is_own: bool,
    /// Required least distance including the margin, m.
    pub bound: f64,
    /// Part of `bound` that covers the errors of joints and bodies, m.
    pub margin: f64,
    /// Additional distance above the bound, m. A search for motions checks a motion only at some instants, so it keeps the bound
    /// plus this reserve.
    pub reserve: f64,
    /// Names of the moving links that carry the two bodies. A gap to a half-space has the same name twice.
    pub carriers: [String; 2],
    /// `body`: index of the body. `shapes`: indices of its shapes that must keep the distance.
    pub(crate) body: usize,
    pub(crate) shapes: Vec<usize>,
    pub(crate) against: Against,
    /// Links with joints that move the body relative to the other body, the outermost first. Then: links with joints that move
    /// the other body, the outermost first.
    pub(crate) joints: [Vec<usize>; 2],
    /// Whether the distance is the same in all poses of the robot. If so, it needs no margin for position errors.
    pub(crate) is_constant: bool,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Against {
    Body(usize),
    HalfSpace(usize),
}

/// The distance of two bodies (gap) at a configuration, and its lower bound near this configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapRange {
    /// Distance at the configuration, m; negative if the bodies overlap.
    pub reached: f64,
    /// Lower bound of the distance (m) while each coordinate stays within a given distance (spread) of the configuration.
    pub at_least: f64,
}

/// The bodies of a robot, and the distances (gaps) that they must keep.
pub struct Clearance {
    pub(crate) tree: KinematicTree,
    pub(crate) bodies: Vec<FileLink>,
    pub(crate) half_spaces: Vec<HalfSpace>,
    pub(crate) gaps: Vec<Gap>,
    /// Largest rate of change of each gap (distance) with each coordinate, m/rad (m/m): `rates[gap][coordinate]`.
    pub(crate) rates: Vec<Vec<f64>>,
    /// Largest absolute value of each coordinate (rad or m) for which the bounds in `rates` hold.
    pub(crate) given_ranges: Vec<f64>,
    pub(crate) floor: Option<f64>,
    pub(crate) left_out: Vec<LeftOut>,
    /// Names of the bodies with meshes that were cut into convex pieces, each with its number of pieces.
    pub(crate) cut_bodies: Vec<(String, usize)>,
}

/// Allowance for rounding of distances, and of positions a few metres from the base, m. It is larger than needed.
pub(crate) const PLACE_ROUNDING_M: f64 = 1e-9;
/// Allowance for the rounding of the sine of the angle between a joint axis and a normal.
const PARALLEL_ROUNDING: f64 = 1e-12;

impl Clearance {
    /// All distances (gaps) that the robot must keep, in a fixed order.
    pub fn gaps(&self) -> &[Gap] {
        &self.gaps
    }

    /// The distances and bodies that are not checked, with reasons.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    /// Indices of the coordinates that change the distance of the gap with the index `gap`.
    pub fn moved_by(&self, gap: usize) -> Vec<usize> {
        let rates = self.rates.get(gap).into_iter().flatten();
        rates.enumerate().filter(|(_, rate)| **rate > 0.0).map(|(k, _)| k).collect()
    }

    /// Height of the floor, m: the requested height, or the height of the plane of the base. `None` without a floor.
    pub fn floor(&self) -> Option<f64> {
        self.floor
    }

    /// Height (m) of the lowest point of the moving bodies at configuration `q`, and the name of the body with this point.
    /// `None` if no body moves.
    pub fn lowest(&self, q: &[f64]) -> Option<(f64, &str)> {
        let poses = self.tree.poses(q);
        let heights = self.bodies.iter().filter(|b| b.link.is_some()).flat_map(|body| {
            let height = |shape: &BodyShape| self.standing(body, shape, &poses).least_along([0.0, 0.0, 1.0]);
            body.shapes.iter().map(height).map(|z| (z, body.name.as_str()))
        });
        heights.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Names of the bodies with meshes that were cut into convex pieces to get more clearance, each with its number of shapes.
    pub fn cut_bodies(&self) -> &[(String, usize)] {
        &self.cut_bodies
    }

    /// Largest distance (m) by which a body extends beyond the convex hull of its mesh, and the name of the body. `None` if
    /// there is no mesh.
    pub fn mesh_error(&self) -> Option<(f64, &str)> {
        let of = |body: &FileLink| {
            let hulls = body.shapes.iter().filter(|shape| matches!(shape.solid.core, Core::Hull(_)));
            hulls.map(|shape| shape.solid.radius).reduce(f64::max)
        };
        let all = self.bodies.iter().filter_map(|body| Some((of(body)?, body.name.as_str())));
        all.max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Two chains of links whose joints move `a` relative to `b`: the chain of `a`, then the chain of `b`. Each chain runs from
    /// its outermost link towards the base and ends before the first link that carries both `a` and `b`. `None`: the base.
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

    /// Largest displacement of a shape (m) if each coordinate moves by at most its value in `spread`. With `normal`: largest
    /// displacement along this unit vector.
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
                    // Joint k = 0 carries the shape directly, so the distance of the shape from the axis of this joint is
                    // constant.
                    let from_axis = norm(cross(z, minus(centre, poses[j].position))) + shape.ball;
                    let radius = if k == 0 { shape.max_axis_distance.min(from_axis) } else { from_axis + moved };
                    by * radius
                }
            };
            moved += step;
            along += normal.map_or(step, |n| match self.tree.kind(j) {
                JointKind::Prismatic => step * dot(n, z).abs(),
                // The allowance is added because rounding must not make an oblique axis parallel to the normal.
                _ => step * (norm(cross(n, z)) + PARALLEL_ROUNDING),
            });
        }
        along
    }

    /// The distance of the two bodies of a gap for the link poses `poses`. Also a lower bound of this distance, while each
    /// coordinate moves by at most its value in `spread` (`None`: no motion).
    pub(crate) fn apart(&self, gap: &Gap, poses: &[Pose], spread: Option<&[f64]>) -> GapRange {
        let spread = spread.unwrap_or(&[]);
        let body = &self.bodies[gap.body];
        // Without `spread` nothing moves, so the lower bound equals the distance.
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
                // Height of the lowest point of the shape above the half-space, along its normal. The bound subtracts the
                // displacement along the normal.
                Against::HalfSpace(wall) => {
                    let HalfSpace { normal, offset, .. } = self.half_spaces[wall];
                    let at = self.standing(body, shape, poses).least_along(normal) - offset;
                    take(at, at - moved(&gap.joints[0], centre, shape, Some(normal)));
                }
                Against::Body(other) => {
                    // Distance of two shapes; the bound subtracts the displacements of both shapes.
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

    /// The distances of the gaps with the indices `which` at `q`. Each has a lower bound for all configurations in which every
    /// coordinate k differs by at most `spread[k]` from `q`, rad (m).
    pub fn rooms(&self, q: &[f64], spread: &[f64], which: &[usize]) -> Vec<GapRange> {
        let poses = self.tree.poses(q);
        which.iter().map(|&g| self.apart(&self.gaps[g], &poses, Some(spread))).collect()
    }
}
