//! The pose of a link in the frame of its antecedent, and the twist of a frame.

use expr::{Expr, Graph};
use robot::JointKind;

use crate::kinematics::angular_motion::Bend;
use crate::kinematics::vector::{Vector, ZRotation, add, cross};

/// The pose of link j in the frame of its antecedent i.
#[derive(Clone, Debug)]
pub struct Placement {
    /// Rotation about z of frame i.
    pub gamma: ZRotation,
    /// Rotation about x, after gamma.
    pub alpha: ZRotation,
    /// Rotation about z of frame j.
    pub theta: ZRotation,
    /// The vector from O_i to O_j, in frame i, m.
    pub p: Vector,
}

impl Placement {
    /// Components in frame j of a vector given in frame i.
    pub fn to_link(&self, g: &mut Graph, v: Vector) -> Vector {
        let v = self.to_link_before_theta(g, v);
        self.theta.turned(g, v)
    }

    /// Components of a vector given in frame i, in frame j before the rotation by theta.
    pub fn to_link_before_theta(&self, g: &mut Graph, v: Vector) -> Vector {
        let v = self.gamma.turned(g, v);
        self.alpha.turned_about_x(g, v)
    }

    /// The bend of the joint's axis, from a column of U_i; `None` if the joint's axis is not along an axis of frame i.
    pub(crate) fn bend(&self, g: &mut Graph, U: &[Vector; 3]) -> Option<Bend> {
        let axis = self.alpha.unturned_about_x(g, [Expr::ZERO, Expr::ZERO, Expr::ONE]);
        let axis = self.gamma.unturned(g, axis);
        let along: Vec<usize> = (0..3).filter(|&c| !axis[c].is_zero()).collect();
        let [c] = along[..] else { return None };
        let column = U.map(|row| g.mul(axis[c], row[c]));
        let column = self.to_link_before_theta(g, column);
        Some(Bend::of_column(column))
    }

    /// Components in frame i of a vector given in frame j.
    pub fn to_antecedent(&self, g: &mut Graph, v: Vector) -> Vector {
        let v = self.theta.unturned(g, v);
        let v = self.alpha.unturned_about_x(g, v);
        self.gamma.unturned(g, v)
    }

    /// Force and moment at O_i, in frame i, from force and moment at O_j, in frame j. Momentum and angular momentum change in the
    /// same form.
    pub fn wrench_to_antecedent(&self, g: &mut Graph, [f, n]: [Vector; 2]) -> [Vector; 2] {
        let (f, n) = (self.to_antecedent(g, f), self.to_antecedent(g, n));
        let lever = cross(g, self.p, f);
        [f, add(g, n, lever)]
    }
}

/// The component along the joint axis z of [force, moment], or of [momentum, angular momentum], at the link of the joint.
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
    /// Angular part.
    pub z: Vector,
    /// Linear part, at the origin of the frame.
    pub d: Vector,
}
