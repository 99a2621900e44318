//! The part of the rate of the generalised momentum that does not depend on torques, b = C^T dq - g, together with the
//! momentum. An observer of external torques integrates b and the torques, and needs no acceleration [De Luca, Albu-Schaeffer,
//! Haddadin, Hirzinger 2006]:
//!
//! ```text
//! dp/dt = tau + b,   b = C^T dq - g = dL/dq        L = K - U, the Lagrangian
//! ```
//! p = A dq: generalised momentum; A: inertia matrix; C: Christoffel's Coriolis matrix; g: gravity torques; K, U: kinetic and
//! potential energy. For a tree of links, dK/dq_j needs the momentum h and the angular momentum L_j of link j with all links
//! that it carries. If q_j changes, the velocities of these bodies change by the motion of the antecedent, seen along the joint
//! axis z:
//!
//! ```text
//! dK/dq_j = L_j . (w x z) + h . (v x z)     revolute;     dK/dq_j = h . (w x z)     prismatic
//! ```
//! w, v: angular velocity of link j and velocity of O_j, in frame j. If loops are solved numerically, b is the rate of p at ddq = 0
//! minus the torques at ddq = 0.
//!
//! For a load on a link, p and b are linear in the ten parameters of the load. The two regressors are derived in the second way
//! (rate of p minus torques) for all robots.

use expr::{Expr, Function, Output};
use robot::{Inertial, JointKind, StandardParameter, transform_inertial};

use crate::base::base_parameters::BaseParameters;
use crate::derivation::Derivation;
use crate::dynamics::link_frame::LinkFrame;
use crate::dynamics::momenta::velocities;
use crate::dynamics::momentum::{momentum_entries, unit_momentum};
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::dynamics::{regressor, torque};
use crate::kinematics::implicit::reduced;
use crate::kinematics::links::{LinkMotion, MotionInput, add_to_coordinates, link_motions};
use crate::kinematics::vector::{Vector, dot, plus_dot};

/// Number of inertial parameters of a rigid body: XX XY XZ YY YZ ZZ MX MY MZ M.
const TEN: usize = 10;

impl Derivation<'_> {
    /// The generalised momentum p = A dq and b = C^T dq - g, as a function: inputs `q`, `dq`, `x` (X_base), outputs `p` (n), kg
    /// m^2/s (kg m/s), and `b` (n), N m (N). Without contact dp/dt = tau + b.
    pub fn momentum_and_rate(&mut self, base: &BaseParameters) -> Function {
        let x = &ParameterInputs::base(self, base);
        let (p, momenta) = momentum_entries(self, x);
        let b = match self.implicit {
            None => {
                let weights = self.gravity_entries(x);
                let of_kinetic = kinetic_slopes(self, &momenta);
                of_kinetic.into_iter().zip(weights).map(|(k, w)| self.graph.sub(k, w)).collect()
            }
            Some(_) => {
                let coasting = self.coasting_links();
                let bias = torque::entries(self, &coasting, x);
                self.rate_less(&p, bias)
            }
        };
        let inputs = [self.motion.configuration(), vec![self.motion.input(MotionInput::Dq), x.input()]].concat();
        let output =
            |name: &str, entries: Vec<Expr>| Output { name: name.into(), rows: entries.len(), columns: 1, entries };
        Function::new("momentum_and_rate", &self.graph, inputs, vec![output("p", p), output("b", b)])
    }

    /// The momentum p and b = C^T dq - g per unit of the ten parameters XX XY XZ YY YZ ZZ MX MY MZ M of a load fixed to
    /// `frame`, about the origin of the frame and in the axes of the frame, as a function: inputs `q`, `dq`, outputs `p` and
    /// `b` (n x 10).
    pub fn load_momentum(&mut self, frame: impl Into<LinkFrame>) -> Function {
        let frame = &frame.into();
        let p = load_momenta(self, frame);
        let coasting = self.coasting_links();
        let (n, all) = (self.robot.n_coordinates(), StandardParameter::all(self.robot));
        let place = |inertial| all.iter().position(|s| s.link == frame.link && s.inertial == inertial);
        let columns = ten().map(|inertial| place(inertial).expect("every link has ten inertial parameters"));
        let torques = regressor::entries_of(self, &coasting);
        let bias = (0..n).flat_map(|k| columns.map(|c| torques[k * all.len() + c])).collect();
        let b = self.rate_less(&p, bias);
        let [p, b] = [p, b].map(|entries| in_frame(self, frame, &entries));
        let output = |name: &str, entries| Output { name: name.into(), rows: n, columns: TEN, entries };
        let inputs = [self.motion.configuration(), vec![self.motion.input(MotionInput::Dq)]].concat();
        Function::new(&frame.function("load_momentum"), &self.graph, inputs, vec![output("p", p), output("b", b)])
    }

    /// The rate of `momenta` at ddq = 0, minus `torques`, which are the torques at ddq = 0.
    fn rate_less(&mut self, momenta: &[Expr], torques: Vec<Expr>) -> Vec<Expr> {
        let seeds: Vec<(Expr, Expr)> = self.motion.q.iter().copied().zip(self.motion.dq.iter().copied()).collect();
        let rates = self.graph.derivatives(momenta, &seeds);
        rates.into_iter().zip(torques).map(|(rate, torque)| self.graph.sub(rate, torque)).collect()
    }

    /// The gravity torques, one expression per coordinate.
    fn gravity_entries(&mut self, x: &ParameterInputs) -> Vec<Expr> {
        let mut at_rest = self.motion.clone();
        at_rest.dq.fill(Expr::ZERO);
        at_rest.ddq.fill(Expr::ZERO);
        let links = link_motions(&mut self.graph, self.robot, &mut self.constants, &at_rest);
        torque::entries(self, &links, x)
    }
}

