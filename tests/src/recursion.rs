//! Computes joint torques by the Newton-Euler recursion, in the base frame.
//!
//! ```text
//! outward   w_j = w_i + z_j dr            dw_j = dw_i + z_j ddr + w_i x z_j dr           (revolute)
//!           a_j = a_i + dw_i x l + w_i x (w_i x l)  [+ z_j ddr + 2 w_i x z_j dr]          (prismatic)
//! of a link f_j = m a_j + dw_j x s_j + w_j x (w_j x s_j)
//!           n_j = J_j dw_j + w_j x J_j w_j + s_j x a_j                     about the origin O_j
//! inward    f_c, n_c of each child link c are added, and (O_c - O_j) x f_c
//! ```
//! w_j, dw_j, a_j: angular velocity, angular acceleration, and acceleration of the origin O_j of link j; index i: parent link;
//! z_j, r: axis and variable of the joint; f_j, n_j: force and moment; m, s_j, J_j: mass, first moment and inertia;
//! l = O_j - O_i. Gravity is included as the acceleration -g of the base. The torque of a coordinate is the sum over all joints
//! of the joint torque times the derivative of the joint variable by the coordinate [Luh, Walker, Paul 1980].

use robot::{JointKind, Robot};

use crate::by_link;
use crate::number::Number;
use crate::pose::{
    BASE, Frame, Vector, constants, cross, inertia_times, inner, joint_rates, joint_variables, scaled, sum, turned,
};
use crate::random::State;

#[derive(Clone, Copy)]
struct Motion {
    frame: Frame,
    w: Vector,
    dw: Vector,
    a: Vector,
}

/// The joint torques at a state, N m (N). `x`: standard parameters.
pub fn torque(robot: &Robot, state: &State, x: &[f64]) -> Vec<f64> {
    let lift = |v: &[f64]| v.iter().map(|&x| Number::constant(x)).collect::<Vec<_>>();
    let variables = joint_variables(robot, &lift(&state.q));
    let (rates, accelerations) = (joint_rates(robot, &lift(&state.dq)), joint_rates(robot, &lift(&state.ddq)));
    let parameters = by_link(robot, x);

    let zero = constants([0.0; 3]);
    let lifted_gravity = constants(robot.gravity_number().map(|g| -g));
    let base = Motion { frame: BASE, w: zero, dw: zero, a: lifted_gravity };
    let mut motions: Vec<Motion> = Vec::new();
    for (j, link) in robot.links.iter().enumerate() {
        let i = link.antecedent.map_or(base, |i| motions[i.0]);
        let frame = i.frame.placed(robot, &link.geometry, link.joint.kind, variables[j]);
        let (z, dr, ddr) = (frame.axis(), rates[j], accelerations[j]);
        let minus = |v: Vector| v.map(|x| -x);
        let lever = sum(frame.origin, minus(i.frame.origin));
        let (mut w, mut dw) = (i.w, i.dw);
        let mut a = sum(i.a, sum(cross(i.dw, lever), cross(i.w, cross(i.w, lever))));
        match link.joint.kind {
            JointKind::Revolute => {
                w = sum(w, scaled(z, dr));
                dw = sum(dw, sum(scaled(z, ddr), cross(i.w, scaled(z, dr))));
            }
            JointKind::Prismatic => {
                let coriolis = cross(i.w, scaled(z, dr));
                a = sum(a, sum(scaled(z, ddr), sum(coriolis, coriolis)));
            }
            JointKind::Fixed => {}
        }
        motions.push(Motion { frame, w, dw, a });
    }

    let mut tau = vec![0.0; robot.n_coordinates()];
    let mut wrenches: Vec<(Vector, Vector)> =
        motions.iter().zip(&parameters).map(|(motion, (body, _))| wrench(motion, body)).collect();
    for (j, link) in robot.links.iter().enumerate().rev() {
        let (f, n) = wrenches[j];
        let z = motions[j].frame.axis();
        let along = match link.joint.kind {
            JointKind::Revolute => inner(n, z),
            JointKind::Prismatic => inner(f, z),
            JointKind::Fixed => Number::ZERO,
        };
        let rotor = parameters[j].1 * accelerations[j].value;
        for &(k, c) in &link.joint.variable.terms {
            tau[k.0] += c * (along.value + rotor);
        }
        if let Some(i) = link.antecedent {
            let lever = sum(motions[j].frame.origin, motions[i.0].frame.origin.map(|x| -x));
            let carried = sum(n, cross(lever, f));
            wrenches[i.0] = (sum(wrenches[i.0].0, f), sum(wrenches[i.0].1, carried));
        }
    }
    tau
}

/// Force, and moment about the origin of the link, that cause the motion of a body: m a + dw x s + w x (w x s),
/// and J dw + w x J w + s x a.
fn wrench(motion: &Motion, body: &[f64; 10]) -> (Vector, Vector) {
    let Motion { frame, w, dw, a } = *motion;
    let s = turned(&frame.rotation, constants([body[6], body[7], body[8]]));
    let f = sum(scaled(a, Number::constant(body[9])), sum(cross(dw, s), cross(w, cross(w, s))));
    let inertia = |v: Vector| inertia_times(&frame.rotation, body, v);
    (f, sum(inertia(dw), sum(cross(w, inertia(w)), cross(s, a))))
}
