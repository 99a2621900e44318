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
//! Links on parallel axes share one orientation but for a turn about the common axis: their turns
//! are added up before a vector is turned, once. A chain of passive joints that turn back (a
//! parallelogram) thereby turns by nothing, exactly.

use expr::{Expr, Graph, Input, SymbolKind};
use robot::{JointKind, Link, Robot};

use crate::kinematics::angle::Angle;
use crate::kinematics::constants::Constants;
use crate::kinematics::vector::{NULL, Turn, Vector, add, cross, dot};

/// Every joint variable and its rates: n coordinates, then the passive ones, whose rates follow from
/// the coordinates'.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    pub q: Vec<Expr>,
    pub dq: Vec<Expr>,
    pub ddq: Vec<Expr>,
    /// Number of coordinates.
    pub n: usize,
}

impl Motion {
    pub fn new(g: &mut Graph, robot: &Robot) -> Motion {
        let n = robot.n_coordinates();
        let mut inputs = |prefix: &str, count: usize| -> Vec<Expr> {
            let name = |k: usize| format!("{prefix}[{k}]");
            (0..count).map(|k| g.symbol(&name(k), SymbolKind::Input)).collect()
        };
        let (mut q, mut dq, mut ddq) = (inputs("q", n), inputs("dq", n), inputs("ddq", n));
        q.extend(inputs("passive", robot.passive.len()));
        dq.resize(q.len(), Expr::ZERO);
        ddq.resize(q.len(), Expr::ZERO);
        Motion { q, dq, ddq, n }
    }

    /// `q`, `passive` where there are such, `dq`, `ddq`.
    pub fn inputs(&self) -> Vec<Input> {
        let names: &[&str] = if self.q.len() > self.n { &["q", "passive", "dq", "ddq"] } else { &["q", "dq", "ddq"] };
        names.iter().map(|name| self.input(name)).collect()
    }

    /// `q`, and `passive` where there are such.
    pub fn configuration(&self) -> Vec<Input> {
        let names: &[&str] = if self.q.len() > self.n { &["q", "passive"] } else { &["q"] };
        names.iter().map(|name| self.input(name)).collect()
    }

    /// One of `q`, `passive`, `dq`, `ddq`.
    pub fn input(&self, name: &str) -> Input {
        let entries = match name {
            "q" => &self.q[..self.n],
            "passive" => &self.q[self.n..],
            "dq" => &self.dq[..self.n],
            _ => &self.ddq[..self.n],
        };
        Input { name: name.into(), entries: entries.to_vec() }
    }
}

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
    pub dw: Vector,
    pub a: Vector,
    /// [dw]x + [w]x^2, row by row.
    pub U: [Vector; 3],
    /// Per coordinate; `None` where the coordinate does not move the link.
    pub jacobian: Vec<Option<Twist>>,
    /// The joint's own acceleration, rad/s^2 or m/s^2.
    pub joint_acceleration: Expr,
    pub placement: Placement,
    parallel: Parallel,
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
    pub fn to_link(&self, g: &mut Graph, v: Vector) -> Vector {
        let v = self.to_link_before_theta(g, v);
        self.theta.turned(g, v)
    }

    fn to_link_before_theta(&self, g: &mut Graph, v: Vector) -> Vector {
        let v = self.gamma.turned(g, v);
        self.alpha.turned_about_x(g, v)
    }

    /// Components in frame i of a vector given in frame j.
    pub fn to_antecedent(&self, g: &mut Graph, v: Vector) -> Vector {
        let v = self.theta.unturned(g, v);
        let v = self.alpha.unturned_about_x(g, v);
        self.gamma.unturned(g, v)
    }
}

/// A run of links on parallel axes: rates before any of its turns, and the turn added up so far.
#[derive(Clone, Debug)]
struct Parallel {
    w: Vector,
    dw: Vector,
    /// Angular part of the twist per coordinate.
    z: Vec<Vector>,
    turn: Angle,
    rate: Expr,
    acceleration: Expr,
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
    let n = robot.n_variables();
    let at_rest = Parallel {
        w: NULL,
        dw: NULL,
        z: vec![NULL; n],
        turn: Angle::default(),
        rate: Expr::ZERO,
        acceleration: Expr::ZERO,
        rates: vec![0.0; n],
    };
    let unturned = Turn { cos: Expr::ONE, sin: Expr::ZERO };
    let base = LinkMotion {
        w: NULL,
        dw: NULL,
        a: constants.weight(g),
        U: [NULL; 3],
        jacobian: vec![None; n],
        joint_acceleration: Expr::ZERO,
        placement: Placement { gamma: unturned, alpha: unturned, theta: unturned, p: NULL },
        parallel: at_rest,
    };
    let mut motions: Vec<LinkMotion> = Vec::with_capacity(robot.links.len());
    for link in &robot.links {
        let antecedent = link.antecedent.map_or(&base, |i| &motions[i.0]);
        let next = carried(g, constants, motion, link, antecedent);
        motions.push(next);
    }
    motions
}

