//! The reactions of the joints: the force and the moment that the antecedent exerts on each link.
//!
//! ```text
//! F_j = (f_j, n_j)     force, then moment at O_j, in frame j; N, N m
//! ```
//! The reactions follow from the recursion of the torques (`torque.rs`), gravity included. The entry along the joint axis is the
//! torque of the joint minus IA ddq (IA: rotor inertia), because the inertia torque of a rotor acts at its drive and not on the
//! link. Base parameters would give wrong forces, so all standard parameters are needed. In a loop, the other joints also
//! transmit the forces of the cut joint, so robots with loops are excluded.

use expr::{Expr, Function, Output};

use crate::derivation::Derivation;
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::dynamics::torque::wrenches;

impl Derivation<'_> {
    /// Force and moment through each joint of a robot without loops, as a function: inputs `q`, `dq`, `ddq`, `x` (the standard
    /// parameters), output `f` (6 x links): force, N, then moment at O_j, N m, that the antecedent exerts on link j, in frame j.
    pub fn joint_reactions(&mut self) -> Function {
        let x = &ParameterInputs::standard(self);
        let Derivation { robot, graph: g, motion, links, .. } = self;
        let columns: Vec<Vec<Expr>> = wrenches(g, robot, links, x).into_iter().map(|(f, n)| [f, n].concat()).collect();
        let entries = (0..6).flat_map(|row| columns.iter().map(move |column| column[row])).collect();
        let output = Output { name: "f".into(), rows: 6, columns: columns.len(), entries };
        let inputs = [motion.inputs(), vec![x.input()]].concat();
        Function::new("joint_reactions", g, inputs, vec![output])
    }
}
