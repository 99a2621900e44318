//! Vectors with three components that are expressions, and rotations about one axis.

use expr::{Expr, Graph};

/// A vector of three expressions.
pub type Vector = [Expr; 3];

/// The zero vector.
pub const NULL: Vector = [Expr::ZERO; 3];

/// The sum a + b.
pub fn add(g: &mut Graph, a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|i| g.add(a[i], b[i]))
}

/// The cross product a x b.
pub fn cross(g: &mut Graph, a: Vector, b: Vector) -> Vector {
    let mut minor = |i: usize, j: usize| {
        let (x, y) = (g.mul(a[i], b[j]), g.mul(a[j], b[i]));
        g.sub(x, y)
    };
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

/// The sum c + a x b, added one product at a time.
pub(crate) fn plus_cross(g: &mut Graph, c: Vector, a: Vector, b: Vector) -> Vector {
    [(0, 1, 2), (1, 2, 0), (2, 0, 1)].map(|(i, j, k)| {
        let (plus, minus) = (g.mul(a[j], b[k]), g.mul(a[k], b[j]));
        let sum = g.add(c[i], plus);
        g.sub(sum, minus)
    })
}

/// The dot product a . b.
pub fn dot(g: &mut Graph, a: Vector, b: Vector) -> Expr {
    plus_dot(g, Expr::ZERO, a, b)
}

/// The sum c + a . b, added one product at a time, so that each product can be fused with the sum before it (fused multiply-add).
pub(crate) fn plus_dot(g: &mut Graph, c: Expr, a: Vector, b: Vector) -> Expr {
    let terms = [0, 1, 2].map(|i| g.mul(a[i], b[i]));
    terms.iter().fold(c, |s, &t| g.add(s, t))
}

pub(crate) fn sum(g: &mut Graph, terms: &[Expr]) -> Expr {
    terms.iter().fold(Expr::ZERO, |s, &t| g.add(s, t))
}

/// Names the components of a vector NAME_x, NAME_y, NAME_z in formulas, if the graph keeps names.
pub(crate) fn name_vector(g: &mut Graph, v: Vector, name: impl Fn() -> String) {
    for (component, axis) in v.into_iter().zip(["x", "y", "z"]) {
        g.name(component, || format!("{}_{axis}", name()));
    }
}

/// A rotation about z by an angle. The methods with `about_x` in their names use the same angle for a rotation about x.
#[derive(Clone, Copy, Debug)]
pub struct ZRotation {
    /// The cosine of the angle.
    pub cos: Expr,
    /// The sine of the angle.
    pub sin: Expr,
}

impl ZRotation {
    /// Components of a fixed vector in axes rotated about z by the angle: Rz(-angle) v.
    pub fn turned(self, g: &mut Graph, v: Vector) -> Vector {
        let [x, y, z] = v;
        let (cx, sy, cy, sx) = (g.mul(self.cos, x), g.mul(self.sin, y), g.mul(self.cos, y), g.mul(self.sin, x));
        [g.add(cx, sy), g.sub(cy, sx), z]
    }

    /// The inverse of [`ZRotation::turned`]: Rz(angle) v.
    pub fn unturned(self, g: &mut Graph, v: Vector) -> Vector {
        ZRotation { cos: self.cos, sin: -self.sin }.turned(g, v)
    }

    /// Components of a fixed vector in axes rotated about x by the angle: Rx(-angle) v.
    pub fn turned_about_x(self, g: &mut Graph, v: Vector) -> Vector {
        let [y, z, x] = self.turned(g, [v[1], v[2], v[0]]);
        [x, y, z]
    }

    /// The inverse of [`ZRotation::turned_about_x`]: Rx(angle) v.
    pub fn unturned_about_x(self, g: &mut Graph, v: Vector) -> Vector {
        let [y, z, x] = self.unturned(g, [v[1], v[2], v[0]]);
        [x, y, z]
    }
}
