//! Roots and directions that are robust against rounding. They use only operations that every output language has.
//!
//! The maximum max(e, 0) = (e + sqrt(e^2)) / 2 is continuous, and exact if square roots are rounded correctly.

use expr::{Expr, Graph};

use modeling::building::ZRotation;

/// Values below this threshold are only rounding: components of a unit vector, and lengths, m. The threshold is 450 units in
/// the last place of one. A pose and its inverse through six frames have rounding errors of about ten units.
const ROUNDING: f64 = 1e-13;
/// Weight of the direction `free` in [`direction`] if the vector has the length 0. The weight decreases to 0 at the length
/// [`ROUNDING`].
const FREE_WEIGHT: f64 = 1e8;

/// The length of a vector in a plane. The length of (e, 0) is |e|.
pub(crate) fn norm(g: &mut Graph, vector: [Expr; 2]) -> Expr {
    let [xx, yy] = vector.map(|e| g.mul(e, e));
    let square = g.add(xx, yy);
    g.sqrt(square)
}

/// max(e, 0), computed from |e| as the root of e^2.
fn positive(g: &mut Graph, e: Expr) -> Expr {
    let (size, half) = (norm(g, [e, Expr::ZERO]), g.constant(0.5));
    let twice = g.add(e, size);
    g.mul(half, twice)
}

/// The square root of a product of lengths. A factor in `spare` counts as zero if it is negative by less than [`ROUNDING`]; if it
/// is more negative, the result is NaN. The factors in `others` are not negative.
pub(crate) fn root(g: &mut Graph, spare: &[Expr], others: &[Expr]) -> Expr {
    let scale = g.constant(1.0 / ROUNDING);
    let (mut product, mut in_reach) = (Expr::ONE, Expr::ONE);
    for &e in spare {
        let above = positive(g, e);
        let below = g.sub(e, above);
        let below = g.mul(scale, below);
        let share = g.add(Expr::ONE, below);
        product = g.mul(product, above);
        in_reach = g.mul(in_reach, share);
    }
    let product = others.iter().fold(product, |p, &e| g.mul(p, e));
    let (root, in_reach) = (g.sqrt(product), g.sqrt(in_reach));
    g.mul(root, in_reach)
}

/// The direction of the vector (cos, sin), whose length is `size`. If `size` is only rounding, the result is the direction
/// `free`.
pub(crate) fn direction(g: &mut Graph, [cos, sin]: [Expr; 2], size: Expr, free: ZRotation) -> ZRotation {
    // If `size` is below ROUNDING, the weight of `free` is at least 1e-8, so `free` outweighs the vector (cos, sin).
    let (scale, weight) = (g.constant(1.0 / ROUNDING), g.constant(FREE_WEIGHT));
    let size = g.mul(scale, size);
    let lack = g.sub(Expr::ONE, size);
    let lack = positive(g, lack);
    let weight = g.mul(weight, lack);
    let [cos, sin] = [(cos, free.cos), (sin, free.sin)].map(|(own, free)| {
        let added = g.mul(weight, free);
        g.add(own, added)
    });
    unit_turn(g, cos, sin)
}

/// The direction of (cos, sin) as a unit vector. It has length 1 even if cos and sin are inaccurate because of cancellation.
pub(crate) fn unit_turn(g: &mut Graph, cos: Expr, sin: Expr) -> ZRotation {
    let length = norm(g, [cos, sin]);
    ZRotation { cos: g.div(cos, length), sin: g.div(sin, length) }
}

/// Cosine and sine of the angle from the vector (x, y) to the vector (u, v) in a plane, both multiplied by the two lengths.
pub(crate) fn between(g: &mut Graph, [u, v]: [Expr; 2], [x, y]: [Expr; 2]) -> [Expr; 2] {
    let [ux, vy, vx, uy] = [(u, x), (v, y), (v, x), (u, y)].map(|(a, b)| g.mul(a, b));
    [g.add(ux, vy), g.sub(vx, uy)]
}
