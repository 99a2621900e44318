//! Joint friction torques, which are linear in the friction parameters.
//!
//! ```text
//! tau_f,k = FV_k dq_k + FS_k sign(dq_k) + OFF_k
//! ```
//! FV: viscous friction, FS: dry friction, OFF: offset. The sign of dq is an input. So the caller chooses the sign at rest, and
//! the function has no jump.

use expr::{Expr, Function, Input, Output, SymbolKind};

use crate::derivation::Derivation;
use crate::kinematics::links::MotionInput;
use crate::kinematics::names::coordinate_labels;
use crate::kinematics::vector::sum;

impl Derivation<'_> {
    /// Friction torques as a function: inputs `dq`, `sign_dq` (n each) and `f` (FV FS OFF of each coordinate), output `tau`, N m
    /// (N).
    pub fn friction(&mut self) -> Function {
        let n = self.robot.n_coordinates();
        let labels = coordinate_labels(self.robot);
        let g = &mut self.graph;
        let mut inputs = |name: &str, letters: &[&str]| -> Input {
            let names = labels.iter().flat_map(|label| letters.iter().map(move |letters| format!("{letters}{label}")));
            Input { name: name.into(), entries: names.map(|name| g.symbol(&name, SymbolKind::Input)).collect() }
        };
        let (sign, f) = (inputs("sign_dq", &["sign_dq"]), inputs("f", &["FV", "FS", "OFF"]));
        let dq = self.motion.input(MotionInput::Dq);
        let entries: Vec<Expr> = (0..n)
            .map(|k| {
                let viscous = g.mul(f.entries[3 * k], dq.entries[k]);
                let coulomb = g.mul(f.entries[3 * k + 1], sign.entries[k]);
                sum(g, &[viscous, coulomb, f.entries[3 * k + 2]])
            })
            .collect();
        let output = Output { name: "tau".into(), rows: n, columns: 1, entries };
        Function::new("friction", g, vec![dq, sign, f], vec![output])
    }
}
