//! Computes the derivatives of the torques by q and dq, and Christoffel's Coriolis matrix C, by one recursion.
//!
//! Symbols of a link, in its axes at O: w and dw, angular velocity and acceleration; v, velocity; a, classical acceleration
//! minus gravity; U = [dw]x + [w]x [w]x; z, joint axis. If joint i turns by dq_i, its antecedent turns back as seen from the
//! bodies that joint i carries. So w, dw and a of the antecedent change by -z x w, -z x dw and -z x a. The acceleration field
//! of these bodies changes by a_0 + A x r + 2 W x v(r) at the point r, with
//!
//! ```text
//! by q_i    W = w x z   A = U z   a_0 = a x z + 2 v x (w x z)      revolute; prismatic W = A = 0, a_0 = U z
//! by dq_i   W = z       A = 2 w x z   a_0 = 2 v x z                revolute; prismatic W = A = 0, a_0 = 2 w x z
//! ```
//! at O_i in the axes of the run of i (run: consecutive links on parallel joint axes, [`crate::dynamics::run_axes`]). I_j:
//! inertia of the composite body of link j (the link with all links that it carries); B_j: its momentum matrix
//! ([`crate::dynamics::momenta`]). The force and moment (wrench) on this body change by I_j (A, a_0) + 2 B_j(W). For j = i this
//! wrench is transformed inward to every k before i. In the derivative by q_i, the present force and moment of link i also turn
//! with joint i. For j after i only the component of the wrench along z_j is needed: the rows of I_j and B_j along z_j are
//! transformed inward to i. This row of I_j is the unit wrench of the inertia matrix. These derivatives equal the derivatives
//! of [Singh, Russell, Wensing 2022], but are written with classical accelerations.
//!
//! C(q, dq) is half of the derivative by dq: the torques are quadratic in dq, and C is their symmetric bilinear form, so
//! that dA/dt - 2 C is skew-symmetric.
//!
//! If loops are solved numerically, the graph of the torques is differentiated instead.

use expr::{Expr, Function, Graph, Input, Output, SymbolKind};
use robot::{JointKind, LinkId};

use crate::base::base_parameters::BaseParameters;
use crate::derivation::Derivation;
use crate::dynamics::composite::RigidBody;
use crate::dynamics::factor::Factor;
use crate::dynamics::inertia_matrix::{self, unit_wrench};
use crate::dynamics::momenta::Momenta;
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::dynamics::run_axes::{CompositeBody, InRun, in_runs, wholes};
use crate::dynamics::torque;
use crate::kinematics::links::{JointVariables, LinkMotion, MotionInput, along_axis, link_motions};
use crate::kinematics::names::coordinate_labels;
use crate::kinematics::vector::{NULL, Vector, add, cross, dot, plus_dot};

/// The derivatives of the torques by q and by dq: each n x n, row by row. Row: torque; column: coordinate.
struct Derivatives {
    by_q: Vec<Expr>,
    by_dq: Vec<Expr>,
}

