//! Where a link is, how it moves with the coordinates, and what a force on it does to the torques.
//!
//! ```text
//! T_0j = [R_0j p_0j]            3 x 4, in the base frame
//! V_j  = J_j dq                 6 x n: velocity of O_j, then angular velocity, in frame j
//! tau  = J_j^T F_j              F_j: force, then moment at O_j, that link j exerts on the environment
//! ```

use expr::{Expr, Function, Input, Output, SymbolKind};
use robot::LinkId;

use crate::derivation::Derivation;
use crate::kinematics::implicit::reduced;
use crate::kinematics::links::Twist;
use crate::kinematics::vector::{NULL, add};

/// Input `q`; output `t`, 3 x 4: orientation and position of the link's frame in the base frame.
pub(crate) fn pose(derivation: &mut Derivation, j: LinkId) -> Function {
    let Derivation { robot, graph: g, motion, links, .. } = derivation;
    let unit = |i: usize| std::array::from_fn(|r| if r == i { Expr::ONE } else { Expr::ZERO });
    let mut columns = [unit(0), unit(1), unit(2), NULL];
    let mut at = Some(j);
    while let Some(k) = at {
        let placement = &links[k.0].placement;
        columns = columns.map(|v| placement.to_antecedent(g, v));
        columns[3] = add(g, columns[3], placement.p);
        at = robot.link(k).antecedent;
    }
    let entries = (0..3).flat_map(|r| columns.map(|c| c[r])).collect();
    let output = Output { name: "t".into(), rows: 3, columns: 4, entries };
    Function::new("pose", g, motion.configuration(), vec![output])
}

/// Input `q`; output `j`, 6 x n.
pub(crate) fn jacobian(derivation: &mut Derivation, j: LinkId) -> Function {
    let rows = jacobian_rows(derivation, j);
    let n = derivation.robot.n_coordinates();
    let output = Output { name: "j".into(), rows: 6, columns: n, entries: rows.concat() };
    Function::new("jacobian", &derivation.graph, derivation.motion.configuration(), vec![output])
}

/// Inputs `q`, `wrench` (6); output `tau` (n): what to add to the torques when link j exerts the wrench.
pub(crate) fn external_torque(derivation: &mut Derivation, j: LinkId) -> Function {
    let rows = jacobian_rows(derivation, j);
    let n = derivation.robot.n_coordinates();
    let g = &mut derivation.graph;
    let wrench: Vec<Expr> = (0..6).map(|i| g.symbol(&format!("wrench[{i}]"), SymbolKind::Input)).collect();
    let mut tau = vec![Expr::ZERO; n];
    for (k, tau) in tau.iter_mut().enumerate() {
        for (row, &component) in rows.iter().zip(&wrench) {
            let term = g.mul(row[k], component);
            *tau = g.add(*tau, term);
        }
    }
    let mut inputs = derivation.motion.configuration();
    inputs.push(Input { name: "wrench".into(), entries: wrench });
    let output = Output { name: "tau".into(), rows: n, columns: 1, entries: tau };
    Function::new("external_torque", &derivation.graph, inputs, vec![output])
}

fn jacobian_rows(derivation: &mut Derivation, j: LinkId) -> Vec<Vec<Expr>> {
    let entry = |t: &Option<Twist>, row: usize| t.map_or(Expr::ZERO, |t| if row < 3 { t.d[row] } else { t.z[row - 3] });
    let columns: Vec<Vec<Expr>> =
        derivation.links[j.0].jacobian.iter().map(|t| (0..6).map(|row| entry(t, row)).collect()).collect();
    let columns = match &derivation.implicit {
        None => columns,
        Some(implicit) => reduced(&mut derivation.graph, &implicit.G, &columns),
    };
    (0..6).map(|row| columns.iter().map(|c| c[row]).collect()).collect()
}
