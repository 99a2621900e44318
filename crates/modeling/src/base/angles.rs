//! Represents angles that are rational multiples of one symbol, theta = (n/d) q, and products of two such ratios, in a finite
//! field.
//!
//! The field has no angles, only points exp(i theta) = (cos theta, sin theta). Let D be the common denominator of all ratios n/d
//! of one coordinate q, and w = exp(i q/D). Then exp(i q) = w^D and exp(i (n/d) q) = w^(D n/d): each angle is a power of w.

use std::collections::BTreeMap;

use expr::{Expr, Graph, Node, Symbol};

use crate::base::field::{DIGITS, Residue, short_ratio};

/// The arguments of sines and cosines in a graph of expressions that are rational multiples of one symbol.
pub(crate) struct GraphAngles {
    /// For each argument of a sine or cosine: (symbol, power). The point (cos, sin) of the argument is w raised to this power;
    /// w: point of the angle symbol / D.
    powers: BTreeMap<Expr, (Symbol, u128)>,
    /// Symbol -> the common denominator D of the ratios with which the symbol occurs.
    common: BTreeMap<Symbol, u128>,
    /// Bits of a constant (f64) that is a product of two other constants -> the product of their field elements.
    products: BTreeMap<u64, Residue>,
}

impl GraphAngles {
    pub(crate) fn of(graph: &Graph) -> GraphAngles {
        let mut ratios: BTreeMap<Expr, (Symbol, (i64, i64))> = BTreeMap::new();
        for node in graph.nodes() {
            if let Node::Sin(argument) | Node::Cos(argument) = *node
                && let Some(ratio) = ratio_of_a_symbol(graph, argument)
            {
                ratios.insert(argument, ratio);
            }
        }
        // The common denominator of the ratios of each symbol; `None` if it exceeds MAX_POWER.
        let mut common: BTreeMap<Symbol, Option<u128>> = BTreeMap::new();
        for (symbol, (_, d)) in ratios.values() {
            let sum = common.entry(*symbol).or_insert(Some(1));
            *sum = sum.and_then(|sum| least_common_multiple(sum, *d as u128));
        }
        let power = |(argument, (symbol, (n, d))): (&Expr, &(Symbol, (i64, i64)))| {
            let power = (common[symbol]? / *d as u128).checked_mul(*n as u128)?;
            Some((*argument, (*symbol, power)))
        };
        let powers = ratios.iter().filter_map(power).collect();
        let common = common.iter().filter_map(|(&s, &d)| Some((s, d?))).collect();
        GraphAngles { powers, common, products: products(graph) }
    }

    /// The element of the finite field for a constant x of the graph. If x is a product of two constants, it is the product of
    /// the elements of these constants.
    pub(crate) fn number(&self, x: f64) -> Residue {
        self.products.get(&x.to_bits()).copied().unwrap_or_else(|| Residue::number(x))
    }

    /// (symbol, power) of an argument of a sine or cosine. The point (cos, sin) of the argument is the point of the angle
    /// symbol / D raised to this power; D: common denominator. `None` if the argument is no rational multiple of one symbol.
    pub(crate) fn power(&self, argument: Expr) -> Option<(Symbol, u128)> {
        self.powers.get(&argument).copied()
    }

    /// (symbol, n, d) of an argument of a sine or cosine that equals n/d times the symbol. `None` if the argument is no
    /// rational multiple of one symbol.
    pub(crate) fn ratio(&self, argument: Expr) -> Option<(Symbol, u128, u128)> {
        let &(symbol, power) = self.powers.get(&argument)?;
        Some((symbol, power, self.common[&symbol]))
    }
}

/// Largest number of decimal digits of a factor of a product. With this number, about one in a thousand other doubles is mistaken
/// for such a factor.
const FACTOR_DIGITS: usize = 12;

/// The constants of a graph that are products of two other constants and have more digits than a double holds. The map leads
/// from the bits of a constant to its field element. Such constants occur if two joints follow one coordinate: the torque of a
/// body then contains the product of the ratios of these joints.
fn products(graph: &Graph) -> BTreeMap<u64, Residue> {
    let constant = |node: &Node| if let Node::Constant(x) = node { Some(*x) } else { None };
    let is_short = |x: &f64| short_ratio(*x, FACTOR_DIGITS).is_some();
    let (mut short, long): (Vec<f64>, Vec<f64>) = graph.nodes().iter().filter_map(constant).partition(is_short);
    short.sort_unstable_by(f64::total_cmp);
    let product = |x: f64| {
        short.iter().find_map(|&a| {
            let b = *short.get(short.partition_point(|b| a * b < x * (1.0 - 2.0 * f64::EPSILON)))?;
            let is_near = (a * b - x).abs() <= 2.0 * f64::EPSILON * x;
            is_near.then(|| (x.to_bits(), Residue::number(a) * Residue::number(b)))
        })
    };
    long.into_iter().filter_map(product).collect()
}

/// Upper bound of the powers to which the point (cos, sin) of an angle is raised.
const MAX_POWER: u128 = 1 << 100;

pub(crate) fn least_common_multiple(a: u128, b: u128) -> Option<u128> {
    let (mut x, mut y) = (a, b);
    while y != 0 {
        (x, y) = (y, x % y);
    }
    (a / x).checked_mul(b).filter(|&sum| sum < MAX_POWER)
}

/// (symbol, (n, d)) if `argument` is a symbol or (n/d) times a symbol, with small positive integers n and d; otherwise `None`.
fn ratio_of_a_symbol(graph: &Graph, argument: Expr) -> Option<(Symbol, (i64, i64))> {
    let symbol = |e: Expr| if let Node::Symbol(s) = graph.node(e) { Some(s) } else { None };
    match graph.node(argument) {
        Node::Symbol(s) => Some((s, (1, 1))),
        Node::Mul(a, b) => {
            let (factor, s) = match (graph.as_constant(a), graph.as_constant(b)) {
                (Some(factor), _) => (factor, symbol(b)?),
                (_, Some(factor)) => (factor, symbol(a)?),
                _ => return None,
            };
            short_ratio(factor, DIGITS).filter(|(n, _)| *n > 0).map(|ratio| (s, ratio))
        }
        _ => None,
    }
}