impl Derivation<'_> {
    /// The derivatives of the torques as a function: inputs `q`, `dq`, `ddq`, `x` (X_base), outputs `dtau_by_q`, `dtau_by_dq` (n
    /// x n). The derivative by ddq is the inertia matrix.
    pub fn inverse_dynamics_derivatives(&mut self, base: &BaseParameters) -> Function {
        let x = &ParameterInputs::base(self, base);
        let links = self.links.clone();
        let Derivatives { by_q, by_dq } = derivatives(self, &links, x, 2.0);
        let inputs = [self.motion.inputs(), vec![x.input()]].concat();
        let outputs = vec![square("dtau_by_q", by_q), square("dtau_by_dq", by_dq)];
        Function::new("inverse_dynamics_derivatives", &self.graph, inputs, outputs)
    }

    /// Christoffel's Coriolis matrix C as a function: inputs `q`, `dq`, `x` (X_base), output `c` (n x n). C dq is the bias torque
    /// without gravity, and dA/dt - 2 C is skew-symmetric; A: inertia matrix.
    pub fn coriolis_matrix(&mut self, base: &BaseParameters) -> Function {
        let x = &ParameterInputs::base(self, base);
        let links = self.coasting_links();
        let c = derivatives(self, &links, x, 1.0).by_dq;
        let motion = &self.motion;
        let inputs = [motion.configuration(), vec![motion.input(MotionInput::Dq), x.input()]].concat();
        Function::new("coriolis_matrix", &self.graph, inputs, vec![square("c", c)])
    }

    /// The derivatives of the accelerations ddq = A^-1 (tau - h) as a function: inputs `q`, `dq`, `tau`, `x` (X_base), outputs
    /// `ddq_by_q`, `ddq_by_dq`, `ddq_by_tau` (n x n). They are -A^-1 dtau_by_q, -A^-1 dtau_by_dq and A^-1; A: inertia matrix, h:
    /// bias torque.
    pub fn forward_dynamics_derivatives(&mut self, base: &BaseParameters) -> Function {
        let x = &ParameterInputs::base(self, base);
        let n = self.robot.n_coordinates();
        // The accelerations at the given torques: ddq = A^-1 (tau - h).
        let a = inertia_matrix::entries(self, x);
        let coasting = self.coasting_links();
        let bias = torque::entries(self, &coasting, x);
        let labels = coordinate_labels(self.robot);
        let Derivation { robot, graph: g, constants, motion, implicit, .. } = self;
        let tau: Vec<Expr> = labels.iter().map(|k| g.symbol(&format!("tau{k}"), SymbolKind::Input)).collect();
        let factor = Factor::new(g, a, n);
        let right = (0..n).map(|k| g.sub(tau[k], bias[k])).collect();
        let ddq = factor.solve(g, right);
        // -A^-1 times the derivatives of the torques at this ddq. With loops solved numerically, the graph of ddq is
        // differentiated.
        let (by_q, by_dq) = if implicit.is_some() {
            (by_each(self, &ddq, MotionInput::Q), by_each(self, &ddq, MotionInput::Dq))
        } else {
            let links = link_motions(g, robot, constants, &JointVariables { ddq: ddq.clone(), ..motion.clone() });
            let found = derivatives(self, &links, x, 2.0);
            let g = &mut self.graph;
            let [by_q, by_dq] = [found.by_q, found.by_dq].map(|rows| factor.solve_columns(g, &rows));
            (by_q.into_iter().map(|x| -x).collect(), by_dq.into_iter().map(|x| -x).collect())
        };
        let by_tau = factor.inverse(&mut self.graph);
        let outputs = vec![square("ddq_by_q", by_q), square("ddq_by_dq", by_dq), square("ddq_by_tau", by_tau)];
        let motion = &self.motion;
        let inputs = [
            motion.configuration(),
            vec![motion.input(MotionInput::Dq), Input { name: "tau".into(), entries: tau }, x.input()],
        ]
        .concat();
        Function::new("forward_dynamics_derivatives", &self.graph, inputs, outputs)
    }
}

fn square(name: &str, entries: Vec<Expr>) -> Output {
    let n = entries.len().isqrt();
    Output { name: name.into(), rows: n, columns: n, entries }
}

/// The derivatives of `entries` by each coordinate (or by the rate of each coordinate), row by row. Passive coordinates change
/// by dq_p = G dq.
fn by_each(derivation: &mut Derivation, entries: &[Expr], by: MotionInput) -> Vec<Expr> {
    let Derivation { robot, graph: g, motion, implicit, .. } = derivation;
    let n = robot.n_coordinates();
    let columns: Vec<Vec<Expr>> = (0..n)
        .map(|k| {
            let mut seeds = vec![(motion.input(by).entries[k], Expr::ONE)];
            if let (MotionInput::Q, Some(implicit)) = (by, implicit.as_ref()) {
                seeds.extend(implicit.G.iter().enumerate().map(|(p, row)| (motion.q[n + p], row[k])));
            }
            g.derivatives(entries, &seeds)
        })
        .collect();
    (0..entries.len()).flat_map(|r| columns.iter().map(move |column| column[r])).collect()
}

