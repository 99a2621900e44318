//! The accelerations from the torques: ddq = A(q)^-1 (tau - h(q, dq)).

use expr::{Expr, Function, Input, Output, SymbolKind};

use crate::derivation::Derivation;
use crate::dynamics::factor::Factor;
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::dynamics::{inertia_matrix, torque};
use crate::kinematics::links::MotionInput;
use crate::kinematics::names::coordinate_labels;

/// Inputs `q`, `dq`, `tau`, `x`; output `ddq`.
pub(crate) fn forward_dynamics(derivation: &mut Derivation, x: &ParameterInputs) -> Function {
    let n = derivation.robot.n_coordinates();
    let a = inertia_matrix::entries(derivation, x);
    let links = derivation.coasting_links();
    let bias = torque::entries(derivation, &links, x);
    let labels = coordinate_labels(derivation.robot);
    let g = &mut derivation.graph;
    let tau: Vec<Expr> = labels.iter().map(|k| g.symbol(&format!("tau{k}"), SymbolKind::Input)).collect();
    let right = (0..n).map(|k| g.sub(tau[k], bias[k])).collect();
    let ddq = Factor::new(g, a, n).solve(g, right);
    let motion = &derivation.motion;
    let mut inputs = motion.configuration();
    inputs.extend([motion.input(MotionInput::Dq), Input { name: "tau".into(), entries: tau }, x.input()]);
    let output = Output { name: "ddq".into(), rows: n, columns: 1, entries: ddq };
    Function::new("forward_dynamics", g, inputs, vec![output])
}

/// A(q, x)^-1: inputs `q` and `x`, output `inverse` (n x n).
pub(crate) fn inverse_inertia_matrix(derivation: &mut Derivation, x: &ParameterInputs) -> Function {
    let n = derivation.robot.n_coordinates();
    let a = inertia_matrix::entries(derivation, x);
    let g = &mut derivation.graph;
    let entries = Factor::new(g, a, n).inverse(g);
    let mut inputs = derivation.motion.configuration();
    inputs.push(x.input());
    let output = Output { name: "inverse".into(), rows: n, columns: n, entries };
    Function::new("inverse_inertia_matrix", &derivation.graph, inputs, vec![output])
}
