//! Access to the expressions of a derivation: the expression graph of a robot, the geometry of its links, their twists and
//! Jacobians. Other packages derive further functions from them.

use expr::{Expr, Graph, Input};
use robot::{LinkId, Robot};

use crate::derivation::Derivation;
use crate::dynamics::link_frame::LinkFrame;
use crate::dynamics::pose;
use crate::dynamics::reference_frame::{self, ReferenceFrame};

pub use crate::dynamics::reference_frame::constants;
pub use crate::kinematics::angle::Angle;
pub use crate::kinematics::links::Geometry;
pub use crate::kinematics::placement::{Placement, Twist};
pub use crate::kinematics::vector::{NULL, Vector, ZRotation, add, cross, dot};

impl<'a> Derivation<'a> {
    /// The robot for which the expressions are derived.
    pub fn robot(&self) -> &'a Robot {
        self.robot
    }

    /// The graph that holds all expressions of the derivation.
    pub fn graph(&mut self) -> &mut Graph {
        &mut self.graph
    }

    /// Whether every loop of the robot is closed by affine relations of its joints; false if a loop is closed numerically.
    pub fn closes_by_relations(&self) -> bool {
        self.implicit.is_none()
    }

    /// The configuration as inputs of a function: `q`.
    pub fn configuration(&self) -> Vec<Input> {
        self.motion.configuration()
    }

    /// The geometry gamma, b, alpha, d, theta, r (rad and m) of a link at joint variable zero.
    pub fn geometry(&mut self, link: LinkId) -> Geometry {
        Geometry::of(&mut self.graph, &mut self.constants, self.robot.link(link))
    }

    /// The pose of the frame of `link` in the frame of its antecedent.
    pub fn placement(&self, link: LinkId) -> &Placement {
        &self.links[link.0].placement
    }

    /// The twist of the frame of `link` per unit rate of a coordinate; `None` if the coordinate does not move this link.
    pub fn twist(&self, link: LinkId, coordinate: usize) -> Option<Twist> {
        self.links[link.0].jacobian[coordinate]
    }

    /// Converts the vector `v` from the axes of link `from` to the axes of the reference frame.
    pub fn in_axes_of(&mut self, v: Vector, from: LinkId, reference: &ReferenceFrame) -> Vector {
        reference_frame::in_axes_of(&mut self.graph, self.robot, &self.links, v, from, reference)
    }

    /// Converts the point `p` from the frame of link `from` to the reference frame, m.
    pub fn at_place_of(&mut self, p: Vector, from: LinkId, reference: &ReferenceFrame) -> Vector {
        reference_frame::at_place_of(&mut self.graph, self.robot, &self.links, p, from, reference)
    }

    /// The Jacobian of the origin of a frame, in the axes of this frame: six rows (velocity, then angular velocity), one column
    /// per coordinate.
    pub fn jacobian_rows(&mut self, frame: &LinkFrame) -> Vec<Vec<Expr>> {
        pose::jacobian_rows(self, frame, None, NULL)
    }
}