/// The derivatives of the torques. With `scale` 2 both are complete. With `scale` 1, `by_dq` is half of the derivative, which is
/// Christoffel's C, and `by_q` is invalid.
fn derivatives(derivation: &mut Derivation, links: &[LinkMotion], x: &ParameterInputs, scale: f64) -> Derivatives {
    if derivation.implicit.is_some() {
        let tau = torque::entries(derivation, links, x);
        let [by_q, by_dq] = [MotionInput::Q, MotionInput::Dq].map(|by| by_each(derivation, &tau, by));
        let g = &mut derivation.graph;
        let share = g.constant(scale / 2.0);
        return Derivatives { by_q, by_dq: by_dq.into_iter().map(|entry| g.mul(share, entry)).collect() };
    }
    let Derivation { robot, graph: g, motion, constants, .. } = derivation;
    // Factor of all velocities in the term 2 W x v of the acceleration field: 2 for derivatives, 1 for Christoffel's C.
    let scale = g.constant(scale);
    let w: Vec<Vector> = links.iter().map(|link| link.w.map(|w| g.mul(scale, w))).collect();
    let rates: Vec<Expr> = motion.dq.iter().map(|&rate| g.mul(scale, rate)).collect();
    let weight = constants.weight(g);
    let runs = in_runs(g, robot, links, (&w, &rates), motion, scale, weight);
    let wholes = wholes(g, robot, links, (&runs, &w), x);
    let n = robot.n_coordinates();
    let mut found = Derivatives { by_q: vec![Expr::ZERO; n * n], by_dq: vec![Expr::ZERO; n * n] };
    let changes: Vec<Change> =
        robot.link_ids().map(|i| Change::new(g, robot.link(i).joint.kind, &runs[i.0], scale)).collect();
    for j in robot.link_ids() {
        let kind = robot.link(j).joint.kind;
        if robot.link(j).joint.variable.terms.is_empty() || kind == JointKind::Fixed {
            continue;
        }
        let CompositeBody { body, momenta: of_link, wrench } = &wholes[j.0];
        // The wrench on link j that a change of joint j causes. This wrench acts on joint j and on all joints before it.
        let mut by_q = changes[j.0].by_q.wrench(g, *body, of_link);
        let turned = turned_with(kind, *wrench);
        by_q = [add(g, by_q[0], turned[0]), add(g, by_q[1], turned[1])];
        let mut by_dq = changes[j.0].by_dq.wrench(g, *body, of_link);
        // The rows of I_j and B_j along z_j give the effect that a change of a joint before j has on joint j.
        let (f, moment) = unit_wrench(g, *body, kind);
        let mut row = [f, moment];
        let along = of_link.along_z(g, kind == JointKind::Prismatic);
        let mut of_momenta = along;
        let mut at = j;
        loop {
            let own = |wrench: [Vector; 2]| along_axis(robot.link(at).joint.kind, wrench);
            for (sum, entry) in [(&mut found.by_q, own(by_q)), (&mut found.by_dq, own(by_dq))] {
                accumulate(g, robot, sum, (at, j), entry);
            }
            if at != j {
                let change = &changes[at.0];
                for (sum, change) in [(&mut found.by_q, &change.by_q), (&mut found.by_dq, &change.by_dq)] {
                    let entry = change.along(g, row, of_momenta);
                    accumulate(g, robot, sum, (j, at), entry);
                }
            }
            let Some(i) = robot.link(at).antecedent else { break };
            let (run, before) = (&runs[at.0], &runs[i.0]);
            by_q = run.inward_wrench(g, before, by_q);
            by_dq = run.inward_wrench(g, before, by_dq);
            row = run.inward_wrench(g, before, row);
            of_momenta = run.inward(g, before, of_momenta);
            at = i;
        }
    }
    found
}

