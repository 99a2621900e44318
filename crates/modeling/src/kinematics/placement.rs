//! The pose of a link j in the frame of its antecedent i (parent), with conversions of vectors and wrenches between the two
//! frames; and the twist of a link frame.

use expr::{Expr, Graph};
use robot::JointKind;

use crate::kinematics::angular_motion::Bend;
use crate::kinematics::vector::{Vector, ZRotation, add, cross};

/// The pose of link j in the frame of its antecedent i.
#[derive(Clone, Debug)]
pub struct Placement {
    /// Rotation by gamma about the z axis of frame i.
    pub gamma: ZRotation,
    /// Rotation by alpha about the x axis, after gamma.
    pub alpha: ZRotation,
    /// Rotation by theta about the z axis of frame j.
    pub theta: ZRotation,
    /// The vector from the origin of frame i to the origin of frame j, in frame i, m.
    pub p: Vector,
}

impl Placement {
    /// Converts a vector from components in frame i (antecedent) to components in frame j (link).
    pub fn to_link(&self, g: &mut Graph, v: Vector) -> Vector {
        let v = self.to_link_before_theta(g, v);
        self.theta.turned(g, v)
    }

    /// Converts a vector from components in frame i (antecedent) to components in frame j before the rotation by theta.
    pub fn to_link_before_theta(&self, g: &mut Graph, v: Vector) -> Vector {
        let v = self.gamma.turned(g, v);
        self.alpha.turned_about_x(g, v)
    }

    /// The second derivative U z of the unit vector z along the joint axis, from a column of U_i. `None` if the axis is not along
    /// an axis of frame i.
    pub(crate) fn bend(&self, g: &mut Graph, U: &[Vector; 3]) -> Option<Bend> {
        let axis = self.alpha.unturned_about_x(g, [Expr::ZERO, Expr::ZERO, Expr::ONE]);
        let axis = self.gamma.unturned(g, axis);
        let along: Vec<usize> = (0..3).filter(|&c| !axis[c].is_zero()).collect();
        let [c] = along[..] else { return None };
        let column = U.map(|row| g.mul(axis[c], row[c]));
        let column = self.to_link_before_theta(g, column);
        Some(Bend::of_column(column))
    }

    /// Converts a vector from components in frame j (link) to components in frame i (antecedent).
    pub fn to_antecedent(&self, g: &mut Graph, v: Vector) -> Vector {
        let v = self.theta.unturned(g, v);
        let v = self.alpha.unturned_about_x(g, v);
        self.gamma.unturned(g, v)
    }

    /// Force and moment at O_i, in frame i (antecedent), from force and moment at O_j, in frame j (link). Momentum and angular
    /// momentum change in the same form.
    pub fn wrench_to_antecedent(&self, g: &mut Graph, [f, n]: [Vector; 2]) -> [Vector; 2] {
        let (f, n) = (self.to_antecedent(g, f), self.to_antecedent(g, n));
        let lever = cross(g, self.p, f);
        [f, add(g, n, lever)]
    }
}

/// The component along the joint axis z of a wrench [force, moment], or of [momentum, angular momentum], at the link of the
/// joint: moment for a revolute joint, force for a prismatic one.
pub(crate) fn along_axis(kind: JointKind, [f, n]: [Vector; 2]) -> Expr {
    match kind {
        JointKind::Revolute => n[2],
        JointKind::Prismatic => f[2],
        JointKind::Fixed => Expr::ZERO,
    }
}

/// The twist of a link frame per unit rate of one coordinate: angular and linear part.
#[derive(Clone, Copy, Debug)]
pub struct Twist {
    /// Angular part: angular velocity per unit rate.
    pub z: Vector,
    /// Linear part: velocity of the frame's origin per unit rate.
    pub d: Vector,
}
