//! The joint torques, by recursive Newton-Euler in the moments about the frame origins.
//!
//! ```text
//! f_j = M_j a_j + U_j MS_j + sum_children R f_c
//! n_j = J_j dw_j + w_j x (J_j w_j) + MS_j x a_j + sum_children (R n_c + p x R f_c)
//! tau_j = z . n_j (revolute) or z . f_j (prismatic) + IA_j ddq_j
//! ```
//! [Khalil, Kleinfinger 1987]. With base parameters most masses, MZ and YY are zero and their terms
//! are not there. The forces here travel inward, where the regressor's twists travel outward: the two
//! share the link motions and nothing else.

use expr::{Expr, Function, Graph, Output};
use robot::{Inertial, JointKind};

use crate::derivation::Derivation;
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::kinematics::implicit::reduced;
use crate::kinematics::links::LinkMotion;
use crate::kinematics::vector::{NULL, Vector, add, cross, dot, sum};

/// tau(q, dq, ddq, x).
pub(crate) fn torque(derivation: &mut Derivation, name: &str, x: &ParameterInputs) -> Function {
    let links = std::mem::take(&mut derivation.links);
    let tau = entries(derivation, &links, x);
    derivation.links = links;
    let mut inputs = derivation.motion.inputs();
    inputs.push(x.input());
    let output = Output { name: "tau".into(), rows: tau.len(), columns: 1, entries: tau };
    Function::new(name, &derivation.graph, inputs, vec![output])
}

/// The entries of tau for these link motions.
pub(crate) fn entries(derivation: &mut Derivation, links: &[LinkMotion], x: &ParameterInputs) -> Vec<Expr> {
    let Derivation { robot, graph: g, implicit, .. } = derivation;
    let mut tau = vec![Expr::ZERO; robot.n_variables()];
    let mut from_children = vec![(NULL, NULL); robot.links.len()];
    for j in robot.link_ids().rev() {
        let link = robot.link(j);
        let (own_f, own_n) = wrench(g, &links[j.0], x.body(j));
        let (child_f, child_n) = from_children[j.0];
        let (f, n) = (add(g, own_f, child_f), add(g, own_n, child_n));

        let along = match link.joint.kind {
            JointKind::Revolute => n[2],
            JointKind::Prismatic => f[2],
            JointKind::Fixed => Expr::ZERO,
        };
        let rotor = g.mul(x.get(j, Inertial::Ia), links[j.0].joint_acceleration);
        let along = g.add(along, rotor);
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
    match implicit {
        None => tau,
        Some(implicit) => reduced(g, &implicit.G, &tau.into_iter().map(|t| vec![t]).collect::<Vec<_>>()).concat(),
    }
}

/// Force and moment at O_j that move link j, from its ten parameters.
fn wrench(g: &mut Graph, j: &LinkMotion, body: [Expr; 10]) -> (Vector, Vector) {
    let [xx, xy, xz, yy, yz, zz, mx, my, mz, m] = body;
    let (U, s) = (&j.U, [mx, my, mz]);
    let ma = j.a.map(|a| g.mul(m, a));
    let us = U.map(|row| dot(g, row, s));
    let f = add(g, ma, us);

    // J dw + w x (J w), gathered by parameter so that U serves twice.
    let [wx, wy, wz] = j.w;
    let mut row = |(diagonal, dw): (Expr, Expr),
                   (plus, minus): (Expr, Expr),
                   (a, b): (Expr, Expr),
                   rest: [(Expr, Expr); 2],
                   (product, c, d): (Expr, Expr, Expr)| {
        let (cc, dd) = (g.mul(c, c), g.mul(d, d));
        let squares = g.sub(cc, dd);
        let (difference, ab) = (g.sub(plus, minus), g.mul(a, b));
        let terms = [
            g.mul(diagonal, dw),
            g.mul(difference, ab),
            g.mul(rest[0].0, rest[0].1),
            g.mul(rest[1].0, rest[1].1),
            g.mul(product, squares),
        ];
        sum(g, &terms)
    };
    let about_o = [
        row((xx, j.dw[0]), (zz, yy), (wy, wz), [(xy, -U[2][0]), (xz, U[1][0])], (yz, wy, wz)),
        row((yy, j.dw[1]), (xx, zz), (wx, wz), [(xy, U[2][1]), (yz, -U[0][1])], (xz, wz, wx)),
        row((zz, j.dw[2]), (yy, xx), (wx, wy), [(xz, -U[1][2]), (yz, U[0][2])], (xy, wx, wy)),
    ];
    let first = cross(g, s, j.a);
    (f, add(g, about_o, first))
}
