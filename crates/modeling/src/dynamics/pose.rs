//! The pose and the Jacobian of a link or of a frame fixed to a link, and the joint torques of an external wrench.
//!
//! ```text
//! T_0j = [R_0j p_0j]            3 x 4, in the base frame
//! V_j  = J_j dq                 6 x n: velocity of O_j, then angular velocity, in frame j
//! tau  = J_j^T F_j              F_j: force, then moment at O_j, that link j exerts on the environment
//! ```
//! For a frame f fixed to link j, with R = R_jf and p = p_jf: T_0f = T_0j T_jf, v_f = R^T (v_j + w_j x p), w_f = R^T w_j.

use expr::{Expr, Function, Input, Output, SymbolKind};

use crate::derivation::Derivation;
use crate::dynamics::link_frame::LinkFrame;
use crate::dynamics::reference_frame::{ReferenceFrame, at_place_of, constants, in_axes_of, suffix, turned_to};
use crate::kinematics::implicit::reduced;
use crate::kinematics::links::Twist;
use crate::kinematics::vector::{NULL, Vector, add, cross, plus_dot};

impl Derivation<'_> {
    /// Pose of a link, or of a frame fixed to a link, in the base frame, as a function: input `q`, output `t` (3 x 4):
    /// rotation, position in m.
    pub fn pose(&mut self, frame: impl Into<LinkFrame>) -> Function {
        let frame = &frame.into();
        let Derivation { robot, graph: g, motion, links, .. } = self;
        let (R, p) = (&frame.pose.rotation, &frame.pose.position);
        let mut columns = [0, 1, 2].map(|c| [0, 1, 2].map(|r| g.constant(R[r][c]))).to_vec();
        columns.push(p.map(|x| g.constant(x)));
        let mut columns: [Vector; 4] = std::array::from_fn(|c| columns[c]);
        let mut at = Some(frame.link);
        while let Some(k) = at {
            let placement = &links[k.0].placement;
            columns = columns.map(|v| placement.to_antecedent(g, v));
            columns[3] = add(g, columns[3], placement.p);
            at = robot.link(k).antecedent;
        }
        let entries = (0..3).flat_map(|r| columns.map(|c| c[r])).collect();
        let output = Output { name: "t".into(), rows: 3, columns: 4, entries };
        Function::new(&frame.function("pose"), g, motion.configuration(), vec![output])
    }

    /// Pose of a frame in a reference frame, as a function: input `q`, output `t` (3 x 4): rotation, position in m.
    pub fn pose_in(&mut self, frame: impl Into<LinkFrame>, reference: &ReferenceFrame) -> Function {
        let frame = &frame.into();
        let Derivation { robot, graph: g, motion, links, .. } = self;
        let axes = transposed(&frame.pose.rotation).map(|axis| constants(g, axis));
        let p = constants(g, frame.pose.position);
        let axes = axes.map(|axis| in_axes_of(g, robot, links, axis, frame.link, reference));
        let p = at_place_of(g, robot, links, p, frame.link, reference);
        let columns = [axes[0], axes[1], axes[2], p];
        let entries = (0..3).flat_map(|r| columns.map(|c| c[r])).collect();
        let output = Output { name: "t".into(), rows: 3, columns: 4, entries };
        let name = frame.function("pose") + &suffix(Some(reference));
        Function::new(&name, g, motion.configuration(), vec![output])
    }

    /// Jacobian of a link or of a frame fixed to a link, as a function: input `q`, output `j` (6 x n): velocity of the frame's
    /// origin, then angular velocity, in the axes of the frame, per unit rate of each coordinate.
    pub fn jacobian(&mut self, frame: impl Into<LinkFrame>) -> Function {
        jacobian(self, &frame.into(), None)
    }

    /// Jacobian of a frame in the axes of a reference frame, as a function: input `q`, output `j` (6 x n): velocity of the
    /// frame's origin, then angular velocity.
    pub fn jacobian_in(&mut self, frame: impl Into<LinkFrame>, reference: &ReferenceFrame) -> Function {
        jacobian(self, &frame.into(), Some(reference))
    }

    /// Jacobian of a point that is fixed to a frame, as a function: inputs `q`, `point` (3, m, in the frame), output `j` (6 x n),
    /// in the axes of `reference`, or of the frame itself for `None`.
    pub fn point_jacobian(&mut self, frame: impl Into<LinkFrame>, reference: Option<&ReferenceFrame>) -> Function {
        let frame = &frame.into();
        let g = &mut self.graph;
        let point = ["px", "py", "pz"].map(|name| g.symbol(name, SymbolKind::Input));
        let p = [0, 1, 2].map(|r| {
            let (row, origin) = (frame.pose.rotation[r].map(|x| g.constant(x)), g.constant(frame.pose.position[r]));
            plus_dot(g, origin, row, point)
        });
        let rows = jacobian_rows(self, frame, reference, p);
        let n = self.robot.n_coordinates();
        let output = Output { name: "j".into(), rows: 6, columns: n, entries: rows.concat() };
        let inputs =
            [self.motion.configuration(), vec![Input { name: "point".into(), entries: point.to_vec() }]].concat();
        let name = frame.function("point_jacobian") + &suffix(reference);
        Function::new(&name, &self.graph, inputs, vec![output])
    }

    /// Joint torques that balance a wrench, as a function: inputs `q`, `wrench` (force, then moment about the frame's origin,
    /// that the link exerts on the environment, in the axes of the frame), output `tau`.
    pub fn external_torque(&mut self, frame: impl Into<LinkFrame>) -> Function {
        let frame = &frame.into();
        let p = constants(&mut self.graph, frame.pose.position);
        let rows = jacobian_rows(self, frame, None, p);
        let n = self.robot.n_coordinates();
        let g = &mut self.graph;
        let wrench: Vec<Expr> =
            ["fx", "fy", "fz", "nx", "ny", "nz"].map(|name| g.symbol(name, SymbolKind::Input)).to_vec();
        let mut tau = vec![Expr::ZERO; n];
        for (k, tau) in tau.iter_mut().enumerate() {
            for (row, &component) in rows.iter().zip(&wrench) {
                let term = g.mul(row[k], component);
                *tau = g.add(*tau, term);
            }
        }
        let inputs = [self.motion.configuration(), vec![Input { name: "wrench".into(), entries: wrench }]].concat();
        let output = Output { name: "tau".into(), rows: n, columns: 1, entries: tau };
        Function::new(&frame.function("external_torque"), &self.graph, inputs, vec![output])
    }
}

