//! Velocities and accelerations of every link in its own frame, and its Jacobian.
//!
//! For link j carried by i (the base at rest, gravity entering as a_0 = -g):
//!
//! ```text
//! w_j  = jRi w_i  + dtheta_j z                     angular velocity, rad/s
//! dw_j = jRi dw_i + ddtheta_j z + w_j x z dtheta_j  angular acceleration, rad/s^2
//! a_j  = jRi (a_i + U_i p_ij) + ddr_j z + 2 w_j x z dr_j   acceleration of O_j minus g, m/s^2
//! U_j  = [dw_j]x + [w_j]x^2
//! ```
//! [Khalil, Dombre 2002, recursive Newton-Euler for modified DH], and for each coordinate k, the
//! twist of frame j per unit of dq_k: z_jk (angular), d_jk (linear, at O_j).
//!
//! Links on parallel axes share one orientation but for a turn about the common axis. Their turns are added up first,
//! and a vector is turned once. A chain of passive joints that turn back (a parallelogram) thereby turns by exactly
//! nothing.

use expr::{Expr, Graph};
use robot::{JointKind, Link, Robot};

use crate::kinematics::angle::Angle;
use crate::kinematics::constants::Constants;
pub(crate) use crate::kinematics::motion::{Motion, MotionInput};
use crate::kinematics::names::{name_motion, name_twists};
use crate::kinematics::vector::{NULL, Turn, Vector, acceleration_matrix, add, cross, dot, products};

/// Angular and linear part of the twist of a link frame per unit of one coordinate's rate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Twist {
    pub z: Vector,
    pub d: Vector,
}

/// How a link moves, in its own frame.
#[derive(Clone, Debug)]
pub(crate) struct LinkMotion {
    pub w: Vector,
    /// w w^T, row by row.
    pub ww: [Vector; 3],
    pub dw: Vector,
    pub a: Vector,
    /// [dw]x + [w]x^2, row by row.
    pub U: [Vector; 3],
    /// Per coordinate; `None` where the coordinate does not move the link.
    pub jacobian: Vec<Option<Twist>>,
    /// The joint's own acceleration, rad/s^2 or m/s^2.
    pub joint_acceleration: Expr,
    pub placement: Placement,
    pub parallel: Parallel,
}

/// Where a link stands in its antecedent's frame.
#[derive(Clone, Debug)]
pub(crate) struct Placement {
    pub gamma: Turn,
    pub alpha: Turn,
    pub theta: Turn,
    /// O_j from O_i, in frame i.
    pub p: Vector,
}

impl Placement {
    /// Components in frame j of a vector given in frame i.
    pub(crate) fn to_link(&self, g: &mut Graph, v: Vector) -> Vector {
        let v = self.to_link_before_theta(g, v);
        self.theta.turned(g, v)
    }

    pub(crate) fn to_link_before_theta(&self, g: &mut Graph, v: Vector) -> Vector {
        let v = self.gamma.turned(g, v);
        self.alpha.turned_about_x(g, v)
    }

    /// Components in frame i of a vector given in frame j.
    pub(crate) fn to_antecedent(&self, g: &mut Graph, v: Vector) -> Vector {
        let v = self.theta.unturned(g, v);
        let v = self.alpha.unturned_about_x(g, v);
        self.gamma.unturned(g, v)
    }
}

/// A run of links on parallel axes: rates before any of its turns, and the turn added up so far.
#[derive(Clone, Debug)]
pub(crate) struct Parallel {
    pub w: Vector,
    pub dw: Vector,
    /// Whether the link begins it, its axis parallel to none before.
    pub begins: bool,
    /// Angular part of the twist per coordinate.
    z: Vec<Vector>,
    pub turn: Angle,
    pub rate: Expr,
    pub acceleration: Expr,
    /// Rate per unit of each coordinate's.
    rates: Vec<f64>,
}

/// The motion of every link, in the order of the robot's links.
pub(crate) fn link_motions(
    g: &mut Graph,
    robot: &Robot,
    constants: &mut Constants,
    motion: &Motion,
) -> Vec<LinkMotion> {
    let weight = constants.weight(g);
    link_motions_under(g, robot, constants, motion, weight)
}

/// The same where the base seems to accelerate by `weight`.
pub(crate) fn link_motions_under(
    g: &mut Graph,
    robot: &Robot,
    constants: &mut Constants,
    motion: &Motion,
    weight: Vector,
) -> Vec<LinkMotion> {
    // The base: at rest, unturned, its acceleration the weight.
    let n = robot.n_variables();
    let at_rest = Parallel {
        w: NULL,
        dw: NULL,
        begins: false,
        z: vec![NULL; n],
        turn: Angle::default(),
        rate: Expr::ZERO,
        acceleration: Expr::ZERO,
        rates: vec![0.0; n],
    };
    let unturned = Turn { cos: Expr::ONE, sin: Expr::ZERO };
    let base = LinkMotion {
        w: NULL,
        ww: [NULL; 3],
        dw: NULL,
        a: weight,
        U: [NULL; 3],
        jacobian: vec![None; n],
        joint_acceleration: Expr::ZERO,
        placement: Placement { gamma: unturned, alpha: unturned, theta: unturned, p: NULL },
        parallel: at_rest,
    };
    // Antecedents stand before what they carry, so one pass outward is enough.
    let mut motions: Vec<LinkMotion> = Vec::with_capacity(robot.links.len());
    for link in &robot.links {
        let antecedent = link.antecedent.map_or(&base, |i| &motions[i.0]);
        let next = carried(g, constants, motion, link, antecedent);
        motions.push(next);
    }
    motions
}