/// dK/dq of a tree of links, one expression per coordinate. `momenta`: momentum and angular momentum of each link with all links
/// that it carries.
fn kinetic_slopes(derivation: &mut Derivation, momenta: &[[Vector; 2]]) -> Vec<Expr> {
    let Derivation { robot, graph: g, motion, links, .. } = derivation;
    let w: Vec<Vector> = links.iter().map(|link| link.w).collect();
    let v = velocities(g, robot, links, &w, &motion.dq);
    let mut slopes = vec![Expr::ZERO; robot.n_variables()];
    for j in robot.link_ids() {
        let (link, [h, L], w, v) = (robot.link(j), momenta[j.0], w[j.0], v[j.0]);
        // a . (b x z) = a_x b_y - a_y b_x
        let mut along = |a: Vector, b: Vector| {
            let (plus, minus) = (g.mul(a[0], b[1]), g.mul(a[1], b[0]));
            g.sub(plus, minus)
        };
        let slope = match link.joint.kind {
            JointKind::Fixed => continue,
            JointKind::Prismatic => along(h, w),
            JointKind::Revolute => {
                let (turned, moved) = (along(L, w), along(h, v));
                g.add(turned, moved)
            }
        };
        add_to_coordinates(g, link, slope, &mut slopes);
    }
    slopes
}

/// The ten inertial parameters of a body, in the order of a load.
fn ten() -> [Inertial; TEN] {
    use Inertial::*;
    [Xx, Xy, Xz, Yy, Yz, Zz, Mx, My, Mz, M]
}

/// The momentum per unit of the ten parameters of the link of `frame`, in the link's frame (n x 10).
fn load_momenta(derivation: &mut Derivation, frame: &LinkFrame) -> Vec<Expr> {
    let Derivation { robot, graph: g, motion, links, implicit, .. } = derivation;
    let w: Vec<Vector> = links.iter().map(|link| link.w).collect();
    let v = velocities(g, robot, links, &w, &motion.dq)[frame.link.0];
    let at: &LinkMotion = &links[frame.link.0];
    let mut rows = vec![vec![Expr::ZERO; TEN]; robot.n_variables()];
    for (c, inertial) in ten().into_iter().enumerate() {
        let [h, L] = unit_momentum(g, at.w, v, inertial);
        for (row, twist) in rows.iter_mut().zip(&at.jacobian) {
            if let Some(twist) = twist {
                let angular = dot(g, twist.z, L);
                row[c] = plus_dot(g, angular, twist.d, h);
            }
        }
    }
    match implicit {
        None => rows.concat(),
        Some(implicit) => reduced(g, &implicit.G, &rows).concat(),
    }
}

/// Changes the columns (n x 10) from parameters in the link's frame to parameters in `frame`: x_link = T x_frame, so the columns
/// are multiplied by T.
fn in_frame(derivation: &mut Derivation, frame: &LinkFrame, entries: &[Expr]) -> Vec<Expr> {
    let g = &mut derivation.graph;
    let columns: [[f64; TEN]; TEN] =
        std::array::from_fn(|c| transform_inertial(&std::array::from_fn(|k| f64::from(u8::from(k == c))), &frame.pose));
    let mut turned = Vec::with_capacity(entries.len());
    for row in entries.chunks_exact(TEN) {
        for column in &columns {
            let mut sum = Expr::ZERO;
            for (&entry, &factor) in row.iter().zip(column).filter(|(_, factor)| **factor != 0.0) {
                let factor = g.constant(factor);
                let term = g.mul(factor, entry);
                sum = g.add(sum, term);
            }
            turned.push(sum);
        }
    }
    turned
}
