//! The regressor D of the standard parameters: tau = D(q, dq, ddq) X.
//!
//! The force f and the moment n at the origin O_j that move link j are linear in the mass M, the first moment MS and the
//! inertia matrix J of the link:
//!
//! ```text
//! f = M a + U MS,   n = J dw + w x (J w) + MS x a
//! ```
//! a: acceleration of O_j minus gravity; w, dw: angular velocity and acceleration; U = [dw]x + [w]x^2. Row k, column c of link j
//! is z_jk . n_c + d_jk . f_c: the power of the wrench (f_c, n_c) per unit of parameter c along the twist (z_jk, d_jk) of
//! coordinate k. The twists are transformed outward with the frames ([`crate::kinematics::links`]); no wrench is transformed
//! inward. The column of a rotor inertia is (d q_j / d q_k) ddq_j.

use expr::{Expr, Function, Graph, Output};
use robot::{Inertial, StandardParameter};

use crate::derivation::Derivation;
use crate::dynamics::entry_forms::{WrenchColumn, fewest};
use crate::kinematics::angular_motion::AngularMotion;
use crate::kinematics::implicit::reduced;
use crate::kinematics::links::LinkMotion;
use crate::kinematics::vector::{NULL, Vector, cross, dot};

impl Derivation<'_> {
    /// The regressor D of the p standard parameters, tau = D X, as a function: inputs `q`, `dq`, `ddq` (n each), output
    /// `y` (n x p, columns as [`robot::StandardParameter::all`]).
    pub fn regressor(&mut self) -> Function {
        let entries = entries(self);
        let rows = self.robot.n_coordinates();
        let columns = entries.len().checked_div(rows).unwrap_or(0);
        let output = Output { name: "y".into(), rows, columns, entries };
        Function::new("regressor", &self.graph, self.motion.inputs(), vec![output])
    }

    /// The power of the joints per unit of each standard parameter, dq^T D, as a function. This power is the time derivative of
    /// the energy per unit of each parameter [Gautier 1997]. Inputs `q`, `dq`, `ddq`, output `power` (1 x p), W.
    pub(crate) fn power_regressor(&mut self) -> Function {
        let entries = entries(self);
        let Derivation { robot, graph: g, motion, .. } = self;
        let columns = entries.len().checked_div(robot.n_coordinates()).unwrap_or(0);
        let mut power = vec![Expr::ZERO; columns];
        for (row, &rate) in entries.chunks(columns.max(1)).zip(&motion.dq) {
            for (sum, &entry) in power.iter_mut().zip(row) {
                let term = g.mul(rate, entry);
                *sum = g.add(*sum, term);
            }
        }
        let output = Output { name: "power".into(), rows: 1, columns, entries: power };
        Function::new("power_regressor", g, motion.inputs(), vec![output])
    }
}

fn entries(derivation: &mut Derivation) -> Vec<Expr> {
    let links = std::mem::take(&mut derivation.links);
    let entries = entries_of(derivation, &links);
    derivation.links = links;
    entries
}

/// The entries of the regressor D of the standard parameters for given link motions, row by row.
pub(crate) fn entries_of(derivation: &mut Derivation, links: &[LinkMotion]) -> Vec<Expr> {
    let Derivation { robot, graph: g, implicit, .. } = derivation;
    let parameters = StandardParameter::all(robot);
    let n = robot.n_variables();
    let mut entries = vec![Expr::ZERO; n * parameters.len()];
    // The forms of the entries ([`crate::dynamics::entry_forms`]) are chosen first for MX and MY. Then they are chosen for MZ and
    // M, which are not base parameters of most robots without loops.
    let (mut moments, mut masses) = (Vec::new(), Vec::new());
    for (place, parameter) in parameters.iter().enumerate() {
        let j = &links[parameter.link.0];
        if parameter.inertial == Inertial::Ia {
            for &(k, coefficient) in &robot.link(parameter.link).joint.variable.terms {
                let coefficient = g.constant(coefficient);
                entries[k.0 * parameters.len() + place] = g.mul(coefficient, j.joint_acceleration);
            }
            continue;
        }
        let Wrench { f, n } = unit_wrench(g, j, parameter.inertial);
        match parameter.inertial {
            Inertial::Mx | Inertial::My => moments.push(WrenchColumn { place, link: parameter.link, f, n }),
            Inertial::Mz | Inertial::M => masses.push(WrenchColumn { place, link: parameter.link, f, n }),
            _ => {
                for (k, twist) in j.jacobian.iter().enumerate() {
                    entries[k * parameters.len() + place] = twist.map_or(Expr::ZERO, |twist| dot(g, twist.z, n));
                }
            }
        }
    }
    for columns in [moments, masses] {
        for (row, column, entry) in fewest(g, links, &columns, &entries) {
            entries[row * parameters.len() + column] = entry;
        }
    }
    match implicit {
        None => entries,
        Some(implicit) => {
            let rows: Vec<Vec<Expr>> = entries.chunks(parameters.len().max(1)).map(<[Expr]>::to_vec).collect();
            reduced(g, &implicit.G, &rows).concat()
        }
    }
}

/// Force f and moment n at O_j on link j, per unit of one inertial parameter.
struct Wrench {
    f: Vector,
    n: Vector,
}

fn unit_wrench(g: &mut Graph, j: &LinkMotion, parameter: Inertial) -> Wrench {
    let AngularMotion { dw: [dwx, dwy, dwz], ww, U, differences } = j.angular_motion;
    let column = |c: usize| [U[0][c], U[1][c], U[2][c]];
    let axis = |c: usize| std::array::from_fn(|i| if i == c { Expr::ONE } else { Expr::ZERO });
    let n = match parameter {
        Inertial::Xx => [dwx, ww[0][2], -ww[0][1]],
        Inertial::Xy => [-U[2][0], U[2][1], differences[2]],
        Inertial::Xz => [U[1][0], differences[1], -U[1][2]],
        Inertial::Yy => [-ww[1][2], dwy, ww[0][1]],
        Inertial::Yz => [differences[0], -U[0][1], U[0][2]],
        Inertial::Zz => [ww[1][2], -ww[0][2], dwz],
        Inertial::Mx => cross(g, axis(0), j.a),
        Inertial::My => cross(g, axis(1), j.a),
        Inertial::Mz => cross(g, axis(2), j.a),
        Inertial::M | Inertial::Ia => NULL,
    };
    let f = match parameter {
        Inertial::Mx => column(0),
        Inertial::My => column(1),
        Inertial::Mz => column(2),
        Inertial::M => j.a,
        _ => NULL,
    };
    Wrench { f, n }
}
