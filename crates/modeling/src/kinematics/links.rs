//! Derives the velocity and acceleration of every link in its own frame, and the link's Jacobian, as expressions.
//!
//! For link j with the antecedent i (the base at rest, gravity as a_0 = -g):
//!
//! ```text
//! w_j  = jRi w_i  + dtheta_j z                     angular velocity, rad/s
//! dw_j = jRi dw_i + ddtheta_j z + w_j x z dtheta_j  angular acceleration, rad/s^2
//! a_j  = jRi (a_i + U_i p_ij) + ddr_j z + 2 w_j x z dr_j   acceleration of O_j minus g, m/s^2
//! U_j  = [dw_j]x + [w_j]x^2
//! ```
//! [Khalil, Dombre 2002, recursive Newton-Euler for modified DH]. jRi: rotation from frame i to frame j; z: joint axis; theta_j,
//! r_j: variable of a revolute and of a prismatic joint; p_ij: position of O_j in frame i. The Jacobian holds for each coordinate
//! k the twist of frame j per unit of dq_k: z_jk (angular), d_jk (linear, at O_j).
//!
//! Consecutive links on parallel axes (a run) have the same orientation except for a rotation about the common direction. The
//! angles of a run are added first, and each vector is rotated once. If the angles of passive joints cancel, as in a
//! parallelogram, no rotation is needed.

use expr::{Expr, Graph};
use robot::{JointKind, Link, LinkId, Robot};

use crate::kinematics::angle::Angle;
use crate::kinematics::angular_motion::{AngularMotion, Bend};
use crate::kinematics::axis_intersections::AxisIntersections;
use crate::kinematics::constants::Constants;
pub(crate) use crate::kinematics::motion::{JointVariables, MotionInput};
use crate::kinematics::names::{name_motion, name_twists};
pub(crate) use crate::kinematics::placement::{Placement, Twist, along_axis};
use crate::kinematics::vector::{NULL, Vector, ZRotation, plus_cross, plus_dot};

/// The motion of a link, in the frame of the link: angular velocity w, acceleration a of the link's origin minus gravity, and
/// others.
#[derive(Clone, Debug)]
pub(crate) struct LinkMotion {
    pub w: Vector,
    pub angular_motion: AngularMotion,
    pub a: Vector,
    /// The twist of the link per unit rate of each coordinate; `None` if the coordinate does not move the link.
    pub jacobian: Vec<Option<Twist>>,
    pub poles: AxisIntersections,
    /// The acceleration of the link's own joint variable, rad/s^2 or m/s^2.
    pub joint_acceleration: Expr,
    pub placement: Placement,
    pub parallel: Parallel,
}

/// A run of links on parallel axes. For the link before the run, it holds w (angular velocity), bend (second derivative of the
/// axis) and dw_z. For the run up to this link, it holds the sums of angles and rates.
#[derive(Clone, Debug)]
pub(crate) struct Parallel {
    pub w: Vector,
    pub bend: Bend,
    /// Component of the angular acceleration along the axes, before the rates of the run are added.
    pub dw_z: Expr,
    /// Whether the link is the first of the run: its axis is not parallel to the axis before it.
    pub begins: bool,
    /// Angular part of the twist per unit rate of each coordinate, in axes before the turns of the run.
    z: Vec<Vector>,
    pub turn: Angle,
    pub rate: Expr,
    pub acceleration: Expr,
    /// Coefficients of `rate`: the value of `rate` per unit rate of each coordinate.
    rates: Vec<f64>,
}

/// The motion of every link, in the order of the robot's links. Gravity is included as an acceleration of the base.
pub(crate) fn link_motions(
    g: &mut Graph,
    robot: &Robot,
    constants: &mut Constants,
    motion: &JointVariables,
) -> Vec<LinkMotion> {
    let weight = constants.weight(g);
    link_motions_under(g, robot, constants, motion, weight)
}

/// The motion of every link if the base has the acceleration `weight`, m/s^2 (minus g to include gravity).
pub(crate) fn link_motions_under(
    g: &mut Graph,
    robot: &Robot,
    constants: &mut Constants,
    motion: &JointVariables,
    weight: Vector,
) -> Vec<LinkMotion> {
    // The base is at rest and has the acceleration `weight`.
    let n = robot.n_variables();
    let at_rest = Parallel {
        w: NULL,
        bend: Bend::STILL,
        dw_z: Expr::ZERO,
        begins: false,
        z: vec![NULL; n],
        turn: Angle::default(),
        rate: Expr::ZERO,
        acceleration: Expr::ZERO,
        rates: vec![0.0; n],
    };
    let unturned = ZRotation { cos: Expr::ONE, sin: Expr::ZERO };
    let base = LinkMotion {
        w: NULL,
        angular_motion: AngularMotion { dw: NULL, ww: [NULL; 3], differences: NULL, U: [NULL; 3] },
        a: weight,
        jacobian: vec![None; n],
        poles: AxisIntersections::of_base(n),
        joint_acceleration: Expr::ZERO,
        placement: Placement { gamma: unturned, alpha: unturned, theta: unturned, p: NULL },
        parallel: at_rest,
    };
    // Antecedents come before the links that they carry, so one pass outward is enough.
    let mut motions: Vec<LinkMotion> = Vec::with_capacity(robot.links.len());
    for (j, link) in robot.link_ids().zip(&robot.links) {
        let antecedent = link.antecedent.map_or(&base, |i| &motions[i.0]);
        let next = carried(g, constants, motion, (j, link), antecedent);
        motions.push(next);
    }
    motions
}

