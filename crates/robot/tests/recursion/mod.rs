//! Joint torques of a tree of links by a Newton-Euler recursion, with all vectors in the base frame.
//!
//! Only link poses, link parameters and joint axes are taken from the program under test. So the torques test the rest of the
//! program independently.

use robot::{Inertial, JointKind, Robot};

type Vector = [f64; 3];

fn plus(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|i| a[i] + b[i])
}

fn times(a: Vector, x: f64) -> Vector {
    a.map(|a| a * x)
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Vector, b: Vector) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

/// Joint torques tau(q, dq, ddq), N m (N), including the rotor inertias.
pub(crate) fn torque(robot: &Robot, q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<f64> {
    let poses = robot.link_poses(q);
    let gravity = robot.gravity_number().map(|g| -g);
    // For each link: angular velocity w, its rate dw, and acceleration a of its origin, in the base frame.
    let mut motions: Vec<[Vector; 3]> = Vec::new();
    let mut wrenches: Vec<[Vector; 2]> = Vec::new();
    let axis = |j: usize| poses[j].rotation.map(|row| row[2]);
    for (j, link) in robot.links.iter().enumerate() {
        let (rate, acceleration) = (link.joint.variable.rate(dq), link.joint.variable.rate(ddq));
        let ([w, dw, a], origin) = match link.antecedent {
            Some(i) => (motions[i.0], poses[i.0].position),
            None => ([[0.0; 3], [0.0; 3], gravity], [0.0; 3]),
        };
        let lever = plus(poses[j].position, times(origin, -1.0));
        let z = axis(j);
        let mut a = plus(a, plus(cross(dw, lever), cross(w, cross(w, lever))));
        let (mut w, mut dw) = (w, dw);
        match link.joint.kind {
            JointKind::Revolute => {
                dw = plus(dw, plus(times(z, acceleration), cross(w, times(z, rate))));
                w = plus(w, times(z, rate));
            }
            JointKind::Prismatic => a = plus(a, plus(times(z, acceleration), times(cross(w, z), 2.0 * rate))),
            JointKind::Fixed => {}
        }
        motions.push([w, dw, a]);
        wrenches.push(wrench(&link.inertial.unwrap_or_default(), &poses[j].rotation, [w, dw, a]));
    }
    let mut tau = vec![0.0; dq.len()];
    for (j, link) in robot.links.iter().enumerate().rev() {
        let [f, n] = wrenches[j];
        let along = match link.joint.kind {
            JointKind::Revolute => dot(axis(j), n),
            JointKind::Prismatic => dot(axis(j), f),
            JointKind::Fixed => 0.0,
        };
        let rotor = robot::StandardParameter { link: robot::LinkId(j), inertial: Inertial::Ia };
        let rotor = rotor.value(robot).unwrap_or(0.0) * link.joint.variable.rate(ddq);
        for &(k, c) in &link.joint.variable.terms {
            tau[k.0] += c * (along + rotor);
        }
        if let Some(i) = link.antecedent {
            let lever = plus(poses[j].position, times(poses[i.0].position, -1.0));
            let [before_f, before_n] = wrenches[i.0];
            wrenches[i.0] = [plus(before_f, f), plus(before_n, plus(n, cross(lever, f)))];
        }
    }
    tau
}

/// Force, and moment about the origin of a link, for the motion (w, dw, a). `x`: XX .. M in the axes of the link.
fn wrench(x: &[f64; 10], r: &[[f64; 3]; 3], [w, dw, a]: [Vector; 3]) -> [Vector; 2] {
    let out = |v: Vector| [0, 1, 2].map(|i| dot(r[i], v));
    let into = |v: Vector| [0, 1, 2].map(|k| r[0][k] * v[0] + r[1][k] * v[1] + r[2][k] * v[2]);
    let inertia = |v: Vector| {
        let [vx, vy, vz] = into(v);
        let [xx, xy, xz, yy, yz, zz] = [x[0], x[1], x[2], x[3], x[4], x[5]];
        out([xx * vx + xy * vy + xz * vz, xy * vx + yy * vy + yz * vz, xz * vx + yz * vy + zz * vz])
    };
    let (s, m) = (out([x[6], x[7], x[8]]), x[9]);
    let f = plus(times(a, m), plus(cross(dw, s), cross(w, cross(w, s))));
    let n = plus(inertia(dw), plus(cross(w, inertia(w)), cross(s, a)));
    [f, n]
}
