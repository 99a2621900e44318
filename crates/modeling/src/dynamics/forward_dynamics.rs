//! The accelerations from the torques: ddq = A(q)^-1 (tau - h(q, dq)).
//!
//! A = L D L^T by elimination, written out [Cholesky]; A is positive definite for physical
//! parameters, so that no pivot vanishes.

use expr::{Expr, Function, Input, Output, SymbolKind};

use crate::derivation::Derivation;
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::dynamics::{inertia_matrix, torque};
use crate::kinematics::links::{MotionInput, coordinate_labels};

/// Inputs `q`, `dq`, `tau`, `x`; output `ddq`.
pub(crate) fn forward_dynamics(derivation: &mut Derivation, x: &ParameterInputs) -> Function {
    let n = derivation.robot.n_coordinates();
    let mut a = inertia_matrix::entries(derivation, x);
    let links = derivation.coasting_links();
    let bias = torque::entries(derivation, &links, x);
    let labels = coordinate_labels(derivation.robot);
    let g = &mut derivation.graph;
    let tau: Vec<Expr> = labels.iter().map(|k| g.symbol(&format!("tau{k}"), SymbolKind::Input)).collect();
    let mut y: Vec<Expr> = (0..n).map(|k| g.sub(tau[k], bias[k])).collect();

    // Column by column, L^T takes the place of A above the diagonal, and D on it. On the way, y = L^-1 (tau - h).
    for c in 0..n {
        for r in c + 1..n {
            let scaled = a[r * n + c];
            if scaled.is_zero() {
                continue;
            }
            let l = g.div(scaled, a[c * n + c]);
            for k in c + 1..=r {
                let product = g.mul(l, a[k * n + c]);
                a[r * n + k] = g.sub(a[r * n + k], product);
            }
            let carried = g.mul(l, y[c]);
            y[r] = g.sub(y[r], carried);
        }
        for r in c + 1..n {
            a[c * n + r] = if a[r * n + c].is_zero() { Expr::ZERO } else { g.div(a[r * n + c], a[c * n + c]) };
        }
    }
    let mut ddq = vec![Expr::ZERO; n];
    for r in (0..n).rev() {
        let mut value = g.div(y[r], a[r * n + r]);
        for k in r + 1..n {
            let product = g.mul(a[r * n + k], ddq[k]);
            value = g.sub(value, product);
        }
        ddq[r] = value;
    }
    let motion = &derivation.motion;
    let mut inputs = motion.configuration();
    inputs.extend([motion.input(MotionInput::Dq), Input { name: "tau".into(), entries: tau }, x.input()]);
    let output = Output { name: "ddq".into(), rows: n, columns: 1, entries: ddq };
    Function::new("forward_dynamics", g, inputs, vec![output])
}
