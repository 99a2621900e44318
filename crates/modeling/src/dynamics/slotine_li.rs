//! The regressor Y of adaptive control: A(q) ddq_r + C(q, dq) dq_r + g(q) = Y(q, dq, dq_r, ddq_r) X [Slotine, Li 1987], with
//! Christoffel's Coriolis matrix C. A: inertia matrix; g: gravity torques; dq_r, ddq_r: reference velocities and accelerations;
//! X: parameters.
//!
//! Y is the regressor of the torques in which every product of two rates is replaced by a symmetric product of dq and dq_r
//! ([`crate::kinematics::polar`]). If loops are solved numerically, half of the derivative of D(q, dq, 0) along dq_r is used
//! instead; D: regressor of the torques.

use expr::{Expr, Function, Input, Output, SymbolKind};

use crate::base::base_parameters::BaseParameters;
use crate::derivation::Derivation;
use crate::dynamics::regressor::entries_of;
use crate::kinematics::links::{JointVariables, MotionInput, link_motions};
use crate::kinematics::names::coordinate_labels;
use crate::kinematics::polar::polarised;

impl Derivation<'_> {
    /// The torque A ddq_r + C dq_r + g per unit of each of the p base parameters, as a function: inputs `q`, `dq`, `dq_r`,
    /// `ddq_r`, output `y` (n x p).
    pub fn slotine_li_regressor(&mut self, base: &BaseParameters) -> Function {
        let n = self.robot.n_coordinates();
        let labels = coordinate_labels(self.robot);
        let g = &mut self.graph;
        let mut symbols = |letters: &str| -> Vec<Expr> {
            labels.iter().map(|label| g.symbol(&format!("{letters}{label}"), SymbolKind::Input)).collect()
        };
        let (dq_r, ddq_r) = (symbols("dqr"), symbols("ddqr"));
        let half = g.constant(0.5);
        let halves: Vec<Expr> = dq_r.iter().map(|&rate| g.mul(half, rate)).collect();
        let entries = if self.implicit.is_some() {
            by_differentiation(self, &halves, &ddq_r)
        } else {
            let Derivation { robot, graph: g, constants, motion, links, .. } = self;
            let reference = JointVariables { dq: halves, ddq: ddq_r.clone(), ..motion.clone() };
            let polar = polarised(g, robot, constants, links, &reference, motion);
            entries_of(self, &polar)
        };
        let p = entries.len().checked_div(n).unwrap_or(0);
        let kept = (0..n).flat_map(|r| base.base.iter().map(move |b| r * p + b.column));
        let output =
            Output { name: "y".into(), rows: n, columns: base.len(), entries: kept.map(|k| entries[k]).collect() };
        let motion = &self.motion;
        let mut inputs = motion.configuration();
        let input = |name: &str, entries: Vec<Expr>| Input { name: name.into(), entries };
        inputs.extend([motion.input(MotionInput::Dq), input("dq_r", dq_r), input("ddq_r", ddq_r)]);
        Function::new("slotine_li_regressor", &self.graph, inputs, vec![output])
    }
}

/// The regressor of adaptive control from the torque regressor D: D(q, 0, ddq_r) plus the directional derivative of D(q, dq, 0)
/// with respect to dq along dq_r / 2 (`halves`).
fn by_differentiation(derivation: &mut Derivation, halves: &[Expr], ddq_r: &[Expr]) -> Vec<Expr> {
    let n = derivation.robot.n_coordinates();
    let coasting = derivation.coasting_links();
    let of_rates = entries_of(derivation, &coasting);
    let Derivation { robot, graph: g, constants, motion, implicit, .. } = derivation;
    let seeds: Vec<(Expr, Expr)> = motion.dq[..n].iter().copied().zip(halves.iter().copied()).collect();
    let of_rates = g.derivatives(&of_rates, &seeds);
    let mut ddq = ddq_r.to_vec();
    for row in implicit.iter().flat_map(|i| &i.G) {
        let driven = row.iter().zip(ddq_r).fold(Expr::ZERO, |sum, (&a, &b)| {
            let term = g.mul(a, b);
            g.add(sum, term)
        });
        ddq.push(driven);
    }
    let starting = JointVariables { dq: vec![Expr::ZERO; motion.dq.len()], ddq, ..motion.clone() };
    let links = link_motions(g, robot, constants, &starting);
    let at_rest = entries_of(derivation, &links);
    at_rest.into_iter().zip(of_rates).map(|(a, b)| derivation.graph.add(a, b)).collect()
}
