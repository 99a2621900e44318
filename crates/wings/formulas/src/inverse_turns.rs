//! Roots and directions that rounding may not spoil, by the operations that every language of output has.
//!
//! max(e, 0) = (e + sqrt(e^2)) / 2 has no step, and is exact where roots are rounded right.

use expr::{Expr, Graph};

use modeling::building::Turn;

/// What is rounding, of the components of a unit vector and of a length in m: 450 units in the last place of 1, where a pose and
/// its way back through six frames make some ten.
const NOTHING: f64 = 1e-13;

/// The length of a vector in a plane, |e| of (e, 0).
pub(crate) fn norm(g: &mut Graph, vector: [Expr; 2]) -> Expr {
    let [xx, yy] = vector.map(|e| g.mul(e, e));
    let square = g.add(xx, yy);
    g.sqrt(square)
}

/// max(e, 0): the root of a square is |e| to the bit.
fn positive(g: &mut Graph, e: Expr) -> Expr {
    let (size, half) = (norm(g, [e, Expr::ZERO]), g.constant(0.5));
    let twice = g.add(e, size);
    g.mul(half, twice)
}

/// The root of a product of lengths: those of `spare` are zero where rounding has made them less, and farther below zero they
/// make it no number.
pub(crate) fn root(g: &mut Graph, spare: &[Expr], others: &[Expr]) -> Expr {
    let scale = g.constant(1.0 / NOTHING);
    let (mut product, mut reached) = (Expr::ONE, Expr::ONE);
    for &e in spare {
        let above = positive(g, e);
        let below = g.sub(e, above);
        let below = g.mul(scale, below);
        let share = g.add(Expr::ONE, below);
        product = g.mul(product, above);
        reached = g.mul(reached, share);
    }
    let product = others.iter().fold(product, |p, &e| g.mul(p, e));
    let (root, reached) = (g.sqrt(product), g.sqrt(reached));
    g.mul(root, reached)
}

/// The turn to (cos, sin), or to `free` where `size`, 0 where they both are, is nothing.
pub(crate) fn direction(g: &mut Graph, [cos, sin]: [Expr; 2], size: Expr, free: Turn) -> Turn {
    // From 1e-8 up where size is below NOTHING, so that what is added outweighs (cos, sin).
    let (scale, weight) = (g.constant(1.0 / NOTHING), g.constant(1e8));
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

/// The turn to (cos, sin), of length 1 whatever cancelled on the way.
pub(crate) fn unit_turn(g: &mut Graph, cos: Expr, sin: Expr) -> Turn {
    let length = norm(g, [cos, sin]);
    Turn { cos: g.div(cos, length), sin: g.div(sin, length) }
}

/// Cosine and sine, times both lengths, of the angle from one vector of a plane to another.
pub(crate) fn between(g: &mut Graph, [u, v]: [Expr; 2], [x, y]: [Expr; 2]) -> [Expr; 2] {
    let [ux, vy, vx, uy] = [(u, x), (v, y), (v, x), (u, y)].map(|(a, b)| g.mul(a, b));
    [g.add(ux, vy), g.sub(vx, uy)]
}
