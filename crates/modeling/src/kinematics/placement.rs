//! Where a link stands in the frame of the link before, and the twist of a frame.

use expr::{Expr, Graph};

use crate::kinematics::spin::Bend;
use crate::kinematics::vector::{Turn, Vector};

/// Where a link stands in its antecedent's frame.
#[derive(Clone, Debug)]
pub(crate) struct Placement {
    pub gamma: Turn,
    pub alpha: Turn,
    pub theta: Turn,
    /// O_j from O_i, in frame i.
    pub p: Vector,
}

impl Placement {
    /// Components in frame j of a vector given in frame i.
    pub(crate) fn to_link(&self, g: &mut Graph, v: Vector) -> Vector {
        let v = self.to_link_before_theta(g, v);
        self.theta.turned(g, v)
    }

    pub(crate) fn to_link_before_theta(&self, g: &mut Graph, v: Vector) -> Vector {
        let v = self.gamma.turned(g, v);
        self.alpha.turned_about_x(g, v)
    }

    /// The bend of the joint's axis where it is along an axis of frame i: from that column of U_i.
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
    pub(crate) fn to_antecedent(&self, g: &mut Graph, v: Vector) -> Vector {
        let v = self.theta.unturned(g, v);
        let v = self.alpha.unturned_about_x(g, v);
        self.gamma.unturned(g, v)
    }
}

/// Angular and linear part of the twist of a link frame per unit of one coordinate's rate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Twist {
    pub z: Vector,
    pub d: Vector,
}
