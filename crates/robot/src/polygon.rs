//! Describes a planar loop as a closed polygon.
//!
//! If all moving joints of a loop are revolute with parallel axes, the loop lies in the plane normal to the axes. Each rigid side
//! is a vector s_k in this plane. It is rotated by the angle Phi_k: the sum of the joint variables before it, with signs
//! according to the directions of the axes:
//!
//! ```text
//! sum_k s_k exp(i Phi_k) = 0        Phi_cut - Phi_twin = delta  (mod 2 pi)
//! ```
//! Phi_cut, Phi_twin: the angles at the ends of the two branches. delta: constant angle between these ends when the loop is
//! closed. All Phi are linear in the variables. Constant angles of the joints are included in the s_k and in delta.

use crate::inertial::Pose;
use crate::robot::{JointKind, Loop, LoopFrame, Robot};
use crate::value::{CoordinateId, Symbol};
use crate::vector::{Vector3, cross, dot, minus, norm, product, scaled, transposed, turned};

/// Two frames coincide if they differ by at most this value, m and rad: rounding errors are smaller.
pub(crate) const COINCIDENCE_ROUNDING: f64 = 1e-9;

#[derive(Clone, Debug)]
pub(crate) struct Polygon {
    /// The sides in the order of the loop: from the last common link of the two branches to the cut, then along the other branch
    /// back.
    pub sides: Vec<Side>,
    /// Coefficients of Phi_cut - Phi_twin, one for each variable of the robot.
    pub turn: Vec<f64>,
    /// The constant angle delta, rad.
    pub angle: f64,
}

#[derive(Clone, Debug)]
pub(crate) struct Side {
    /// The vector s_k of the side in the plane, m.
    pub vector: [f64; 2],
    /// Coefficients of the angle Phi_k by which the side is rotated, one for each variable of the robot.
    pub turn: Vec<f64>,
}

/// The polygon of a loop at the values of `symbols`. `None` if the loop is not planar. Fails if the loop cannot close.
pub(crate) fn polygon(robot: &Robot, symbols: &[Symbol], one: &Loop) -> Result<Option<Polygon>, String> {
    let (cut, twin) = (Chain::new(robot, &one.cut), Chain::new(robot, &one.twin));
    let common = cut.links.iter().zip(&twin.links).take_while(|(a, b)| a == b).count();
    let (cut, twin) = (cut.after(common, robot, symbols), twin.after(common, robot, symbols));
    let Some(first) = cut.joints.iter().chain(&twin.joints).next() else { return Ok(None) };
    let axis = first.axis;
    let parallel = |j: &MovingJoint| j.kind == JointKind::Revolute && norm(cross(j.axis, axis)) < COINCIDENCE_ROUNDING;
    if !cut.joints.iter().chain(&twin.joints).all(parallel) {
        return Ok(None);
    }

    let between = product(&twin.end.rotation, &transposed(&cut.end.rotation));
    let off = norm(minus(turned(&between, axis), axis));
    if off > COINCIDENCE_ROUNDING {
        return Err(format!("its joints turn about one direction, and about it the two ends differ by {off:.1e} rad"));
    }
    let apart = dot(minus(twin.end.position, cut.end.position), axis).abs();
    if apart > COINCIDENCE_ROUNDING {
        return Err(format!("its joints move in one plane, and the two ends lie in planes {apart:.3e} m apart"));
    }

    // Two directions x and y in the plane, normal to the axis.
    let across = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|e| cross(axis, e));
    let longest = across.into_iter().max_by(|a, b| norm(*a).total_cmp(&norm(*b))).unwrap_or_default();
    let x = scaled(longest, 1.0 / norm(longest));
    let y = cross(axis, x);
    let flat = |v: Vector3| [dot(v, x), dot(v, y)];

    let n = robot.n_variables();
    let (outward, phi_cut) = cut.sides(axis, n);
    let (back, phi_twin) = twin.sides(axis, n);
    let mut sides: Vec<Side> = outward.into_iter().map(|(v, turn)| Side { vector: flat(v), turn }).collect();
    sides.extend(back.into_iter().rev().map(|(v, turn)| Side { vector: flat(scaled(v, -1.0)), turn }));
    let x_turned = turned(&between, x);
    Ok(Some(Polygon {
        sides,
        turn: phi_cut.iter().zip(&phi_twin).map(|(a, b)| a - b).collect(),
        angle: dot(x_turned, y).atan2(dot(x_turned, x)),
    }))
}

/// One branch of a loop: the chain of links from the base to the loop frame.
struct Chain<'a> {
    links: Vec<usize>,
    frame: &'a LoopFrame,
    joints: Vec<MovingJoint>,
    end: Pose,
}

/// A moving joint of a branch, with all variables at zero. Axis and origin are in the frame of the link where the branch starts.
struct MovingJoint {
    axis: Vector3,
    origin: Vector3,
    kind: JointKind,
    terms: Vec<(CoordinateId, f64)>,
}

impl<'a> Chain<'a> {
    fn new(robot: &Robot, frame: &'a LoopFrame) -> Chain<'a> {
        let mut links: Vec<usize> =
            std::iter::successors(frame.antecedent, |&j| robot.link(j).antecedent).map(|j| j.0).collect();
        links.reverse();
        Chain { links, frame, joints: Vec::new(), end: Pose::IDENTITY }
    }

    /// The branch without its first `common` links, expressed in the frame of the last of these `common` links.
    fn after(mut self, common: usize, robot: &Robot, symbols: &[Symbol]) -> Chain<'a> {
        self.links.drain(..common);
        let mut pose = Pose::IDENTITY;
        let frame = self.frame;
        let links = self.links.iter().map(|&j| {
            let link = &robot.links[j];
            (&link.geometry, link.joint.kind, &link.joint.variable)
        });
        for (geometry, kind, variable) in links.chain([(&frame.geometry, frame.kind, &frame.variable)]) {
            pose = pose.compose(&geometry.pose(symbols, 0.0, 0.0));
            if kind != JointKind::Fixed && !variable.terms.is_empty() {
                let axis = [0, 1, 2].map(|i| pose.rotation[i][2]);
                self.joints.push(MovingJoint { axis, origin: pose.position, kind, terms: variable.terms.clone() });
            }
        }
        self.end = pose;
        self
    }

    /// Two results: the vectors from joint to joint, each with the coefficients of its angle Phi; and the coefficients of Phi at
    /// the end of the branch.
    fn sides(&self, axis: Vector3, n: usize) -> (Vec<(Vector3, Vec<f64>)>, Vec<f64>) {
        let mut sides = Vec::with_capacity(self.joints.len() + 1);
        let mut phi = vec![0.0; n];
        let mut from = [0.0; 3];
        for joint in &self.joints {
            sides.push((minus(joint.origin, from), phi.clone()));
            from = joint.origin;
            let sign = dot(joint.axis, axis).signum();
            for &(k, c) in &joint.terms {
                phi[k.0] += sign * c;
            }
        }
        sides.push((minus(self.end.position, from), phi.clone()));
        (sides, phi)
    }
}
