//! The motion of links with the products of rates polarised: linear in reference rates, where they are squared else.
//!
//! What rates do to torques is a quadratic form Q(dq, dq), and the symmetric bilinear form behind it is C(q, dq) dq_r with
//! Christoffel's C [Slotine, Li 1987]. Every product w_a w_b on the way from rates to torques becomes
//!
//! ```text
//! 1/2 (w_a w_rb + w_ra w_b)
//! ```
//! with w_r the angular velocity at dq_r. Accelerations are those of ddq_r, and gravity stays as it is. The factor 1/2 is
//! taken to dq_r first: w_h = w_r / 2.

use expr::{Expr, Graph};
use robot::{JointKind, Robot};

use crate::kinematics::constants::Constants;
use crate::kinematics::links::{LinkMotion, Motion, joint_variable, link_motions};
use crate::kinematics::vector::{NULL, Vector, acceleration_matrix, add, dot};

/// The polarised motion of every link: `links` are those at dq, and `reference` has half of dq_r as its dq, and ddq_r as its
/// ddq.
pub(crate) fn polarised(
    g: &mut Graph,
    robot: &Robot,
    constants: &mut Constants,
    links: &[LinkMotion],
    reference: &Motion,
    actual: &Motion,
) -> Vec<LinkMotion> {
    let halves = link_motions(g, robot, constants, reference);
    let weight = constants.weight(g);
    // dw before the turns of a run of parallel axes.
    let mut run_dw: Vec<Vector> = Vec::new();
    let mut polar: Vec<LinkMotion> = Vec::new();
    for (j, link) in robot.links.iter().enumerate() {
        let (at, half) = (&links[j], &halves[j]);
        let i = link.antecedent.map(|i| i.0);
        let begins_run = at.placement.alpha.sin != Expr::ZERO || at.placement.alpha.cos != Expr::ONE;
        let dw_before = match (i, begins_run) {
            (None, _) => NULL,
            (Some(i), true) => at.placement.to_link_before_theta(g, polar[i].dw),
            (Some(i), false) => run_dw[i],
        };
        let turn = at.parallel.turn.turn(g);
        let [x, y, z] = turn.turned(g, dw_before);
        let [across_x, across_y] = across_z(g, [at.w, half.w], [at.parallel.rate, half.parallel.rate]);
        let dw = [g.add(x, across_x), g.add(y, across_y), g.add(z, half.parallel.acceleration)];

        let (a_i, offset) = match i {
            Some(i) => (polar[i].a, polar[i].U.map(|row| dot(g, row, at.placement.p))),
            None => (weight, NULL),
        };
        let at_o_j = add(g, a_i, offset);
        let mut a = at.placement.to_link(g, at_o_j);
        if link.joint.kind == JointKind::Prismatic {
            let rates = [actual, reference].map(|motion| joint_variable(g, link, &motion.dq));
            let [x, y] = across_z(g, [at.w, half.w], rates).map(|x| g.add(x, x));
            a = [g.add(a[0], x), g.add(a[1], y), g.add(a[2], half.joint_acceleration)];
        }
        let ww = products(g, at.w, half.w);
        let U = acceleration_matrix(g, &ww, dw);
        run_dw.push(dw_before);
        polar.push(LinkMotion { ww, dw, a, U, joint_acceleration: half.joint_acceleration, ..at.clone() });
    }
    polar
}

/// x and y of w x z rate, polarised.
fn across_z(g: &mut Graph, [w, half]: [Vector; 2], [rate, half_rate]: [Expr; 2]) -> [Expr; 2] {
    [1, 0].map(|axis: usize| {
        let (a, b) = (g.mul(w[axis], half_rate), g.mul(half[axis], rate));
        let sum = g.add(a, b);
        if axis == 1 { sum } else { -sum }
    })
}

/// w w_h^T + w_h w^T.
fn products(g: &mut Graph, w: Vector, half: Vector) -> [Vector; 3] {
    let mut entry = |i: usize, k: usize| {
        let (a, b) = (g.mul(w[i], half[k]), g.mul(half[i], w[k]));
        g.add(a, b)
    };
    let (xx, yy, zz) = (entry(0, 0), entry(1, 1), entry(2, 2));
    let (xy, xz, yz) = (entry(0, 1), entry(0, 2), entry(1, 2));
    [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
}
