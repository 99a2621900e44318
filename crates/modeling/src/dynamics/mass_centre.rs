//! Derives the centre of mass of the moving links, the Jacobian of the centre of mass, and the momentum about it.
//!
//! ```text
//! c = MS_0 / M_0,   dc/dq_k = f_k / M_0,   h = sum_k (f_k, n_k - c x f_k) dq_k
//! ```
//! MS_0 and M_0 are the first moment and the mass of all links together, about the base origin. (f_k, n_k) is the momentum of
//! the bodies that coordinate k moves, per unit of dq_k and about the base origin. This momentum is computed as the unit wrench
//! of [`crate::dynamics::inertia_matrix`]. All vectors are in the axes of the base. The masses of all links are needed; they
//! are not identifiable from torques. The base itself and rotors are not counted.

use expr::{Expr, Function, Graph, Output};

use crate::derivation::Derivation;
use crate::dynamics::composite::{RigidBody, composites};
use crate::dynamics::inertia_matrix::unit_wrench;
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::kinematics::implicit::reduced;
use crate::kinematics::links::MotionInput;
use crate::kinematics::vector::{NULL, Vector, add, cross};

impl Derivation<'_> {
    /// The centre of mass of the moving links, as a function: inputs `q`, `x` (the standard parameters), outputs `p` (3), m, in
    /// the base frame, and `j`, the Jacobian of the centre of mass (3 x n), m per rad (m).
    pub fn centre_of_mass(&mut self) -> Function {
        let x = &ParameterInputs::standard(self);
        let AllLinks { mass, centre, momenta } = whole(self, x);
        let g = &mut self.graph;
        let rows: Vec<Vec<Expr>> = (0..3).map(|r| momenta.iter().map(|k| g.div(k[r], mass)).collect()).collect();
        let inputs = [self.motion.configuration(), vec![x.input()]].concat();
        let output = |name: &str, columns, entries| Output { name: name.into(), rows: 3, columns, entries };
        let outputs = vec![output("p", 1, centre.to_vec()), output("j", momenta.len(), rows.concat())];
        Function::new("centre_of_mass", &self.graph, inputs, outputs)
    }

    /// Momentum, and angular momentum about the centre of mass, as a function: inputs `q`, `dq`, `x` (the standard parameters),
    /// outputs `h` (6), in the axes of the base, and `map` (6 x n) with h = map dq.
    pub fn centroidal_momentum(&mut self) -> Function {
        let x = &ParameterInputs::standard(self);
        let AllLinks { centre, momenta, .. } = whole(self, x);
        let Derivation { graph: g, motion, .. } = self;
        let mut about_centre = |k: &Vec<Expr>| {
            let (f, n) = ([k[0], k[1], k[2]], [k[3], k[4], k[5]]);
            let lever = cross(g, centre, f);
            let n: Vector = std::array::from_fn(|i| g.sub(n[i], lever[i]));
            [f, n].concat()
        };
        let columns: Vec<Vec<Expr>> = momenta.iter().map(&mut about_centre).collect();
        let rows: Vec<Vec<Expr>> = (0..6).map(|r| columns.iter().map(|k| k[r]).collect()).collect();
        let sum = |row: &Vec<Expr>| {
            row.iter().zip(&motion.dq).fold(Expr::ZERO, |sum, (&a, &b)| {
                let term = g.mul(a, b);
                g.add(sum, term)
            })
        };
        let h: Vec<Expr> = rows.iter().map(sum).collect();
        let inputs = [motion.configuration(), vec![motion.input(MotionInput::Dq), x.input()]].concat();
        let output = |name: &str, columns, entries| Output { name: name.into(), rows: 6, columns, entries };
        let outputs = vec![output("h", 1, h), output("map", columns.len(), rows.concat())];
        Function::new("centroidal_momentum", g, inputs, outputs)
    }
}

/// Mass, centre of mass and momenta of all moving links together.
struct AllLinks {
    mass: Expr,
    /// Centre of mass in the base frame, m.
    centre: Vector,
    /// For each coordinate, the momentum per unit of the rate of this coordinate: momentum, then angular momentum about the
    /// base's origin (6 entries).
    momenta: Vec<Vec<Expr>>,
}

fn whole(derivation: &mut Derivation, x: &ParameterInputs) -> AllLinks {
    let Derivation { robot, graph: g, links, implicit, .. } = derivation;
    let bodies = composites(g, robot, links, x);
    let (mut mass, mut moment) = (Expr::ZERO, NULL);
    let mut momenta = vec![vec![Expr::ZERO; 6]; robot.n_variables()];
    for j in robot.link_ids() {
        let link = robot.link(j);
        // First moment MS_0 and mass M_0: sums over the composite bodies of the links that are attached to the base.
        if link.antecedent.is_none() {
            let carried = carried_first_moment(g, bodies[j.0], &links[j.0].placement);
            moment = add(g, moment, carried);
            mass = g.add(mass, bodies[j.0].mass);
        }
        // Momentum (f_k, n_k) of the bodies that joint j moves, per unit of the rate of joint j, transformed inward to the
        // base's origin.
        let (mut f, mut n) = unit_wrench(g, bodies[j.0], link.joint.kind);
        let mut at = Some(j);
        while let Some(k) = at {
            [f, n] = links[k.0].placement.wrench_to_antecedent(g, [f, n]);
            at = robot.link(k).antecedent;
        }
        for &(k, c) in &link.joint.variable.terms {
            let c = g.constant(c);
            for (sum, e) in momenta[k.0].iter_mut().zip([f, n].concat()) {
                let term = g.mul(c, e);
                *sum = g.add(*sum, term);
            }
        }
    }
    // Passive coordinates follow from the coordinates (dq_p = G dq). So the momenta of the passive coordinates, times G^T, are
    // added to the momenta of the coordinates.
    if let Some(implicit) = implicit {
        momenta = reduced(g, &implicit.G, &momenta);
    }
    let centre = moment.map(|s| if mass.is_zero() { s } else { g.div(s, mass) });
    AllLinks { mass, centre, momenta }
}

fn carried_first_moment(g: &mut Graph, body: RigidBody, placement: &crate::kinematics::links::Placement) -> Vector {
    let turned = placement.to_antecedent(g, body.first_moment);
    let moved = placement.p.map(|p| g.mul(body.mass, p));
    add(g, turned, moved)
}
