//! The accelerations that follow from the torques, ddq = A(q)^-1 (tau - h(q, dq)); A: inertia matrix, h: bias torque.

use expr::{Expr, Function, Input, Output, SymbolKind};

use crate::base::base_parameters::BaseParameters;
use crate::derivation::Derivation;
use crate::dynamics::factor::Factor;
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::dynamics::{inertia_matrix, torque};
use crate::kinematics::links::MotionInput;
use crate::kinematics::names::coordinate_labels;

impl Derivation<'_> {
    /// The accelerations as a function: inputs `q`, `dq`, `tau`, `x` (X_base), output `ddq`, rad/s^2 (m/s^2).
    pub fn forward_dynamics(&mut self, base: &BaseParameters) -> Function {
        let x = &ParameterInputs::base(self, base);
        let n = self.robot.n_coordinates();
        let a = inertia_matrix::entries(self, x);
        let links = self.coasting_links();
        let bias = torque::entries(self, &links, x);
        let labels = coordinate_labels(self.robot);
        let g = &mut self.graph;
        let tau: Vec<Expr> = labels.iter().map(|k| g.symbol(&format!("tau{k}"), SymbolKind::Input)).collect();
        let right = (0..n).map(|k| g.sub(tau[k], bias[k])).collect();
        let ddq = Factor::new(g, a, n).solve(g, right);
        let motion = &self.motion;
        let inputs = [
            motion.configuration(),
            vec![motion.input(MotionInput::Dq), Input { name: "tau".into(), entries: tau }, x.input()],
        ]
        .concat();
        let output = Output { name: "ddq".into(), rows: n, columns: 1, entries: ddq };
        Function::new("forward_dynamics", g, inputs, vec![output])
    }

    /// The inverse of the inertia matrix as a function: inputs `q`, `x` (X_base), output `inverse` (n x n).
    pub fn inverse_inertia_matrix(&mut self, base: &BaseParameters) -> Function {
        let x = &ParameterInputs::base(self, base);
        let n = self.robot.n_coordinates();
        let a = inertia_matrix::entries(self, x);
        let g = &mut self.graph;
        let entries = Factor::new(g, a, n).inverse(g);
        let inputs = [self.motion.configuration(), vec![x.input()]].concat();
        let output = Output { name: "inverse".into(), rows: n, columns: n, entries };
        Function::new("inverse_inertia_matrix", &self.graph, inputs, vec![output])
    }
}
