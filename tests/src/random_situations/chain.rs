//! A tree of rigid bodies. Its torques are computed by Newton-Euler, and its energy, in plain f64 in the base frame.
//!
//! ```text
//! outward   w = w_i + a dq,  dw = dw_i + a ddq + w_i x a dq         (revolute; a: axis in the base frame)
//!           p = p_i + R_i o + a q,  acceleration with 2 w_i x a dq  (prismatic)
//! of a body F = m c'',  N = I dw + w x I w  about its centre of mass c
//! inward    the wrenches of the child links are added, with their lever arms
//! ```
//! w, dw: angular velocity and acceleration of a link, index i: of its parent; p: origin of the link; R_i: rotation of the
//! parent; o: origin in the frame of the parent. Gravity is included as the acceleration -g of the base [Luh, Walker, Paul 1980].
//! Frames are as in a URDF: a fixed placement, then the motion along an axis. This file uses no code of rist. It also uses no
//! code of `recursion`, whose frames are as in rist.

pub type Vector = [f64; 3];
/// A 3 x 3 matrix, row by row.
pub type Matrix = [Vector; 3];

pub const UNIT: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Gravity in a URDF, m/s^2.
pub const GRAVITY: Vector = [0.0, 0.0, -9.81];

/// A rigid body, in the frame of its link.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the frame of the link, m.
    pub centre: Vector,
    /// Inertia about the centre of mass, kg m^2.
    pub inertia: Matrix,
}

/// A link, and the joint that connects it to its parent.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Index of the parent link; `None`: the base.
    pub parent: Option<usize>,
    pub rotation: Matrix,
    /// Origin of the link frame in the frame of the parent link, m.
    pub origin: Vector,
    /// Joint axis: a unit vector in the frame of the link.
    pub axis: Vector,
    pub slides: bool,
    pub body: Body,
    /// Inertia of the motor as seen from the joint, kg m^2 (kg).
    pub rotor: f64,
    /// Largest magnitude of the position, rad (m). `speed`: of the velocity, rad/s (m/s). `effort`: of the torque, N m (N).
    pub range: f64,
    pub speed: f64,
    pub effort: f64,
}

/// The tree of links. A parent comes before its children.
#[derive(Clone, Debug)]
pub struct Chain {
    pub joints: Vec<Joint>,
    pub gravity: Vector,
}

pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn inner(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn plus(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub fn times(a: Vector, s: f64) -> Vector {
    a.map(|x| x * s)
}

pub fn turned(m: &Matrix, v: Vector) -> Vector {
    m.map(|row| inner(row, v))
}

pub fn transposed(m: &Matrix) -> Matrix {
    [0, 1, 2].map(|i| [m[0][i], m[1][i], m[2][i]])
}

pub fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let columns = transposed(b);
    a.map(|row| columns.map(|column| inner(row, column)))
}

/// The matrix of the rotation by `angle`, rad, about a unit vector (Rodrigues' formula).
pub fn about(axis: Vector, angle: f64) -> Matrix {
    let (s, c) = angle.sin_cos();
    let [x, y, z] = axis;
    let v = 1.0 - c;
    [
        [c + x * x * v, x * y * v - z * s, x * z * v + y * s],
        [y * x * v + z * s, c + y * y * v, y * z * v - x * s],
        [z * x * v - y * s, z * y * v + x * s, c + z * z * v],
    ]
}

#[derive(Clone, Copy)]
struct Moving {
    rotation: Matrix,
    origin: Vector,
    axis: Vector,
    w: Vector,
    dw: Vector,
    velocity: Vector,
    acceleration: Vector,
}

impl Chain {
    pub fn len(&self) -> usize {
        self.joints.len()
    }

    pub fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    fn moving(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<Moving> {
        let zero = [0.0; 3];
        let lifted = times(self.gravity, -1.0);
        let (rotation, axis) = (UNIT, zero);
        let base = Moving { rotation, origin: zero, axis, w: zero, dw: zero, velocity: zero, acceleration: lifted };
        let mut links: Vec<Moving> = Vec::with_capacity(self.len());
        for (k, joint) in self.joints.iter().enumerate() {
            let i = joint.parent.map_or(base, |i| links[i]);
            let placed = product(&i.rotation, &joint.rotation);
            let axis = turned(&placed, joint.axis);
            let mut lever = turned(&i.rotation, joint.origin);
            let (mut rotation, mut w, mut dw) = (placed, i.w, i.dw);
            let (mut velocity, mut acceleration) = (i.velocity, i.acceleration);
            if joint.slides {
                lever = plus(lever, times(axis, q[k]));
                velocity = plus(velocity, times(axis, dq[k]));
                let coriolis = times(cross(i.w, axis), 2.0 * dq[k]);
                acceleration = plus(acceleration, plus(times(axis, ddq[k]), coriolis));
            } else {
                rotation = product(&placed, &about(joint.axis, q[k]));
                w = plus(w, times(axis, dq[k]));
                dw = plus(dw, plus(times(axis, ddq[k]), times(cross(i.w, axis), dq[k])));
            }
            velocity = plus(velocity, cross(i.w, lever));
            acceleration = plus(acceleration, plus(cross(i.dw, lever), cross(i.w, cross(i.w, lever))));
            links.push(Moving { rotation, origin: plus(i.origin, lever), axis, w, dw, velocity, acceleration });
        }
        links
    }

    /// The joint torques that move the bodies, without the torques of the rotors, N m (N).
    pub fn torque(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<f64> {
        let links = self.moving(q, dq, ddq);
        let mut wrenches: Vec<(Vector, Vector)> =
            links.iter().zip(&self.joints).map(|(l, j)| wrench(l, &j.body)).collect();
        let mut tau = vec![0.0; self.len()];
        for (k, joint) in self.joints.iter().enumerate().rev() {
            let (f, n) = wrenches[k];
            tau[k] = inner(links[k].axis, if joint.slides { f } else { n });
            if let Some(i) = joint.parent {
                let lever = plus(links[k].origin, times(links[i].origin, -1.0));
                let carried = plus(n, cross(lever, f));
                wrenches[i] = (plus(wrenches[i].0, f), plus(wrenches[i].1, carried));
            }
        }
        tau
    }

    /// Kinetic and potential energy of the bodies, without rotors, J.
    pub fn energy(&self, q: &[f64], dq: &[f64]) -> (f64, f64) {
        let links = self.moving(q, dq, &vec![0.0; self.len()]);
        let (mut kinetic, mut potential) = (0.0, 0.0);
        for (link, joint) in links.iter().zip(&self.joints) {
            let body = &joint.body;
            let s = turned(&link.rotation, body.centre);
            let v = plus(link.velocity, cross(link.w, s));
            let w = turned(&transposed(&link.rotation), link.w);
            kinetic += 0.5 * (body.mass * inner(v, v) + inner(w, turned(&body.inertia, w)));
            potential -= body.mass * inner(self.gravity, plus(link.origin, s));
        }
        (kinetic, potential)
    }

    /// Diagonal of the inertia matrix of the bodies without the rotors.
    pub fn own_inertia(&self, q: &[f64]) -> Vec<f64> {
        let zero = vec![0.0; self.len()];
        let still = self.torque(q, &zero, &zero);
        let of = |k: usize| {
            let mut ddq = zero.clone();
            ddq[k] = 1.0;
            self.torque(q, &zero, &ddq)[k] - still[k]
        };
        (0..self.len()).map(of).collect()
    }

    /// The tree with a point mass added to the last link. `place`: its position in the frame of the link, m.
    pub fn loaded(&self, mass: f64, place: Vector) -> Chain {
        let mut chain = self.clone();
        if let Some(last) = chain.joints.last_mut() {
            last.body = last.body.with_point(mass, place);
        }
        chain
    }
}

impl Body {
    /// The body with a point mass added to it.
    pub fn with_point(&self, mass: f64, place: Vector) -> Body {
        let total = self.mass + mass;
        let centre = times(plus(times(self.centre, self.mass), times(place, mass)), 1.0 / total);
        let away = plus(place, times(self.centre, -1.0));
        let (reduced, square) = (self.mass * mass / total, inner(away, away));
        let mut inertia = self.inertia;
        for i in 0..3 {
            for j in 0..3 {
                inertia[i][j] += reduced * (if i == j { square } else { 0.0 } - away[i] * away[j]);
            }
        }
        Body { mass: total, centre, inertia }
    }
}

/// Force, and moment about the origin of the link, that cause the motion of a body.
fn wrench(link: &Moving, body: &Body) -> (Vector, Vector) {
    let s = turned(&link.rotation, body.centre);
    let of_centre = plus(link.acceleration, plus(cross(link.dw, s), cross(link.w, cross(link.w, s))));
    let force = times(of_centre, body.mass);
    let local = transposed(&link.rotation);
    let inertia = |v: Vector| turned(&link.rotation, turned(&body.inertia, turned(&local, v)));
    let moment = plus(inertia(link.dw), cross(link.w, inertia(link.w)));
    (force, plus(moment, cross(s, force)))
}
