//! Solves for the last two unknown variables of a planar loop in a finite field.
//!
//! If all variables except two are known, the sides of a loop form groups: the sides of a group turn with the same combination of
//! the unknown angles. The sum of all groups is zero. The unknown variables are
//!
//! - two angles, three groups: a triangle of known sides, v_0 + v_1 exp(i psi_1) + v_2 exp(i psi_2) = 0. v_k: sum of group k;
//!   psi_k: unknown angle of group k relative to group 0. From |v_0 + v_1 exp(i psi_1)|^2 = |v_2|^2 follows a cos psi_1 + b sin
//!   psi_1 = c;
//! - one angle, one length s, two groups a_k + s u_k: |a_0 + s u_0|^2 = |a_1 + s u_1|^2, quadratic in s;
//! - two lengths: linear.

use crate::base::closed::variables::{State, on_the_circle, quotient, raised};
use crate::base::field::{CirclePoint, Residue, solve, turned as sum};

/// A vector in the plane of a loop, with entries in the finite field.
pub(crate) type Flat = [Residue; 2];

/// The result of an attempt to close a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Closing {
    Closed,
    /// The equations have no roots in the finite field.
    NoRoot,
    /// The equations for the chosen variables have none of the forms for which there is a solution method.
    OtherForm,
}

/// A group of sides of a planar loop that turn with the same combination of the unknown angles. The sum of the sides is (vector
/// + sum of lengths times per_length) exp(i turn . angles).
pub(crate) struct PlanarGroup {
    pub turn: Vec<i128>,
    pub vector: Flat,
    pub per_length: Vec<Flat>,
}

impl PlanarGroup {
    pub(crate) fn vanishes(&self) -> bool {
        let zero = [Residue::ZERO; 2];
        self.vector == zero && self.per_length.iter().all(|v| *v == zero)
    }
}

/// Solves for two unknown angles x and y so that the sum of three groups of sides is zero.
pub(crate) fn triangle(state: &mut State, groups: &[PlanarGroup], [x, y]: [usize; 2], other_root: bool) -> Closing {
    let [g0, g1, g2] = groups else { return Closing::OtherForm };
    let difference = |g: &PlanarGroup| [g.turn[0] - g0.turn[0], g.turn[1] - g0.turn[1]];
    let ([a, b], [c, d]) = (difference(g1), difference(g2));
    let determinant = a * d - b * c;
    if determinant.abs() != 1 {
        return Closing::OtherForm;
    }
    // With psi = psi_1: |v0|^2 + |v1|^2 + 2 Re(conj(v0) v1 exp(i psi)) = |v2|^2.
    let square = |v: Flat| v[0] * v[0] + v[1] * v[1];
    let (v0, v1, v2) = (g0.vector, g1.vector, g2.vector);
    let [re, im] = [v0[0] * v1[0] + v0[1] * v1[1], v0[0] * v1[1] - v0[1] * v1[0]];
    let two = Residue::integer(2);
    let k = square(v2) - square(v0) - square(v1);
    let Some(first) = on_the_circle(two * re, -(two * im), k, other_root) else { return Closing::NoRoot };
    let third = plus(v0, rotated(first, v1)).map(|x| -x);
    let Some(second) = quotient(third, v2) else { return Closing::NoRoot };
    let second = (second[0], second[1]);
    // The angles are psi = M (x, y), so (x, y) = M^-1 psi with M^-1 = [d -b; -c a] / determinant.
    let angle = |p: i128, q: i128| sum(raised(first, p * determinant), raised(second, q * determinant));
    state.set_angle(x, angle(d, -b));
    state.set_angle(y, angle(-c, a));
    Closing::Closed
}

/// Solves for one unknown angle x and one unknown length s so that the sum of two groups of sides is zero; s solves
/// a s^2 + b s + c = 0.
pub(crate) fn slide(state: &mut State, groups: &[PlanarGroup], x: usize, s: usize, other_root: bool) -> Closing {
    let [g0, g1] = groups else { return Closing::OtherForm };
    let turn = g1.turn[0] - g0.turn[0];
    if turn.abs() != 1 {
        return Closing::OtherForm;
    }
    let inner = |a: Flat, b: Flat| a[0] * b[0] + a[1] * b[1];
    let square_difference = |a: Flat, b: Flat| inner(a, a) - inner(b, b);
    let (a0, u0, a1, u1) = (g0.vector, g0.per_length[0], g1.vector, g1.per_length[0]);
    let (two, four) = (Residue::integer(2), Residue::integer(4));
    let (a, b, c) = (square_difference(u0, u1), two * (inner(a0, u0) - inner(a1, u1)), square_difference(a0, a1));
    let length = if a == Residue::ZERO {
        if b == Residue::ZERO {
            return Closing::OtherForm;
        }
        -(c * b.inverse())
    } else {
        let Some(root) = (b * b - four * a * c).root() else { return Closing::NoRoot };
        let root = if other_root { -root } else { root };
        (root - b) * (two * a).inverse()
    };
    let end = |a: Flat, u: Flat| plus(a, u.map(|u| u * length));
    let Some(z) = quotient(end(a0, u0).map(|x| -x), end(a1, u1)) else { return Closing::NoRoot };
    state.set_angle(x, raised((z[0], z[1]), turn));
    state.set_length(s, length);
    Closing::Closed
}

/// Solves for two unknown lengths s and t so that one group of sides is zero; this gives two linear equations.
pub(crate) fn two_slides(state: &mut State, groups: &[PlanarGroup], [s, t]: [usize; 2]) -> Closing {
    let [g] = groups else { return Closing::OtherForm };
    let row = |i: usize| vec![g.per_length[0][i], g.per_length[1][i], -g.vector[i]];
    let Some(x) = solve(vec![row(0), row(1)], 2) else { return Closing::OtherForm };
    state.set_length(s, x[0]);
    state.set_length(t, x[1]);
    Closing::Closed
}

pub(crate) fn plus(a: Flat, b: Flat) -> Flat {
    [a[0] + b[0], a[1] + b[1]]
}

pub(crate) fn rotated((c, s): CirclePoint, [x, y]: Flat) -> Flat {
    [c * x - s * y, s * x + c * y]
}
