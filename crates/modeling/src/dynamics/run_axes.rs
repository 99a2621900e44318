//! Expresses links and composite bodies in common axes of a run: consecutive links on parallel joint axes.
//!
//! The links of a run ([`crate::kinematics::links`]) use axes that turn with the antecedent of the run, but not with the joints
//! of the run. So no rotation is needed from one link of the run to the next. From the first link to the antecedent, only the
//! rotation by alpha is needed, which is a right angle in most robots. One rotation about z leads from these axes to the axes
//! of a link:
//!
//! ```text
//! v = Rz(psi_k) v_k,   psi_k = sum of theta over the run up to k      v in the axes of the run, v_k in the link's
//! ```
//! A run on the base has no antecedent. It uses the axes of its last link instead: psi_k is replaced by psi_k - psi_last.
//!
//! The composite body of link k is summed in two steps. First, in the link's own axes (its ten parameters are constant there),
//! the bodies of the runs that start on this link are added. Then the sum is rotated once into the axes of the run, and the next
//! links of the run are added.

use expr::{Expr, Graph};
use robot::{JointKind, LinkId, Robot};

use crate::dynamics::composite::RigidBody;
use crate::dynamics::momenta::Momenta;
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::dynamics::torque;
use crate::kinematics::angle::Angle;
use crate::kinematics::angular_motion::AngularMotion;
use crate::kinematics::links::{JointVariables, LinkMotion, Placement, joint_variable};
use crate::kinematics::vector::{NULL, Vector, ZRotation, add, cross, dot};

/// The motion of a link in the axes of its run (consecutive links on parallel axes).
pub(crate) struct InRun {
    /// The rotation about z by psi, from the axes of the run to the axes of the link.
    psi: ZRotation,
    /// Whether the link is the first link of its run.
    begins: bool,
    /// The placement of the link in its antecedent: in the antecedent's own axes if the link is the first of its run, otherwise
    /// in the axes of the run.
    placement: Placement,
    pub w: Vector,
    /// Acceleration of the link's origin minus gravity, in the axes of the run.
    pub a: Vector,
    /// The matrix U = [dw]x + [w]x^2 of the link, row by row, in the axes of the run. w: angular velocity.
    pub U: [Vector; 3],
    /// Velocity of the link's origin in the axes of the run, times the factor `scale` (argument of [`in_runs`]).
    pub v: Vector,
    /// The velocity `v` in the axes of the link.
    own_v: Vector,
    /// The acceleration `a` in the axes of the link.
    own_a: Vector,
}

/// A link together with all links that it carries, with all joints between these links locked.
#[derive(Clone, Copy)]
pub(crate) struct CompositeBody {
    pub body: RigidBody,
    /// The momenta of the composite body. The velocities in these momenta are multiplied by the factor `scale` (argument of
    /// [`in_runs`]).
    pub momenta: Momenta,
    /// Force and moment about the origin of the link that give the composite body its motion.
    pub wrench: [Vector; 2],
}

impl CompositeBody {
    fn plus(self, g: &mut Graph, b: CompositeBody) -> CompositeBody {
        let wrench = [0, 1].map(|i| add(g, self.wrench[i], b.wrench[i]));
        CompositeBody { body: self.body.plus(g, b.body), momenta: self.momenta.plus(g, b.momenta), wrench }
    }

    /// All quantities of the composite body in axes rotated back about z by `turn`.
    fn unturned(self, g: &mut Graph, turn: ZRotation) -> CompositeBody {
        let wrench = self.wrench.map(|v| turn.unturned(g, v));
        CompositeBody { body: self.body.unturned(g, turn), momenta: self.momenta.unturned(g, turn), wrench }
    }

    /// All quantities of the composite body in the axes of the antecedent's frame, and about the antecedent's origin.
    /// `placement`: pose of the link in the antecedent.
    fn carried(self, g: &mut Graph, placement: &Placement) -> CompositeBody {
        CompositeBody {
            body: self.body.carried(g, placement),
            momenta: self.momenta.carried(g, placement),
            wrench: placement.wrench_to_antecedent(g, self.wrench),
        }
    }
}

impl InRun {
    /// Converts the vector `v` from the axes of this link's run to the axes of the antecedent's run. `before`: the antecedent.
    pub(crate) fn inward(&self, g: &mut Graph, before: &InRun, v: Vector) -> Vector {
        let v = self.placement.to_antecedent(g, v);
        if self.begins { before.psi.unturned(g, v) } else { v }
    }

    /// Converts a wrench of this link to force and moment about the origin of the antecedent, in the axes of the antecedent's
    /// run.
    pub(crate) fn inward_wrench(&self, g: &mut Graph, before: &InRun, wrench: [Vector; 2]) -> [Vector; 2] {
        let wrench = self.placement.wrench_to_antecedent(g, wrench);
        if self.begins { wrench.map(|v| before.psi.unturned(g, v)) } else { wrench }
    }
}

