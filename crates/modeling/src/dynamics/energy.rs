//! Kinetic and potential energy of the robot, which are linear in the standard parameters.
//!
//! ```text
//! K_j = 1/2 w . J w + v . (w x MS) + 1/2 M v . v + 1/2 IA dq_j^2
//! U_j = -g . (M p_0j + R_0j MS)
//! ```
//! M, MS, J, IA: mass, first moment, inertia matrix and rotor inertia of link j; v: velocity of the link's origin O_j, w:
//! angular velocity of the link, both in frame j; R_0j, p_0j: pose of link j in the base frame; g: gravity. A mass at the
//! origin of the base has U = 0.

use expr::{Expr, Function, Graph, Output};
use robot::{Inertial, StandardParameter};

use crate::base::base_parameters::BaseParameters;
use crate::derivation::Derivation;
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::kinematics::links::{LinkMotion, MotionInput, joint_variable};
use crate::kinematics::vector::{NULL, Vector, add, cross, dot, sum};

impl Derivation<'_> {
    /// Energies per unit of each of the p standard parameters as a function: inputs `q`, `dq`, outputs `kinetic` and
    /// `potential` (1 x p), J per unit of the parameter.
    pub fn energy(&mut self) -> Function {
        let [kinetic, potential] = energy_entries(self);
        let Derivation { graph: g, motion, .. } = self;
        let row =
            |name: &str, entries: Vec<Expr>| Output { name: name.into(), rows: 1, columns: entries.len(), entries };
        let outputs = vec![row("kinetic", kinetic), row("potential", potential)];
        let inputs = [motion.configuration(), vec![motion.input(MotionInput::Dq)]].concat();
        Function::new("energy", g, inputs, outputs)
    }

    /// Kinetic and potential energy as a function: inputs `q`, `dq`, `x` (X_base), output `e` (2), J. The potential energy is
    /// determined up to a constant.
    pub fn energies(&mut self, base: &BaseParameters) -> Function {
        let x = &ParameterInputs::base(self, base);
        let per_unit = energy_entries(self);
        let parameters = StandardParameter::all(self.robot);
        let Derivation { graph: g, motion, .. } = self;
        let entries = per_unit.map(|column| {
            let terms: Vec<Expr> =
                column.into_iter().zip(&parameters).map(|(e, p)| g.mul(e, x.get(p.link, p.inertial))).collect();
            sum(g, &terms)
        });
        let output = Output { name: "e".into(), rows: 2, columns: 1, entries: entries.to_vec() };
        let inputs = [motion.configuration(), vec![motion.input(MotionInput::Dq), x.input()]].concat();
        Function::new("energies", g, inputs, vec![output])
    }
}

/// Kinetic and potential energy per unit of each standard parameter, as [kinetic, potential], as expressions.
fn energy_entries(derivation: &mut Derivation) -> [Vec<Expr>; 2] {
    let parameters = StandardParameter::all(derivation.robot);
    let weights = weights(derivation);
    let Derivation { robot, graph: g, motion, links, .. } = derivation;
    let (mut kinetic, mut potential) = (Vec::new(), Vec::new());
    for p in &parameters {
        let link = &links[p.link.0];
        // Kinetic energy of a rotor: 1/2 IA dq_j^2, with dq_j the rate of the joint's own variable.
        kinetic.push(match p.inertial {
            Inertial::Ia => {
                let rate = joint_variable(g, robot.link(p.link), &motion.dq);
                half_square(g, rate)
            }
            body => kinetic_column(g, link, &motion.dq, body),
        });
        // Potential energy per unit of MS_j and M_j: -g in the axes of the link, and -g . p_0j.
        let (weight, height) = weights[p.link.0];
        potential.push(match p.inertial {
            Inertial::Mx => weight[0],
            Inertial::My => weight[1],
            Inertial::Mz => weight[2],
            Inertial::M => height,
            _ => Expr::ZERO,
        });
    }
    [kinetic, potential]
}

fn kinetic_column(g: &mut Graph, link: &LinkMotion, dq: &[Expr], parameter: Inertial) -> Expr {
    let [x, y, z] = link.w;
    let velocity = |g: &mut Graph| {
        let mut v = NULL;
        for (twist, &rate) in link.jacobian.iter().zip(dq) {
            if let Some(twist) = twist {
                let part = twist.d.map(|d| g.mul(d, rate));
                v = add(g, v, part);
            }
        }
        v
    };
    match parameter {
        Inertial::Xx => half_square(g, x),
        Inertial::Yy => half_square(g, y),
        Inertial::Zz => half_square(g, z),
        Inertial::Xy => g.mul(x, y),
        Inertial::Xz => g.mul(x, z),
        Inertial::Yz => g.mul(y, z),
        // Kinetic energy per unit of a first moment along the axis e: v . (w x e) = e . (v x w). v: velocity of the link's
        // origin, w: angular velocity of the link.
        Inertial::Mx | Inertial::My | Inertial::Mz => {
            let v = velocity(g);
            cross(g, v, link.w)[parameter as usize - Inertial::Mx as usize]
        }
        Inertial::M => {
            let v = velocity(g);
            let squares = v.map(|x| half_square(g, x));
            sum(g, &squares)
        }
        Inertial::Ia => Expr::ZERO,
    }
}

fn half_square(g: &mut Graph, x: Expr) -> Expr {
    let half = g.constant(0.5);
    let square = g.mul(x, x);
    g.mul(half, square)
}

/// For each link j: -g in the axes of link j, m/s^2, and -g . p_0j, m^2/s^2. g: gravity; p_0j: position of the origin O_j in the
/// base frame.
fn weights(derivation: &mut Derivation) -> Vec<(Vector, Expr)> {
    let Derivation { robot, graph: g, constants, links, .. } = derivation;
    let base = constants.weight(g);
    let mut weights: Vec<(Vector, Expr)> = Vec::new();
    for j in robot.link_ids() {
        let (weight, height) = robot.link(j).antecedent.map_or((base, Expr::ZERO), |i| weights[i.0]);
        let placement = &links[j.0].placement;
        let rise = dot(g, weight, placement.p);
        weights.push((placement.to_link(g, weight), g.add(height, rise)));
    }
    weights
}