/// The motion of a link from that of its antecedent i, in four passes.
fn carried(g: &mut Graph, constants: &mut Constants, motion: &Motion, link: &Link, i: &LinkMotion) -> LinkMotion {
    let mut geometry = Geometry::of(g, constants, link);
    let [rate, acceleration] = [&motion.dq, &motion.ddq].map(|x| joint_variable(g, link, x));
    geometry.add_joint_variable(g, link, &motion.q);

    let placement = geometry.placement(g);
    let parallel = run_of_parallel_axes(g, link, i, &geometry, &placement, rate, acceleration);
    let turn = parallel.turn.turn(g);
    let (w, dw, a) = rates(g, link, i, &placement, &parallel, turn, rate, acceleration);
    let jacobian = jacobian(g, link, i, &placement, &parallel, turn);
    let ww = products(g, w);
    let U = acceleration_matrix(g, &ww, dw);
    if g.keeps_names() {
        name_motion(g, &link.label, [w, dw, a], [&ww, &U]);
        let twists = jacobian.iter().map(|t| t.map(|t: Twist| [t.z, t.d]));
        name_twists(g, &link.label, twists, &motion.q);
    }
    LinkMotion { w, ww, dw, a, U, jacobian, joint_acceleration: acceleration, placement, parallel }
}

/// gamma, b, alpha, d, theta, r of a link as expressions.
pub(crate) struct Geometry {
    pub gamma: Angle,
    pub b: Expr,
    pub alpha: Angle,
    pub d: Expr,
    pub theta: Angle,
    pub r: Expr,
}

impl Geometry {
    /// The constant part, from the link's description.
    pub(crate) fn of(g: &mut Graph, constants: &mut Constants, link: &Link) -> Geometry {
        let name = |letter: &str| format!("{letter}{}", link.label);
        let dh = &link.geometry;
        let gamma = constants.angle(g, &dh.gamma, &name("gamma"));
        let alpha = constants.angle(g, &dh.alpha, &name("alpha"));
        let theta = constants.angle(g, &dh.theta, &name("theta"));
        let (b, d) = (constants.length(g, &dh.b, &name("b")), constants.length(g, &dh.d, &name("d")));
        let r = constants.length(g, &dh.r, &name("r"));
        Geometry { gamma, b, alpha, d, theta, r }
    }

    /// theta += q_j (revolute), r += q_j (prismatic), with q_j = sum_k c_k q_k.
    fn add_joint_variable(&mut self, g: &mut Graph, link: &Link, q: &[Expr]) {
        match link.joint.kind {
            JointKind::Revolute => {
                for &(k, c) in &link.joint.variable.terms {
                    let q = q[k.0];
                    // An integer multiple of an angle is expanded by the sine and cosine of the angle itself.
                    if c.fract() == 0.0 {
                        self.theta.add_term(q, c as i64);
                    } else {
                        let factor = g.constant(c.abs());
                        let turn = g.mul(factor, q);
                        self.theta.add_term(turn, if c < 0.0 { -1 } else { 1 });
                    }
                }
            }
            JointKind::Prismatic => {
                let q = joint_variable(g, link, q);
                self.r = g.add(self.r, q);
            }
            JointKind::Fixed => {}
        }
    }

    /// First pass, where the link stands:
    /// `iTj = Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r)` [Khalil, Kleinfinger 1986].
    fn placement(&self, g: &mut Graph) -> Placement {
        let (gamma, alpha, theta) = (self.gamma.turn(g), self.alpha.turn(g), self.theta.turn(g));
        // p_ij = Rz(gamma) (d, -r sin alpha, b + r cos alpha)
        let (rs, rc) = (g.mul(self.r, alpha.sin), g.mul(self.r, alpha.cos));
        let along_z = g.add(self.b, rc);
        let p = gamma.unturned(g, [self.d, -rs, along_z]);
        Placement { gamma, alpha, theta, p }
    }
}