/// The motion of every link in the axes of its run. `w`: angular velocities in the links' own axes, times `scale`; `rates`: rates
/// of the coordinates, times `scale`; `scale`: a constant factor; `weight`: acceleration of the base minus gravity, m/s^2.
pub(crate) fn in_runs(
    g: &mut Graph,
    robot: &Robot,
    links: &[LinkMotion],
    (w, rates): (&[Vector], &[Expr]),
    motion: &JointVariables,
    scale: Expr,
    weight: Vector,
) -> Vec<InRun> {
    let unturned = ZRotation { cos: Expr::ONE, sin: Expr::ZERO };
    let axes = axes_of_runs(robot, links);
    let mut all: Vec<InRun> = Vec::with_capacity(links.len());
    for (k, link) in robot.links.iter().enumerate() {
        let (at, run) = (&links[k], &links[k].parallel);
        let begins = begins_run(robot, links, LinkId(k));
        let psi = run.turn.plus(&axes[k].negated()).turn(g);
        let placement = match link.antecedent {
            Some(i) if !begins => {
                let p = all[i.0].psi.unturned(g, at.placement.p);
                Placement { gamma: unturned, alpha: unturned, theta: unturned, p }
            }
            _ => Placement { theta: unturned, ..at.placement.clone() },
        };
        // Angular velocity of the link: w = w_0 + rate z. w_0 does not include the rates of the run's joints.
        let [x, y, z] = run.w;
        let own_w = [x, y, g.add(z, run.rate)];
        let (mut a, mut v) = match link.antecedent {
            None => {
                let before = if run.begins { at.placement.to_link_before_theta(g, weight) } else { weight };
                (axes[k].turn(g).turned(g, before), NULL)
            }
            Some(i) if begins => {
                let (offset, lever) =
                    (links[i.0].angular_motion.U.map(|row| dot(g, row, placement.p)), cross(g, w[i.0], placement.p));
                let (a, v) = (add(g, all[i.0].own_a, offset), add(g, all[i.0].own_v, lever));
                (placement.to_link(g, a), placement.to_link(g, v))
            }
            Some(i) => {
                let before = &all[i.0];
                let twice_w = before.w.map(|w| g.mul(scale, w));
                let (offset, lever) = (before.U.map(|row| dot(g, row, placement.p)), cross(g, twice_w, placement.p));
                (add(g, before.a, offset), add(g, before.v, lever))
            }
        };
        if link.joint.kind == JointKind::Prismatic {
            let [rate, scaled_rate] = [&motion.dq, rates].map(|x| joint_variable(g, link, x));
            let two = g.constant(2.0);
            let twice = g.mul(two, rate);
            let (wy, wx) = (g.mul(own_w[1], twice), g.mul(own_w[0], twice));
            a = [g.add(a[0], wy), g.sub(a[1], wx), g.add(a[2], at.joint_acceleration)];
            v[2] = g.add(v[2], scaled_rate);
        }
        let dw_z = g.add(run.dw_z, run.acceleration);
        let U = AngularMotion::new(g, run.bend, dw_z, |g, i, k| g.mul(own_w[i], own_w[k])).U;
        let (own_v, own_a) = (psi.turned(g, v), psi.turned(g, a));
        all.push(InRun { psi, begins, placement, w: own_w, a, U, v, own_v, own_a });
    }
    all
}

/// For each link, the angle of the axes of its run, relative to the first link of the run. The angle is zero except for a run
/// on the base, for which it is psi_last, the turn of the last link.
fn axes_of_runs(robot: &Robot, links: &[LinkMotion]) -> Vec<Angle> {
    // For each link, the first link of its run.
    let mut first: Vec<LinkId> = Vec::with_capacity(links.len());
    for k in robot.link_ids() {
        let before = robot.link(k).antecedent.filter(|_| !begins_run(robot, links, k));
        first.push(before.map_or(k, |i| first[i.0]));
    }
    let of = |k: LinkId| match robot.link(first[k.0]).antecedent {
        Some(_) => Angle::default(),
        None => robot
            .link_ids()
            .rev()
            .find(|m| first[m.0] == first[k.0])
            .map_or(Angle::default(), |last| links[last.0].parallel.turn.clone()),
    };
    robot.link_ids().map(of).collect()
}

/// Whether a link is the first link of a run: the link is on the base, or its axis is not parallel to the axis before it.
fn begins_run(robot: &Robot, links: &[LinkMotion], k: LinkId) -> bool {
    robot.link(k).antecedent.is_none() || links[k.0].parallel.begins
}

/// The composite body of every link (the link with all links that it carries), about the link's origin, in the axes of its run.
pub(crate) fn wholes(
    g: &mut Graph,
    robot: &Robot,
    links: &[LinkMotion],
    (runs, w): (&[InRun], &[Vector]),
    x: &ParameterInputs,
) -> Vec<CompositeBody> {
    // First, the bodies of each link are collected in the axes of this link: the link itself and, later, the runs that start on
    // it. The composite bodies are summed from the end links to the base, in the axes of the runs (consecutive links on
    // parallel axes).
    let mut own: Vec<CompositeBody> = Vec::with_capacity(links.len());
    for k in robot.link_ids() {
        let (run, body) = (&runs[k.0], RigidBody::new(x.body(k)));
        let moved = LinkMotion { a: run.own_a, ..links[k.0].clone() };
        let (f, n) = torque::wrench(g, &moved, x.body(k));
        own.push(CompositeBody { body, momenta: Momenta::new(g, body, w[k.0], run.own_v), wrench: [f, n] });
    }
    let mut beside: Vec<Option<CompositeBody>> = vec![None; links.len()];
    for k in robot.link_ids().rev() {
        let run = &runs[k.0];
        let turned = own[k.0].unturned(g, run.psi);
        let whole = beside[k.0].map_or(turned, |next| turned.plus(g, next));
        beside[k.0] = Some(whole);
        let Some(i) = robot.link(k).antecedent else { continue };
        let carried = whole.carried(g, &run.placement);
        if run.begins {
            own[i.0] = own[i.0].plus(g, carried);
        } else {
            beside[i.0] = Some(beside[i.0].map_or(carried, |sum| sum.plus(g, carried)));
        }
    }
    beside.into_iter().zip(own).map(|(whole, own)| whole.unwrap_or(own)).collect()
}
