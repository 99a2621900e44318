//! Velocity and acceleration of a frame f that is fixed to a link j.
//!
//! ```text
//! v_f = v_j + w_j x p,   a_f = a_j + U_j p,   U_j = [dw_j]x + [w_j]x^2
//! ```
//! w_j, dw_j: angular velocity and angular acceleration of the link; v_j, a_j: velocity and acceleration (without gravity) of
//! the link's origin; p: position of the frame in the link. The results are in the axes of the frame itself, of the base, or of
//! another link. At ddq = 0 the acceleration in the axes of the base is (dJ/dt) dq, with the Jacobian J in the axes of the
//! base. In other axes, the acceleration is the same vector with other components.

use expr::{Expr, Function, Output};

use crate::derivation::Derivation;
use crate::dynamics::link_frame::LinkFrame;
use crate::dynamics::momenta::velocities;
use crate::dynamics::reference_frame::{ReferenceFrame, constants, in_axes_of, suffix, turned_to};
use crate::kinematics::links::{JointVariables, MotionInput, link_motions_under};
use crate::kinematics::vector::{NULL, Vector, add, cross, dot};

impl Derivation<'_> {
    /// Linear velocity of a frame's origin, m/s, and angular velocity of the frame, rad/s, as a function: inputs `q`, `dq`,
    /// output `v` (6), in the axes of `reference`, or of the frame itself for `None`.
    pub fn velocity(&mut self, frame: impl Into<LinkFrame>, reference: Option<&ReferenceFrame>) -> Function {
        let frame = &frame.into();
        let Derivation { robot, graph: g, motion, links, .. } = self;
        let w: Vec<Vector> = links.iter().map(|link| link.w).collect();
        let v = velocities(g, robot, links, &w, &motion.dq)[frame.link.0];
        let p = constants(g, frame.pose.position);
        let w = links[frame.link.0].w;
        let lever = cross(g, w, p);
        let v = add(g, v, lever);
        let inputs = [motion.configuration(), vec![motion.input(MotionInput::Dq)]].concat();
        let entries = expressed(self, [v, w], frame, reference);
        let output = Output { name: "v".into(), rows: 6, columns: 1, entries };
        Function::new(&(frame.function("velocity") + &suffix(reference)), &self.graph, inputs, vec![output])
    }

    /// Linear acceleration of a frame's origin, m/s^2, and angular acceleration of the frame, rad/s^2, as a function: inputs
    /// `q`, `dq`, `ddq`, output `a` (6), in the axes of `reference`, or of the frame itself for `None`.
    pub fn acceleration(&mut self, frame: impl Into<LinkFrame>, reference: Option<&ReferenceFrame>) -> Function {
        let frame = &frame.into();
        let moving = self.motion.clone();
        let entries = accelerations(self, &moving, frame, reference);
        let output = Output { name: "a".into(), rows: 6, columns: 1, entries };
        let inputs = self.motion.inputs();
        Function::new(&(frame.function("acceleration") + &suffix(reference)), &self.graph, inputs, vec![output])
    }

    /// The acceleration of a frame at ddq = 0, as a function: inputs `q`, `dq`, output `a` (6), in the axes of `reference`, or of
    /// the frame itself for `None`. It equals (dJ/dt) dq, with the Jacobian J in the axes of the base.
    pub fn jacobian_rate(&mut self, frame: impl Into<LinkFrame>, reference: Option<&ReferenceFrame>) -> Function {
        let frame = &frame.into();
        let coasting = self.coasting();
        let entries = accelerations(self, &coasting, frame, reference);
        let output = Output { name: "a".into(), rows: 6, columns: 1, entries };
        let motion = &self.motion;
        let inputs = [motion.configuration(), vec![motion.input(MotionInput::Dq)]].concat();
        Function::new(&(frame.function("jdot_dq") + &suffix(reference)), &self.graph, inputs, vec![output])
    }
}

fn accelerations(
    derivation: &mut Derivation,
    moving: &JointVariables,
    frame: &LinkFrame,
    reference: Option<&ReferenceFrame>,
) -> Vec<Expr> {
    let Derivation { robot, graph: g, constants: of_robot, .. } = derivation;
    let links = link_motions_under(g, robot, of_robot, moving, NULL);
    let link = &links[frame.link.0];
    let p = constants(g, frame.pose.position);
    let offset = link.angular_motion.U.map(|row| dot(g, row, p));
    let a = add(g, link.a, offset);
    let dw = link.angular_motion.dw;
    expressed(derivation, [a, dw], frame, reference)
}

/// Converts two vectors from the axes of the frame's link to the axes of `reference`, or of the frame for `None`.
fn expressed(
    derivation: &mut Derivation,
    vectors: [Vector; 2],
    frame: &LinkFrame,
    reference: Option<&ReferenceFrame>,
) -> Vec<Expr> {
    let Derivation { robot, graph: g, links, .. } = derivation;
    let turned = vectors.map(|v| match reference {
        None => turned_to(g, &frame.pose, v),
        Some(reference) => in_axes_of(g, robot, links, v, frame.link, reference),
    });
    turned.concat()
}
