//! What passes through the joints: the force and the moment with which the link before moves each link.
//!
//! ```text
//! F_j = (f_j, n_j)     force, then moment at O_j, in frame j; N, N m
//! ```
//! by the recursion of the torques (`torque.rs`), gravity included. The entry along the joint axis is the torque of the
//! joint less IA ddq, since a rotor acts at its drive. Regrouped parameters give other forces than those of the bodies, so
//! the standard ones are needed. In a loop the forces of the cut joint pass through the others: those are not here.

use expr::{Expr, Function, Output};

use crate::derivation::Derivation;
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::dynamics::torque::wrenches;

/// Inputs `q`, `dq`, `ddq`, `x` (the standard parameters); output `f` (6 x links), one column per link.
pub(crate) fn joint_reactions(derivation: &mut Derivation, x: &ParameterInputs) -> Function {
    let Derivation { robot, graph: g, motion, links, .. } = derivation;
    let columns: Vec<Vec<Expr>> = wrenches(g, robot, links, x).into_iter().map(|(f, n)| [f, n].concat()).collect();
    let entries = (0..6).flat_map(|row| columns.iter().map(move |column| column[row])).collect();
    let output = Output { name: "f".into(), rows: 6, columns: columns.len(), entries };
    let mut inputs = motion.inputs();
    inputs.push(x.input());
    Function::new("joint_reactions", g, inputs, vec![output])
}
