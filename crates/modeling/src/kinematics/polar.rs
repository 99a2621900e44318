//! The motion of links with polarised products of rates: bilinear in rates and reference rates instead of quadratic in rates.
//!
//! The Coriolis and centrifugal torques are a quadratic form Q(dq, dq). The symmetric bilinear form of Q is C(q, dq) dq_r with
//! Christoffel's C [Slotine, Li 1987]. So every product w_a w_b of angular velocities in the computation of the torques is
//! replaced by
//!
//! ```text
//! 1/2 (w_a w_rb + w_ra w_b)
//! ```
//! where w_r is the angular velocity at dq_r. Accelerations follow from ddq_r, and gravity is unchanged. The factor 1/2 is
//! applied to dq_r: w_h = w_r / 2.

use expr::{Expr, Graph};
use robot::{JointKind, Robot};

use crate::kinematics::angular_motion::{AngularMotion, Bend};
use crate::kinematics::constants::Constants;
use crate::kinematics::links::{JointVariables, LinkMotion, joint_variable, link_motions};
use crate::kinematics::vector::{Vector, plus_dot};

/// The motion of every link with polarised products. `links`: motions at the rates dq; `reference`: joint variables whose dq is
/// half of the reference rates dq_r and whose ddq is ddq_r.
pub(crate) fn polarised(
    g: &mut Graph,
    robot: &Robot,
    constants: &mut Constants,
    links: &[LinkMotion],
    reference: &JointVariables,
    actual: &JointVariables,
) -> Vec<LinkMotion> {
    let halves = link_motions(g, robot, constants, reference);
    let weight = constants.weight(g);
    // For each link, before the joints of its run (consecutive links on parallel axes) turn: the second derivative of the axes
    // of the run, and the component of dw along these axes.
    let mut runs: Vec<(Bend, Expr)> = Vec::new();
    let mut polar: Vec<LinkMotion> = Vec::new();
    for (j, link) in robot.links.iter().enumerate() {
        let (at, half) = (&links[j], &halves[j]);
        let i = link.antecedent.map(|i| i.0);
        let begins_run = at.placement.alpha.sin != Expr::ZERO || at.placement.alpha.cos != Expr::ONE;
        let (bend, dw_z) = match i {
            None => (Bend::STILL, Expr::ZERO),
            Some(i) if begins_run => before_the_run(g, [at, half], &polar[i].angular_motion),
            Some(i) => runs[i],
        };
        runs.push((bend, dw_z));
        let turn = at.parallel.turn.turn(g);
        let (bend, dw_z) = (bend.turned(g, turn), g.add(dw_z, half.parallel.acceleration));
        let spin = AngularMotion::new(g, bend, dw_z, |g, r, c| product(g, [at.w, half.w], (r, c)));

        let at_o_j = match i {
            Some(i) => [0, 1, 2].map(|r| plus_dot(g, polar[i].a[r], polar[i].angular_motion.U[r], at.placement.p)),
            None => weight,
        };
        let mut a = at.placement.to_link(g, at_o_j);
        if link.joint.kind == JointKind::Prismatic {
            let rates = [actual, reference].map(|motion| joint_variable(g, link, &motion.dq));
            let [x, y] = across_z(g, [at.w, half.w], rates).map(|x| g.add(x, x));
            a = [g.add(a[0], x), g.add(a[1], y), g.add(a[2], half.joint_acceleration)];
        }
        polar.push(LinkMotion { angular_motion: spin, a, joint_acceleration: half.joint_acceleration, ..at.clone() });
    }
    polar
}

/// The second derivative of the first axis of a run, and the component of dw (angular acceleration) along this axis. `i`:
/// polarised motion of the link before the run; `at`, `half`: motion of this link at dq and at half of dq_r.
fn before_the_run(g: &mut Graph, [at, half]: [&LinkMotion; 2], i: &AngularMotion) -> (Bend, Expr) {
    let dw = at.placement.to_link_before_theta(g, i.dw);
    let bend = at.placement.bend(g, &i.U).unwrap_or_else(|| {
        let w = [at.parallel.w, half.parallel.w];
        let products = [product(g, w, (0, 2)), product(g, w, (1, 2))];
        Bend::of_rates(g, dw, products)
    });
    (bend, dw[2])
}

/// The x and y components of the cross product w x z rate, in polarised form: w x z half_rate + half x z rate. `half`,
/// `half_rate`: halves of the reference rates.
fn across_z(g: &mut Graph, [w, half]: [Vector; 2], [rate, half_rate]: [Expr; 2]) -> [Expr; 2] {
    [1, 0].map(|axis: usize| {
        let (a, b) = (g.mul(w[axis], half_rate), g.mul(half[axis], rate));
        let sum = g.add(a, b);
        if axis == 1 { sum } else { -sum }
    })
}

/// Entry (i, k) of the polarised product w w_h^T + w_h w^T; w_h: half of the reference angular velocity.
fn product(g: &mut Graph, [w, half]: [Vector; 2], (i, k): (usize, usize)) -> Expr {
    let (a, b) = (g.mul(w[i], half[k]), g.mul(half[i], w[k]));
    g.add(a, b)
}