/// The motion of link j from the motion of its antecedent i, computed in six passes.
fn carried(
    g: &mut Graph,
    constants: &mut Constants,
    motion: &JointVariables,
    (j, link): (LinkId, &Link),
    i: &LinkMotion,
) -> LinkMotion {
    let mut geometry = Geometry::of(g, constants, link);
    let [rate, acceleration] = [&motion.dq, &motion.ddq].map(|x| joint_variable(g, link, x));
    geometry.add_joint_variable(g, link, &motion.q);

    let placement = geometry.placement(g);
    let parallel = run_of_parallel_axes(g, link, i, &geometry, &placement, rate, acceleration);
    let turn = parallel.turn.turn(g);
    let w = angular_velocity(g, &parallel, turn);
    let a = acceleration_of_origin(g, link, i, &placement, w, rate, acceleration);
    let jacobian = jacobian(g, link, i, &placement, &parallel, turn);
    let spin = angular_motion(g, &parallel, turn, w);
    if g.keeps_names() {
        name_motion(g, &link.label, [w, spin.dw, a], [&spin.ww, &spin.U]);
        let twists = jacobian.iter().map(|t| t.map(|t: Twist| [t.z, t.d]));
        name_twists(g, &link.label, twists, &motion.q);
    }
    let poles = i.poles.carried(g, (j, link), &placement, &i.jacobian);
    LinkMotion { w, angular_motion: spin, a, jacobian, poles, joint_acceleration: acceleration, placement, parallel }
}

/// The geometric parameters gamma, b, alpha, d, theta, r of a link (modified DH) as expressions.
pub struct Geometry {
    /// Angle about the z axis of the antecedent, rad.
    pub gamma: Angle,
    /// Distance along the z axis of the antecedent, m.
    pub b: Expr,
    /// Angle about the x axis, rad.
    pub alpha: Angle,
    /// Distance along the x axis, m.
    pub d: Expr,
    /// Angle about the z axis of the link, rad; a revolute joint adds its variable.
    pub theta: Angle,
    /// Distance along the z axis of the link, m; a prismatic joint adds its variable.
    pub r: Expr,
}

impl Geometry {
    /// The constant geometry of a link, at joint variable zero.
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