/// The Jacobian of the frame's origin as a function: input `q`; output `j`, 6 x n, in the axes of `reference` (`None`: of the
/// frame).
fn jacobian(derivation: &mut Derivation, frame: &LinkFrame, reference: Option<&ReferenceFrame>) -> Function {
    let p = constants(&mut derivation.graph, frame.pose.position);
    let rows = jacobian_rows(derivation, frame, reference, p);
    let n = derivation.robot.n_coordinates();
    let output = Output { name: "j".into(), rows: 6, columns: n, entries: rows.concat() };
    let name = frame.function("jacobian") + &suffix(reference);
    Function::new(&name, &derivation.graph, derivation.motion.configuration(), vec![output])
}

/// Jacobian of the point p, which is given in the link's frame, 6 rows: velocity, then angular velocity, per unit rate of each
/// coordinate. The rows are in the axes of `reference`, or of the frame for `None`.
pub(crate) fn jacobian_rows(
    derivation: &mut Derivation,
    frame: &LinkFrame,
    reference: Option<&ReferenceFrame>,
    p: Vector,
) -> Vec<Vec<Expr>> {
    let Derivation { robot, graph: g, links, .. } = derivation;
    let mut column = |t: &Option<Twist>| -> Vec<Expr> {
        let (v, w) = t.map_or((NULL, NULL), |t| (t.d, t.z));
        let lever = cross(g, w, p);
        let v = add(g, v, lever);
        let turned = [v, w].map(|part| match reference {
            None => turned_to(g, &frame.pose, part),
            Some(reference) => in_axes_of(g, robot, links, part, frame.link, reference),
        });
        turned.concat()
    };
    let columns: Vec<Vec<Expr>> = links[frame.link.0].jacobian.iter().map(&mut column).collect();
    let columns = match &derivation.implicit {
        None => columns,
        Some(implicit) => reduced(&mut derivation.graph, &implicit.G, &columns),
    };
    (0..6).map(|row| columns.iter().map(|c| c[row]).collect()).collect()
}

fn transposed(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|c| [0, 1, 2].map(|r| m[r][c]))
}