/// Adds `entry`, the derivative of the torque of joint `row` by joint `column`, to the derivatives of the coordinates that both
/// joints follow.
fn accumulate(g: &mut Graph, robot: &robot::Robot, sum: &mut [Expr], (row, column): (LinkId, LinkId), entry: Expr) {
    let n = robot.n_coordinates();
    for &(r, rc) in &robot.link(row).joint.variable.terms {
        for &(c, cc) in &robot.link(column).joint.variable.terms {
            let factor = g.constant(rc * cc);
            let term = g.mul(factor, entry);
            sum[r.0 * n + c.0] = g.add(sum[r.0 * n + c.0], term);
        }
    }
}

/// The change of a wrench (force f, moment n) that turns with its joint, per unit of the joint variable. Revolute joint: z x f
/// and z x n. Prismatic joint: only the moment changes, by z x f.
fn turned_with(kind: JointKind, [f, n]: [Vector; 2]) -> [Vector; 2] {
    let across = |v: Vector| [-v[1], v[0], Expr::ZERO];
    match kind {
        JointKind::Revolute => [across(f), across(n)],
        JointKind::Prismatic => [NULL, across(f)],
        JointKind::Fixed => [NULL, NULL],
    }
}

/// A change of the acceleration field of the bodies that a joint carries: a_0 + A x r + 2 W x v(r) at the point r.
struct AccelerationField {
    W: Vector,
    A: Vector,
    a_0: Vector,
}

/// The changes of the acceleration field per unit change of the joint variable, and per unit change of the rate of this
/// variable.
struct Change {
    by_q: AccelerationField,
    by_dq: AccelerationField,
}

impl Change {
    /// The changes of the field for the joint of `link`, in the axes of the link's run (consecutive links on parallel joint
    /// axes). `scale`: factor of the velocities.
    fn new(g: &mut Graph, kind: JointKind, link: &InRun, scale: Expr) -> Change {
        let ([wx, wy, _], v) = (link.w, link.v);
        let u_z = link.U.map(|row| row[2]);
        let e = [wy, -wx, Expr::ZERO];
        let twice_e = e.map(|e| g.mul(scale, e));
        match kind {
            JointKind::Revolute => {
                let lift = cross(g, v, e);
                let a_0 = add(g, [link.a[1], -link.a[0], Expr::ZERO], lift);
                let twice_v = [v[1], -v[0], Expr::ZERO];
                let z = [Expr::ZERO, Expr::ZERO, Expr::ONE];
                Change {
                    by_q: AccelerationField { W: e, A: u_z, a_0 },
                    by_dq: AccelerationField { W: z, A: twice_e, a_0: twice_v },
                }
            }
            JointKind::Prismatic => Change {
                by_q: AccelerationField { W: NULL, A: NULL, a_0: u_z },
                by_dq: AccelerationField { W: NULL, A: NULL, a_0: twice_e },
            },
            JointKind::Fixed => {
                let still = || AccelerationField { W: NULL, A: NULL, a_0: NULL };
                Change { by_q: still(), by_dq: still() }
            }
        }
    }
}

impl AccelerationField {
    /// Force and moment that the field causes on a body: I (A, a_0) + 2 B(W). `momenta`: the momenta of the body, times the
    /// factor of the velocities.
    fn wrench(&self, g: &mut Graph, body: RigidBody, momenta: &Momenta) -> [Vector; 2] {
        let (across, moved) = (cross(g, self.A, body.first_moment), self.a_0.map(|a| g.mul(body.mass, a)));
        let (turned, lever) = (body.times(g, self.A), cross(g, body.first_moment, self.a_0));
        let (f, n) = momenta.times(g, self.W);
        let (moved, turned) = (add(g, moved, across), add(g, turned, lever));
        [add(g, moved, f), add(g, turned, n)]
    }

    /// The component f . a_0 + n . A + u . W of the field along a joint. (f, n): unit wrench of the joint; u: row of 2 B along
    /// the joint (B: momentum matrix of the body).
    fn along(&self, g: &mut Graph, [f, n]: [Vector; 2], of_momenta: Vector) -> Expr {
        let sum = dot(g, f, self.a_0);
        let sum = plus_dot(g, sum, n, self.A);
        plus_dot(g, sum, of_momenta, self.W)
    }
}