    /// Adds the joint variable q_j = sum_k c_k q_k: to theta for a revolute joint, to r for a prismatic one.
    fn add_joint_variable(&mut self, g: &mut Graph, link: &Link, q: &[Expr]) {
        match link.joint.kind {
            JointKind::Revolute => {
                for &(k, c) in &link.joint.variable.terms {
                    let q = q[k.0];
                    // cos and sin of an integer multiple of q are expanded into cos and sin of q itself.
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

    /// First pass: the placement of link j in its antecedent i,
    /// `iTj = Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r)` [Khalil, Kleinfinger 1986].
    fn placement(&self, g: &mut Graph) -> Placement {
        let (gamma, alpha, theta) = (self.gamma.turn(g), self.alpha.turn(g), self.theta.turn(g));
        // Position of O_j: p_ij = Rz(gamma) (d, -r sin alpha, b + r cos alpha).
        let (rs, rc) = (g.mul(self.r, alpha.sin), g.mul(self.r, alpha.cos));
        let along_z = g.add(self.b, rc);
        let p = gamma.unturned(g, [self.d, -rs, along_z]);
        Placement { gamma, alpha, theta, p }
    }
}

/// Second pass: the run of parallel axes up to the link. The run holds the angular velocity w_0, the angular acceleration dw_0
/// and the twists z_0k of the link before the run, in axes before the turns of the run. The run also holds the sums over its
/// links
///
/// ```text
/// phi = sum (gamma + theta),   rate = sum dtheta,   acceleration = sum ddtheta
/// ```
/// A link whose alpha is not zero begins a run, with w_0 = Rx(-alpha) Rz(-gamma) w_i.
fn run_of_parallel_axes(
    g: &mut Graph,
    link: &Link,
    i: &LinkMotion,
    geometry: &Geometry,
    placement: &Placement,
    rate: Expr,
    acceleration: Expr,
) -> Parallel {
    // A link on a parallel axis continues the run; otherwise a new run begins with w_0 = Rx(-alpha) Rz(-gamma) w_i.
    let mut run = if geometry.alpha.is_zero() {
        Parallel { turn: i.parallel.turn.plus(&geometry.gamma), begins: false, ..i.parallel.clone() }
    } else {
        let (w, bend, dw_z) = before_the_run(g, placement, i);
        Parallel {
            w,
            bend,
            dw_z,
            begins: true,
            z: i.jacobian.iter().map(|t| t.map_or(NULL, |t| placement.to_link_before_theta(g, t.z))).collect(),
            turn: Angle::default(),
            rate: Expr::ZERO,
            acceleration: Expr::ZERO,
            rates: vec![0.0; i.jacobian.len()],
        }
    };
    // Add the turn and the rates of the link's own joint to the sums of the run.
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

/// Quantities of link i at the start of a run: angular velocity w_0 = Rx(-alpha) Rz(-gamma) w_i, second derivative of the axis,
/// and the component of the angular acceleration dw_0 along the axis.
fn before_the_run(g: &mut Graph, placement: &Placement, i: &LinkMotion) -> (Vector, Bend, Expr) {
    let w = placement.to_link_before_theta(g, i.w);
    let dw = placement.to_link_before_theta(g, i.angular_motion.dw);
    let bend = placement.bend(g, &i.angular_motion.U).unwrap_or_else(|| {
        let products = [g.mul(w[0], w[2]), g.mul(w[1], w[2])];
        Bend::of_rates(g, dw, products)
    });
    (w, bend, dw[2])
}

/// Third pass: the angular velocity w_j = Rz(-phi) w_0 + rate z. phi, rate: sums of the angles and of the rates of the run
/// (consecutive links on parallel axes), so one rotation is enough.
fn angular_velocity(g: &mut Graph, run: &Parallel, turn: ZRotation) -> Vector {
    let [x, y, z] = turn.turned(g, run.w);
    [x, y, g.add(z, run.rate)]
}

/// Fourth pass: the acceleration a_j = jRi (a_i + U_i p_ij). A prismatic joint adds 2 w_j x z dr_j + ddr_j z [Khalil, Dombre
/// 2002].
fn acceleration_of_origin(
    g: &mut Graph,
    link: &Link,
    i: &LinkMotion,
    placement: &Placement,
    w: Vector,
    rate: Expr,
    acceleration: Expr,
) -> Vector {
    let at_o_j = [0, 1, 2].map(|r| plus_dot(g, i.a[r], i.angular_motion.U[r], placement.p));
    let mut a = placement.to_link(g, at_o_j);
    if link.joint.kind == JointKind::Prismatic {
        // The cross product is w x z = (w_y, -w_x, 0).
        let two = g.constant(2.0);
        let twice = g.mul(two, rate);
        let (wy, wx) = (g.mul(w[1], twice), g.mul(w[0], twice));
        a = [g.add(a[0], wy), g.sub(a[1], wx), g.add(a[2], acceleration)];
    }
    a
}

/// Fifth pass: the twist of the link per unit rate of each coordinate; `None` for a coordinate that does not move the link.
fn jacobian(
    g: &mut Graph,
    link: &Link,
    i: &LinkMotion,
    placement: &Placement,
    run: &Parallel,
    turn: ZRotation,
) -> Vec<Option<Twist>> {
    let mut columns = Vec::with_capacity(i.jacobian.len());
    for (k, twist) in i.jacobian.iter().enumerate() {
        let own = link.joint.variable.terms.iter().find(|t| t.0.0 == k).map(|t| t.1);
        if twist.is_none() && own.is_none() {
            columns.push(None);
            continue;
        }
        // Angular part: z_jk = Rz(-phi) z_0k + (sum of c_k over the run's revolute joints) z. c_k: coefficient of coordinate k;
        // phi: angle of the run.
        let [x, y, z] = turn.turned(g, run.z[k]);
        let along = g.constant(run.rates[k]);
        let z = [x, y, g.add(z, along)];

        // Linear part: d_jk = jRi (d_ik + z_ik x p_ij). A prismatic joint adds c_jk z with c_jk = dq_j / dq_k.
        let mut d = match twist {
            Some(t) => {
                let d = plus_cross(g, t.d, t.z, placement.p);
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

/// Sixth pass: the angular acceleration dw_j and the matrix U_j = [dw_j]x + [w_j]x^2.
fn angular_motion(g: &mut Graph, run: &Parallel, turn: ZRotation, w: Vector) -> AngularMotion {
    let (bend, dw_z) = (run.bend.turned(g, turn), g.add(run.dw_z, run.acceleration));
    AngularMotion::new(g, bend, dw_z, |g, i, k| g.mul(w[i], w[k]))
}

/// Adds `along`, a component along the axis of a joint, to the sum of each coordinate k that the joint follows, times the
/// coefficient c_k of this coordinate.
pub(crate) fn add_to_coordinates(g: &mut Graph, link: &Link, along: Expr, sums: &mut [Expr]) {
    for &(k, c) in &link.joint.variable.terms {
        let c = g.constant(c);
        let term = g.mul(c, along);
        sums[k.0] = g.add(sums[k.0], term);
    }
}

/// The joint variable q_j of a link, or the rate or the acceleration of this variable: sum_k c_k x_k over the coordinates with
/// the values `x`.
pub(crate) fn joint_variable(g: &mut Graph, link: &Link, x: &[Expr]) -> Expr {
    let mut sum = Expr::ZERO;
    for &(k, c) in &link.joint.variable.terms {
        let c = g.constant(c);
        let term = g.mul(c, x[k.0]);
        sum = g.add(sum, term);
    }
    sum
}
