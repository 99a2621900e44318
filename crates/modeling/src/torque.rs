//! The joint torques, by recursive Newton-Euler in the moments about the frame origins.
//!
//! ```text
//! f_j = M_j a_j + U_j MS_j + sum_children R f_c
//! n_j = J_j dw_j + w_j x (J_j w_j) + MS_j x a_j + sum_children (R n_c + p x R f_c)
//! tau_j = z . n_j (revolute) or z . f_j (prismatic) + IA_j ddq_j
//! ```
//! [Khalil, Kleinfinger 1987]. The forces here travel inward, where the regressor's twists travel
//! outward: the two share the link motions and nothing else.

use expr::{Expr, Function, Graph, Input, Output, SymbolKind};
use robot::{Inertial, JointKind, LinkId, StandardParameter};

use crate::derivation::Derivation;
use crate::kinematics::LinkMotion;
use crate::vector::{NULL, Vector, add, cross, dot};

/// tau(q, dq, ddq, x).
pub(crate) fn torque(derivation: &mut Derivation) -> Function {
    let Derivation { robot, graph: g, motion, links, .. } = derivation;
    let parameters = StandardParameter::all(robot);
    let x: Vec<Expr> = (0..parameters.len()).map(|c| g.symbol(&format!("x[{c}]"), SymbolKind::Input)).collect();
    let value = |j: LinkId, inertial: Inertial| {
        parameters.iter().position(|p| *p == StandardParameter { link: j, inertial }).map(|c| x[c])
    };

    let mut tau = vec![Expr::ZERO; robot.n_coordinates()];
    let mut from_children = vec![(NULL, NULL); robot.links.len()];
    for j in robot.link_ids().rev() {
        let link = robot.link(j);
        let body = Inertial::BODY.map(|i| value(j, i).unwrap_or(Expr::ZERO));
        let (own_f, own_n) = wrench(g, &links[j.0], body);
        let (child_f, child_n) = from_children[j.0];
        let (f, n) = (add(g, own_f, child_f), add(g, own_n, child_n));

        let mut along = match link.joint.kind {
            JointKind::Revolute => n[2],
            JointKind::Prismatic => f[2],
            JointKind::Fixed => Expr::ZERO,
        };
        if let Some(rotor) = value(j, Inertial::Ia) {
            let inertia = g.mul(rotor, links[j.0].joint_acceleration);
            along = g.add(along, inertia);
        }
        for &(k, c) in &link.joint.variable.terms {
            let c = g.constant(c);
            let term = g.mul(c, along);
            tau[k.0] = g.add(tau[k.0], term);
        }
        if let Some(i) = link.antecedent {
            let placement = &links[j.0].placement;
            let (f, n) = (placement.to_antecedent(g, f), placement.to_antecedent(g, n));
            let lever = cross(g, placement.p, f);
            let n = add(g, n, lever);
            let (sum_f, sum_n) = from_children[i.0];
            from_children[i.0] = (add(g, sum_f, f), add(g, sum_n, n));
        }
    }
    let mut inputs = motion.inputs();
    inputs.push(Input { name: "x".into(), entries: x });
    let output = Output { name: "tau".into(), rows: tau.len(), columns: 1, entries: tau };
    Function::new("torque", g, inputs, vec![output])
}

/// Force and moment at O_j that move link j, from its ten parameters.
fn wrench(g: &mut Graph, j: &LinkMotion, body: [Expr; 10]) -> (Vector, Vector) {
    let [xx, xy, xz, yy, yz, zz, mx, my, mz, m] = body;
    let (J, s) = ([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], [mx, my, mz]);
    let ma = j.a.map(|a| g.mul(m, a));
    let us = j.U.map(|row| dot(g, row, s));
    let f = add(g, ma, us);

    let j_dw = J.map(|row| dot(g, row, j.dw));
    let j_w = J.map(|row| dot(g, row, j.w));
    let gyroscopic = cross(g, j.w, j_w);
    let first = cross(g, s, j.a);
    let n = add(g, j_dw, gyroscopic);
    (f, add(g, n, first))
}
