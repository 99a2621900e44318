//! Composite bodies: each link together with all links that it carries, with their joints locked.
//!
//! ```text
//! J_i  += R J R^T + 2 (p . s) 1 - p s^T - s p^T + m (p . p 1 - p p^T)
//! MS_i += s + m p,   M_i += m,      s = R MS_j,  over the links j that i carries
//! ```
//! [Walker, Orin 1982], with R = R_ij, p = p_ij, J and MS about the frame origins.

use expr::{Expr, Graph};
use robot::Robot;

use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::kinematics::links::{LinkMotion, Placement};
use crate::kinematics::vector::{Vector, ZRotation, add, dot};

/// The inertial parameters of a rigid body in a link frame, about the origin of this frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidBody {
    /// Inertia matrix as xx, xy, xz, yy, yz, zz, kg m^2.
    pub inertia: [Expr; 6],
    pub first_moment: Vector,
    pub mass: Expr,
}

impl RigidBody {
    pub(crate) fn new([xx, xy, xz, yy, yz, zz, mx, my, mz, m]: [Expr; 10]) -> RigidBody {
        RigidBody { inertia: [xx, xy, xz, yy, yz, zz], first_moment: [mx, my, mz], mass: m }
    }

    pub(crate) fn plus(self, g: &mut Graph, b: RigidBody) -> RigidBody {
        RigidBody {
            inertia: std::array::from_fn(|i| g.add(self.inertia[i], b.inertia[i])),
            first_moment: add(g, self.first_moment, b.first_moment),
            mass: g.add(self.mass, b.mass),
        }
    }

    /// The parameters of the body in axes rotated back by `turn` about z.
    pub(crate) fn unturned(self, g: &mut Graph, turn: ZRotation) -> RigidBody {
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        // With c and s of the rotation: k = s (xx - yy) + 2 c xy; xx' = xx - s k, yy' = yy + s k, xy' = c k - xy. Half and
        // quarter turns only exchange entries.
        let (xx, xy, yy) = if turn.sin.is_zero() {
            (xx, xy, yy)
        } else if turn.cos.is_zero() {
            (yy, -xy, xx)
        } else {
            let two = g.constant(2.0);
            let (difference, twice) = (g.sub(xx, yy), g.mul(two, xy));
            let (a, b) = (g.mul(turn.sin, difference), g.mul(turn.cos, twice));
            let k = g.add(a, b);
            let (sk, ck) = (g.mul(turn.sin, k), g.mul(turn.cos, k));
            (g.sub(xx, sk), g.sub(ck, xy), g.add(yy, sk))
        };
        let [xz, yz, _] = turn.unturned(g, [xz, yz, Expr::ZERO]);
        RigidBody {
            inertia: [xx, xy, xz, yy, yz, zz],
            first_moment: turn.unturned(g, self.first_moment),
            mass: self.mass,
        }
    }

    /// The parameters of the body in axes rotated back by `turn` about x. The axes are permuted so that x becomes z, rotated
    /// about z, and permuted back.
    fn unturned_about_x(self, g: &mut Graph, turn: ZRotation) -> RigidBody {
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        let [x, y, z] = self.first_moment;
        let moved = RigidBody { inertia: [yy, yz, xy, zz, xz, xx], first_moment: [y, z, x], mass: self.mass };
        let back = moved.unturned(g, turn);
        let [yy, yz, xy, zz, xz, xx] = back.inertia;
        let [y, z, x] = back.first_moment;
        RigidBody { inertia: [xx, xy, xz, yy, yz, zz], first_moment: [x, y, z], mass: self.mass }
    }

    /// The parameters of the body about another origin; p is the vector from the new origin to the old one.
    fn moved(self, g: &mut Graph, p: Vector) -> RigidBody {
        let (s, m) = (self.first_moment, self.mass);
        let mp = p.map(|p| g.mul(m, p));
        // Uses 2 (p . s) + m p . p = p . (s + s + m p).
        let both: Vector = std::array::from_fn(|i| {
            let two = g.constant(2.0);
            let twice = g.mul(two, s[i]);
            g.add(twice, mp[i])
        });
        let products: Vector = std::array::from_fn(|i| g.mul(p[i], both[i]));
        let shifted: Vector = std::array::from_fn(|i| g.add(s[i], mp[i]));
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        let mut diagonal = |x: Expr, a: usize, b: usize| {
            let sum = g.add(products[a], products[b]);
            g.add(x, sum)
        };
        let (xx, yy, zz) = (diagonal(xx, 1, 2), diagonal(yy, 0, 2), diagonal(zz, 0, 1));
        // Products of inertia: - p_a s_b - s_a p_b - m p_a p_b.
        let mut product = |x: Expr, a: usize, b: usize| {
            let (u, v) = (g.mul(p[a], shifted[b]), g.mul(s[a], p[b]));
            let sum = g.add(u, v);
            g.sub(x, sum)
        };
        let (xy, xz, yz) = (product(xy, 0, 1), product(xz, 0, 2), product(yz, 1, 2));
        RigidBody { inertia: [xx, xy, xz, yy, yz, zz], first_moment: shifted, mass: m }
    }

    /// The parameters of the body in the frame of the antecedent, about the antecedent's origin. `placement`: pose of the link
    /// in the antecedent.
    pub(crate) fn carried(self, g: &mut Graph, placement: &Placement) -> RigidBody {
        let body = self.unturned(g, placement.theta);
        let body = body.unturned_about_x(g, placement.alpha);
        let body = body.unturned(g, placement.gamma);
        body.moved(g, placement.p)
    }

    /// Gives the parameters the names that Khalil uses for composite bodies: XXP3, MXP3, MP3.
    fn name(&self, g: &mut Graph, label: &str) {
        for (&e, letters) in self.inertia.iter().zip(["XX", "XY", "XZ", "YY", "YZ", "ZZ"]) {
            g.name(e, || format!("{letters}P{label}"));
        }
        for (&e, letters) in self.first_moment.iter().zip(["MX", "MY", "MZ"]) {
            g.name(e, || format!("{letters}P{label}"));
        }
        g.name(self.mass, || format!("MP{label}"));
    }

    /// The product J v of the inertia matrix J of the body and a vector.
    pub(crate) fn times(self, g: &mut Graph, v: Vector) -> Vector {
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]].map(|row| dot(g, row, v))
    }
}

/// The composite body of every link (the link with all links that it carries), in the frame of the link.
pub(crate) fn composites(g: &mut Graph, robot: &Robot, links: &[LinkMotion], x: &ParameterInputs) -> Vec<RigidBody> {
    let mut bodies: Vec<RigidBody> = robot.link_ids().map(|j| RigidBody::new(x.body(j))).collect();
    for j in robot.link_ids().rev() {
        bodies[j.0].name(g, &robot.link(j).label);
        if let Some(i) = robot.link(j).antecedent {
            let placement = &links[j.0].placement;
            let body = bodies[j.0].carried(g, placement);
            bodies[i.0] = bodies[i.0].plus(g, body);
        }
    }
    bodies
}
