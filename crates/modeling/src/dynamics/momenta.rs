//! Computes the momentum h of a rigid body and the first moment E of its momentum. From h and E follows the change of force and
//! moment when velocities change.
//!
//! Let r be the vector from O_j to a point of mass m, and v the velocity of this point. Summed over a body with first moment MS
//! and inertia matrix J,
//!
//! ```text
//! h = sum m v,   E = sum m r v^T = MS v_O^T + [w x S_a]_a,   S = 1/2 tr(J) 1 - J   (row a of S is S_a)
//! ```
//! A change of the angular velocity by W adds 2 B(W) to force and moment, where
//!
//! ```text
//! B(W) = (sum m W x v, sum m r x (W x v)) = (W x h, tr(E) W - E^T W)
//! ```
//! B is the factor of the Coriolis matrix for one body [Echeandia, Wensing 2021]. B is stored as 9 + 3 numbers (E and h)
//! instead of as a matrix of 36.

use expr::{Expr, Graph};
use robot::Robot;

use crate::dynamics::composite::RigidBody;
use crate::kinematics::links::{LinkMotion, Placement};
use crate::kinematics::vector::{NULL, Vector, ZRotation, add, cross};

/// Momentum h of a body, and the first moment E of its momentum about the origin of the link frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Momenta {
    pub h: Vector,
    /// The matrix E = sum m r v^T, row by row. r, v: position and velocity of a point of mass m.
    pub E: [Vector; 3],
}

impl Momenta {
    /// The momenta of a body with angular velocity w, in the body's frame. v: velocity of the origin of this frame.
    pub(crate) fn new(g: &mut Graph, body: RigidBody, w: Vector, v: Vector) -> Momenta {
        let [xx, xy, xz, yy, yz, zz] = body.inertia;
        let half = g.constant(0.5);
        let mut second = |a: Expr, b: Expr, c: Expr| {
            let sum = g.add(a, b);
            let sum = g.sub(sum, c);
            g.mul(half, sum)
        };
        let (sx, sy, sz) = (second(yy, zz, xx), second(xx, zz, yy), second(xx, yy, zz));
        let rows = [[sx, -xy, -xz], [-xy, sy, -yz], [-xz, -yz, sz]];
        let E = [0, 1, 2].map(|a| {
            let (turned, moved) = (cross(g, w, rows[a]), v.map(|v| g.mul(body.first_moment[a], v)));
            add(g, moved, turned)
        });
        let (turned, moved) = (cross(g, w, body.first_moment), v.map(|v| g.mul(body.mass, v)));
        Momenta { h: add(g, moved, turned), E }
    }

    /// The momenta in axes rotated back about z by `turn`.
    pub(crate) fn unturned(self, g: &mut Graph, turn: ZRotation) -> Momenta {
        let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = self.E;
        // c, s: cosine and sine of the rotation. With k = s (xx - yy) + c (xy + yx): xx' = xx - s k, yy' = yy + s k, xy' = c k -
        // yx, yx' = c k - xy.
        let (xx, xy, yx, yy) = if turn.sin.is_zero() {
            (xx, xy, yx, yy)
        } else if turn.cos.is_zero() {
            (yy, -yx, -xy, xx)
        } else {
            let (difference, sum) = (g.sub(xx, yy), g.add(xy, yx));
            let (a, b) = (g.mul(turn.sin, difference), g.mul(turn.cos, sum));
            let k = g.add(a, b);
            let (sk, ck) = (g.mul(turn.sin, k), g.mul(turn.cos, k));
            (g.sub(xx, sk), g.sub(ck, yx), g.sub(ck, xy), g.add(yy, sk))
        };
        let [xz, yz, _] = turn.unturned(g, [xz, yz, Expr::ZERO]);
        let [zx, zy, _] = turn.unturned(g, [zx, zy, Expr::ZERO]);
        Momenta { h: turn.unturned(g, self.h), E: [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] }
    }

    /// The momenta in axes rotated back about x by `turn`. The axes are permuted so that x becomes z, rotated about z, and
    /// permuted back.
    fn unturned_about_x(self, g: &mut Graph, turn: ZRotation) -> Momenta {
        let next = |v: Vector| [v[1], v[2], v[0]];
        let back = |v: Vector| [v[2], v[0], v[1]];
        let [x, y, z] = self.E.map(next);
        let turned = Momenta { h: next(self.h), E: [y, z, x] }.unturned(g, turn);
        let [y, z, x] = turned.E.map(back);
        Momenta { h: back(turned.h), E: [x, y, z] }
    }

    /// The momenta in the frame of the antecedent, about the antecedent's origin: E becomes E + p h^T; p: position of the link's
    /// origin in the antecedent. `placement`: pose of the link in the antecedent.
    pub(crate) fn carried(self, g: &mut Graph, placement: &Placement) -> Momenta {
        let turned = self.unturned(g, placement.theta);
        let turned = turned.unturned_about_x(g, placement.alpha);
        let turned = turned.unturned(g, placement.gamma);
        let moved = [0, 1, 2].map(|a| {
            let lever = turned.h.map(|h| g.mul(placement.p[a], h));
            add(g, turned.E[a], lever)
        });
        Momenta { h: turned.h, E: moved }
    }

    /// The momenta of two bodies together, about the same origin.
    pub(crate) fn plus(self, g: &mut Graph, b: Momenta) -> Momenta {
        Momenta { h: add(g, self.h, b.h), E: [0, 1, 2].map(|a| add(g, self.E[a], b.E[a])) }
    }

    /// Force and moment B(W) = (W x h, tr(E) W - E^T W). This is half of the change of force and moment when the angular
    /// velocity changes by W.
    pub(crate) fn times(&self, g: &mut Graph, W: Vector) -> (Vector, Vector) {
        let E = &self.E;
        let n = [0, 1, 2].map(|a| {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            let trace = g.add(E[b][b], E[c][c]);
            let terms = [g.mul(trace, W[a]), -g.mul(E[b][a], W[b]), -g.mul(E[c][a], W[c])];
            let sum = g.add(terms[0], terms[1]);
            g.add(sum, terms[2])
        });
        (cross(g, W, self.h), n)
    }

    /// The row u for which u . W is the moment of B(W) about z, or with `is_force` the force of B(W) along z. B(W): force and
    /// moment from a change W of the angular velocity.
    pub(crate) fn along_z(&self, g: &mut Graph, is_force: bool) -> Vector {
        let E = &self.E;
        if is_force { [self.h[1], -self.h[0], Expr::ZERO] } else { [-E[0][2], -E[1][2], g.add(E[0][0], E[1][1])] }
    }
}

/// The velocity of the origin of every link, in the link's frame, from the angular velocities w of all links and the rates dq.
pub(crate) fn velocities(g: &mut Graph, robot: &Robot, links: &[LinkMotion], w: &[Vector], dq: &[Expr]) -> Vec<Vector> {
    let mut velocities: Vec<Vector> = Vec::new();
    for (link, at) in robot.links.iter().zip(links) {
        let mut v = match link.antecedent {
            Some(i) => {
                let lever = cross(g, w[i.0], at.placement.p);
                let v = add(g, velocities[i.0], lever);
                at.placement.to_link(g, v)
            }
            None => NULL,
        };
        if link.joint.kind == robot::JointKind::Prismatic {
            let rate = crate::kinematics::links::joint_variable(g, link, dq);
            v[2] = g.add(v[2], rate);
        }
        velocities.push(v);
    }
    velocities
}