fn carried(g: &mut Graph, constants: &mut Constants, motion: &Motion, link: &Link, i: &LinkMotion) -> LinkMotion {
    let name = |letter: &str| format!("{letter}{}", link.label);
    let dh = &link.geometry;
    let gamma = constants.angle(g, &dh.gamma, &name("gamma"));
    let alpha = constants.angle(g, &dh.alpha, &name("alpha"));
    let mut theta = constants.angle(g, &dh.theta, &name("theta"));
    let (b, d) = (constants.length(g, &dh.b, &name("b")), constants.length(g, &dh.d, &name("d")));
    let mut r = constants.length(g, &dh.r, &name("r"));

    let (rate, acceleration) = (rate(g, link, &motion.dq), rate(g, link, &motion.ddq));
    match link.joint.kind {
        JointKind::Revolute => {
            for &(k, c) in &link.joint.variable.terms {
                let q = motion.q[k.0];
                if c.fract() == 0.0 {
                    theta.add_term(q, c as i64);
                } else {
                    let factor = g.constant(c.abs());
                    let turn = g.mul(factor, q);
                    theta.add_term(turn, if c < 0.0 { -1 } else { 1 });
                }
            }
        }
        JointKind::Prismatic => {
            let q = self::rate(g, link, &motion.q);
            r = g.add(r, q);
        }
        JointKind::Fixed => {}
    }

    let (gamma_turn, alpha_turn, theta_turn) = (gamma.turn(g), alpha.turn(g), theta.turn(g));
    // p = Rz(gamma) (d, -r sin alpha, b + r cos alpha)
    let (rs, rc) = (g.mul(r, alpha_turn.sin), g.mul(r, alpha_turn.cos));
    let p = {
        let along_z = g.add(b, rc);
        gamma_turn.unturned(g, [d, -rs, along_z])
    };
    let placement = Placement { gamma: gamma_turn, alpha: alpha_turn, theta: theta_turn, p };

    let parallel = {
        let mut run = if alpha.is_zero() {
            Parallel { turn: i.parallel.turn.plus(&gamma), ..i.parallel.clone() }
        } else {
            Parallel {
                w: placement.to_link_before_theta(g, i.w),
                dw: placement.to_link_before_theta(g, i.dw),
                z: i.jacobian.iter().map(|t| t.map_or(NULL, |t| placement.to_link_before_theta(g, t.z))).collect(),
                turn: Angle::default(),
                rate: Expr::ZERO,
                acceleration: Expr::ZERO,
                rates: vec![0.0; i.jacobian.len()],
            }
        };
        run.turn = run.turn.plus(&theta);
        if link.joint.kind == JointKind::Revolute {
            run.rate = g.add(run.rate, rate);
            run.acceleration = g.add(run.acceleration, acceleration);
            for &(k, c) in &link.joint.variable.terms {
                run.rates[k.0] += c;
            }
        }
        run
    };

    let turn = parallel.turn.turn(g);
    let w = {
        let [x, y, z] = turn.turned(g, parallel.w);
        [x, y, g.add(z, parallel.rate)]
    };
    let dw = {
        let [x, y, z] = turn.turned(g, parallel.dw);
        let (wy, wx) = (g.mul(w[1], parallel.rate), g.mul(w[0], parallel.rate));
        [g.add(x, wy), g.sub(y, wx), g.add(z, parallel.acceleration)]
    };
    let a = {
        let offset = i.U.map(|row| dot(g, row, p));
        let a = add(g, i.a, offset);
        let a = placement.to_link(g, a);
        match link.joint.kind {
            JointKind::Prismatic => {
                let two = g.constant(2.0);
                let twice = g.mul(two, rate);
                let (wy, wx) = (g.mul(w[1], twice), g.mul(w[0], twice));
                [g.add(a[0], wy), g.sub(a[1], wx), g.add(a[2], acceleration)]
            }
            _ => a,
        }
    };

    let mut jacobian = Vec::with_capacity(i.jacobian.len());
    for (k, twist) in i.jacobian.iter().enumerate() {
        let own = link.joint.variable.terms.iter().find(|t| t.0.0 == k).map(|t| t.1);
        if twist.is_none() && own.is_none() {
            jacobian.push(None);
            continue;
        }
        let z = {
            let [x, y, z] = turn.turned(g, parallel.z[k]);
            let along = g.constant(parallel.rates[k]);
            [x, y, g.add(z, along)]
        };
        let mut d = match twist {
            Some(t) => {
                let lever = cross(g, t.z, p);
                let d = add(g, t.d, lever);
                placement.to_link(g, d)
            }
            None => NULL,
        };
        if let (JointKind::Prismatic, Some(c)) = (link.joint.kind, own) {
            let c = g.constant(c);
            d[2] = g.add(d[2], c);
        }
        jacobian.push(Some(Twist { z, d }));
    }

    LinkMotion {
        w,
        dw,
        a,
        U: acceleration_matrix(g, w, dw),
        jacobian,
        joint_acceleration: acceleration,
        placement,
        parallel,
    }
}

/// sum_k c_k x_k of the joint variable.
fn rate(g: &mut Graph, link: &Link, x: &[Expr]) -> Expr {
    let mut sum = Expr::ZERO;
    for &(k, c) in &link.joint.variable.terms {
        let c = g.constant(c);
        let term = g.mul(c, x[k.0]);
        sum = g.add(sum, term);
    }
    sum
}

/// U = [dw]x + [w]x^2.
fn acceleration_matrix(g: &mut Graph, w: Vector, dw: Vector) -> [Vector; 3] {
    let [xx, yy, zz] = w.map(|x| g.mul(x, x));
    let (xy, xz, yz) = (g.mul(w[0], w[1]), g.mul(w[0], w[2]), g.mul(w[1], w[2]));
    [
        [-g.add(yy, zz), g.sub(xy, dw[2]), g.add(xz, dw[1])],
        [g.add(xy, dw[2]), -g.add(xx, zz), g.sub(yz, dw[0])],
        [g.sub(xz, dw[1]), g.add(yz, dw[0]), -g.add(xx, yy)],
    ]
}
