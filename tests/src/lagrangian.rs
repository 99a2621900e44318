//! Computes the energies of a robot, and its joint torques as derivatives of the Lagrangian.
//!
//! ```text
//! T = sum_j  m v.v / 2 + v . (w x s) + w . J w / 2 + IA dr^2 / 2      v = dO_j/dt
//! U = - sum_j g . (m O_j + s)
//! tau = d/dt dT/d(dq) - d(T - U)/dq
//! ```
//! T, U: kinetic and potential energy; m, s, J: mass, first moment and inertia of link j; v, w: velocity of the link origin O_j
//! and angular velocity; IA: rotor inertia; r: joint position. Velocities follow from the poses by the chain rule, without
//! accelerations or forces. The derivatives are computed with [`Number`] (hyper-dual numbers), exact up to rounding.

use robot::{JointKind, Robot};

use crate::by_link;
use crate::number::Number;
use crate::pose::{
    BASE, Frame, Vector, constants, cross, inertia_times, inner, joint_rates, joint_variables, scaled, sum, turned,
};
use crate::random::State;

/// Kinetic and potential energy at the positions q and velocities dq, J. `x`: standard parameters.
pub fn energies(robot: &Robot, q: &[Number], dq: &[Number], x: &[f64]) -> (Number, Number) {
    let (variables, rates) = (joint_variables(robot, q), joint_rates(robot, dq));
    let gravity = constants(robot.gravity_number());
    let half = Number::constant(0.5);
    let zero = constants([0.0; 3]);
    let (mut kinetic, mut potential) = (Number::ZERO, Number::ZERO);
    let mut motions: Vec<(Frame, Vector, Vector)> = Vec::new();
    for (j, (link, (body, rotor))) in robot.links.iter().zip(by_link(robot, x)).enumerate() {
        let (before, w_i, v_i) = link.antecedent.map_or((BASE, zero, zero), |i| motions[i.0]);
        let frame = before.placed(robot, &link.geometry, link.joint.kind, variables[j]);
        let along = scaled(frame.axis(), rates[j]);
        let lever = sum(frame.origin, before.origin.map(|x| -x));
        let carried = sum(v_i, cross(w_i, lever));
        let (w, v) = match link.joint.kind {
            JointKind::Revolute => (sum(w_i, along), carried),
            JointKind::Prismatic => (w_i, sum(carried, along)),
            JointKind::Fixed => (w_i, carried),
        };
        let m = Number::constant(body[9]);
        let s = turned(&frame.rotation, constants([body[6], body[7], body[8]]));
        let turning = inner(w, inertia_times(&frame.rotation, &body, w));
        let rotor = Number::constant(rotor) * rates[j] * rates[j];
        kinetic = kinetic + half * (m * inner(v, v) + turning + rotor) + inner(v, cross(w, s));
        potential = potential - inner(gravity, sum(scaled(frame.origin, m), s));
        motions.push((frame, w, v));
    }
    (kinetic, potential)
}

/// The joint torques at a state, N m (N). `x`: standard parameters.
pub fn torque(robot: &Robot, state: &State, x: &[f64]) -> Vec<f64> {
    let one_hot = |i: usize, k: usize| if i == k { 1.0 } else { 0.0 };
    let of_coordinate = |k: usize| {
        // Each number carries derivatives in two directions: the first is the derivative by dq_k, the second the derivative by
        // time.
        let number = |value: f64, d1: f64, d2: f64| Number { value, d1, d2, d12: 0.0 };
        let n = state.q.len();
        let q: Vec<Number> = (0..n).map(|i| number(state.q[i], 0.0, state.dq[i])).collect();
        let dq: Vec<Number> = (0..n).map(|i| number(state.dq[i], one_hot(i, k), state.ddq[i])).collect();
        let momentum_rate = energies(robot, &q, &dq, x).0.d12;

        let q: Vec<Number> = (0..n).map(|i| number(state.q[i], one_hot(i, k), 0.0)).collect();
        let dq: Vec<Number> = state.dq.iter().map(|&v| Number::constant(v)).collect();
        let (kinetic, potential) = energies(robot, &q, &dq, x);
        momentum_rate - (kinetic.d1 - potential.d1)
    };
    (0..state.q.len()).map(of_coordinate).collect()
}

/// The derivative of the total energy, d(T + U)/dt, along the motion, W. It is the power that the joints must supply.
pub fn power(robot: &Robot, state: &State, x: &[f64]) -> f64 {
    let moving = |value: &[f64], rate: &[f64]| -> Vec<Number> {
        value.iter().zip(rate).map(|(&value, &d1)| Number { value, d1, d2: 0.0, d12: 0.0 }).collect()
    };
    let (kinetic, potential) = energies(robot, &moving(&state.q, &state.dq), &moving(&state.dq, &state.ddq), x);
    kinetic.d1 + potential.d1
}