/// Second pass, the run of parallel axes that the link ends. With w_0, dw_0, z_0k of the link before
/// the run, in axes parallel to the run's, and the sums over the links of the run
///
/// ```text
/// phi = sum (gamma + theta),   rate = sum dtheta,   acceleration = sum ddtheta
/// ```
/// A link whose alpha is not zero begins a run: its w_0 = Rx(-alpha) Rz(-gamma) w_i.
fn run_of_parallel_axes(
    g: &mut Graph,
    link: &Link,
    i: &LinkMotion,
    geometry: &Geometry,
    placement: &Placement,
    rate: Expr,
    acceleration: Expr,
) -> Parallel {
    // On a parallel axis the run goes on, else a new one begins with w_0 = Rx(-alpha) Rz(-gamma) w_i.
    let mut run = if geometry.alpha.is_zero() {
        Parallel { turn: i.parallel.turn.plus(&geometry.gamma), begins: false, ..i.parallel.clone() }
    } else {
        Parallel {
            w: placement.to_link_before_theta(g, i.w),
            dw: placement.to_link_before_theta(g, i.dw),
            begins: true,
            z: i.jacobian.iter().map(|t| t.map_or(NULL, |t| placement.to_link_before_theta(g, t.z))).collect(),
            turn: Angle::default(),
            rate: Expr::ZERO,
            acceleration: Expr::ZERO,
            rates: vec![0.0; i.jacobian.len()],
        }
    };
    // The joint's own turn and rates join the sums of the run.
    run.turn = run.turn.plus(&geometry.theta);
    if link.joint.kind == JointKind::Revolute {
        run.rate = g.add(run.rate, rate);
        run.acceleration = g.add(run.acceleration, acceleration);
        for &(k, c) in &link.joint.variable.terms {
            run.rates[k.0] += c;
        }
    }
    run
}

/// Third pass, w_j, dw_j and a_j [Khalil, Dombre 2002], the turns of the run taken at once.
fn rates(
    g: &mut Graph,
    link: &Link,
    i: &LinkMotion,
    placement: &Placement,
    run: &Parallel,
    turn: Turn,
    rate: Expr,
    acceleration: Expr,
) -> (Vector, Vector, Vector) {
    // w_j = Rz(-phi) w_0 + rate z
    let [x, y, z] = turn.turned(g, run.w);
    let w = [x, y, g.add(z, run.rate)];

    // dw_j = Rz(-phi) dw_0 + w_j x z rate + acceleration z,   w x z = (w_y, -w_x, 0)
    let [x, y, z] = turn.turned(g, run.dw);
    let (wy, wx) = (g.mul(w[1], run.rate), g.mul(w[0], run.rate));
    let dw = [g.add(x, wy), g.sub(y, wx), g.add(z, run.acceleration)];

    // a_j = jRi (a_i + U_i p_ij), and for a prismatic joint + 2 w_j x z dr_j + ddr_j z
    let offset = i.U.map(|row| dot(g, row, placement.p));
    let at_o_j = add(g, i.a, offset);
    let mut a = placement.to_link(g, at_o_j);
    if link.joint.kind == JointKind::Prismatic {
        let two = g.constant(2.0);
        let twice = g.mul(two, rate);
        let (wy, wx) = (g.mul(w[1], twice), g.mul(w[0], twice));
        a = [g.add(a[0], wy), g.sub(a[1], wx), g.add(a[2], acceleration)];
    }
    (w, dw, a)
}

/// Fourth pass, the twist of the link per unit of each coordinate's rate; c_jk = dq_j / dq_k.
fn jacobian(
    g: &mut Graph,
    link: &Link,
    i: &LinkMotion,
    placement: &Placement,
    run: &Parallel,
    turn: Turn,
) -> Vec<Option<Twist>> {
    let mut columns = Vec::with_capacity(i.jacobian.len());
    for (k, twist) in i.jacobian.iter().enumerate() {
        let own = link.joint.variable.terms.iter().find(|t| t.0.0 == k).map(|t| t.1);
        if twist.is_none() && own.is_none() {
            columns.push(None);
            continue;
        }
        // z_jk = Rz(-phi) z_0k + (sum over the run's revolute joints of c_k) z
        let [x, y, z] = turn.turned(g, run.z[k]);
        let along = g.constant(run.rates[k]);
        let z = [x, y, g.add(z, along)];

        // d_jk = jRi (d_ik + z_ik x p_ij), and for a prismatic joint + c_jk z
        let mut d = match twist {
            Some(t) => {
                let lever = cross(g, t.z, placement.p);
                let d = add(g, t.d, lever);
                placement.to_link(g, d)
            }
            None => NULL,
        };
        if let (JointKind::Prismatic, Some(c)) = (link.joint.kind, own) {
            let c = g.constant(c);
            d[2] = g.add(d[2], c);
        }
        columns.push(Some(Twist { z, d }));
    }
    columns
}

/// q_j, or its rate or acceleration: sum_k c_k x_k.
pub(crate) fn joint_variable(g: &mut Graph, link: &Link, x: &[Expr]) -> Expr {
    let mut sum = Expr::ZERO;
    for &(k, c) in &link.joint.variable.terms {
        let c = g.constant(c);
        let term = g.mul(c, x[k.0]);
        sum = g.add(sum, term);
    }
    sum
}
