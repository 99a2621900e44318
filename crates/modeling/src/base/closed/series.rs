//! Truncated power series over a finite field, and the evaluation of a function along a curve that is given by such series.
//!
//! Along a curve q(t) = q_0 + q_1 t + .. every polynomial function of q is a series in t. An angle is x(t) = x_0 + delta(t),
//! where x_0 is a point of the circle. The coefficients of its cosine C(t) and its sine S(t) follow from the coefficients of
//! delta,
//!
//! ```text
//! k C_k = -sum_j j delta_j S_(k-j),   k S_k = sum_j j delta_j C_(k-j)
//! ```

use std::collections::BTreeMap;

use expr::{Algebra, Expr, Graph, Node, Symbol, SymbolKind};

use crate::base::angles::GraphAngles;
use crate::base::field::{Assignment, CirclePoint, P, Residue, times};

/// A power series a_0 + a_1 t + .., stored as its coefficients without trailing zeros; missing coefficients are zero.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub(crate) struct TaylorSeries(pub Vec<Residue>);

impl TaylorSeries {
    pub(crate) fn number(x: Residue) -> TaylorSeries {
        TaylorSeries(vec![x]).trimmed()
    }

    /// The coefficient a_k of t^k.
    pub(crate) fn at(&self, k: usize) -> Residue {
        self.0.get(k).copied().unwrap_or_default()
    }

    fn trimmed(mut self) -> TaylorSeries {
        while self.0.last() == Some(&Residue::ZERO) {
            self.0.pop();
        }
        self
    }

    fn scaled(&self, factor: Residue) -> TaylorSeries {
        TaylorSeries(self.0.iter().map(|&x| x * factor).collect()).trimmed()
    }

    fn plus(&self, other: &TaylorSeries) -> TaylorSeries {
        let n = self.0.len().max(other.0.len());
        TaylorSeries((0..n).map(|k| self.at(k) + other.at(k)).collect()).trimmed()
    }

    fn negated(&self) -> TaylorSeries {
        TaylorSeries(self.0.iter().map(|&x| -x).collect())
    }

    /// The product of two series, up to t^order.
    fn times(&self, other: &TaylorSeries, order: usize) -> TaylorSeries {
        if self.0.is_empty() || other.0.is_empty() {
            return TaylorSeries::default();
        }
        let n = (self.0.len() + other.0.len() - 1).min(order + 1);
        let mut product = vec![Residue::ZERO; n];
        for (i, &a) in self.0.iter().enumerate().take(n) {
            for (sum, &b) in product[i..].iter_mut().zip(&other.0) {
                *sum = *sum + a * b;
            }
        }
        TaylorSeries(product).trimmed()
    }

    /// The series 1 / self, up to t^order; `None` if the constant term is zero.
    fn inverse(&self, order: usize) -> Option<TaylorSeries> {
        let first = self.at(0);
        if first == Residue::ZERO {
            return None;
        }
        let scale = first.inverse();
        if self.0.len() == 1 {
            return Some(TaylorSeries(vec![scale]));
        }
        let mut inverse = vec![scale];
        for k in 1..=order {
            let sum = (1..=k.min(self.0.len() - 1)).fold(Residue::ZERO, |sum, j| sum + self.0[j] * inverse[k - j]);
            inverse.push(-(scale * sum));
        }
        Some(TaylorSeries(inverse).trimmed())
    }

    /// Cosine and sine of the angle x_0 + self, as series in t. `(cos, sin)` is the point of x_0; the constant term of self is
    /// ignored. `reciprocals`: 1/k for k up to the order of the result.
    fn turned(&self, (cos, sin): CirclePoint, reciprocals: &[Residue]) -> (TaylorSeries, TaylorSeries) {
        let (mut c, mut s) = (vec![cos], vec![sin]);
        if self.0.len() > 1 {
            for k in 1..reciprocals.len() {
                let rate = |other: &[Residue]| {
                    (1..=k.min(self.0.len() - 1))
                        .fold(Residue::ZERO, |sum, j| sum + Residue(j as u64) * self.0[j] * other[k - j])
                };
                let (down, up) = (rate(&s), rate(&c));
                let scale = reciprocals[k];
                c.push(-(scale * down));
                s.push(scale * up);
            }
        }
        (TaylorSeries(c).trimmed(), TaylorSeries(s).trimmed())
    }
}

/// The reciprocals [0, 1, 1/2, .., 1/order] in the field modulo the prime P, from 1/k = -(P/k) / (P mod k).
fn reciprocals(order: usize) -> Vec<Residue> {
    let mut all = vec![Residue::ZERO, Residue::ONE];
    for k in 2..=order as u64 {
        let next = -(Residue(P / k) * all[(P % k) as usize]);
        all.push(next);
    }
    all.truncate(order + 1);
    all
}

/// The values of one input of a function along a curve, as angle and as length.
#[derive(Clone, Debug)]
pub(crate) struct CurveInput {
    /// The point (cos, sin) of x_0/D. x_0: the angle at t = 0; D: common denominator of the ratios with which this angle
    /// occurs.
    pub point: CirclePoint,
    /// The common denominator D of the ratios with which this angle occurs.
    pub denominator: u128,
    /// The input as a length: a series in t. If the input is an angle, the terms from t on are the change of the angle along
    /// the curve.
    pub value: TaylorSeries,
}

impl CurveInput {
    /// An input that is constant along the curve and is not used as an angle.
    pub(crate) fn still(x: Residue) -> CurveInput {
        CurveInput { point: (Residue::ONE, Residue::ZERO), denominator: 1, value: TaylorSeries::number(x) }
    }
}

/// Evaluates a function along a curve, as power series up to t^order.
pub(crate) struct SeriesAlgebra<'a> {
    graph: &'a Graph,
    angles: &'a GraphAngles,
    constants: &'a [Assignment],
    /// Input symbol of the function -> its values along the curve.
    inputs: &'a BTreeMap<Symbol, CurveInput>,
    order: usize,
    reciprocals: Vec<Residue>,
    turns: BTreeMap<Expr, (TaylorSeries, TaylorSeries)>,
    /// Whether a division by zero occurred, or an input or an angle is not known. If so, no value is valid.
    pub broken: bool,
}

impl<'a> SeriesAlgebra<'a> {
    pub(crate) fn new(
        graph: &'a Graph,
        angles: &'a GraphAngles,
        constants: &'a [Assignment],
        inputs: &'a BTreeMap<Symbol, CurveInput>,
        order: usize,
    ) -> Self {
        SeriesAlgebra {
            graph,
            angles,
            constants,
            inputs,
            order,
            reciprocals: reciprocals(order),
            turns: BTreeMap::new(),
            broken: false,
        }
    }

    fn angle(&mut self, argument: Expr) -> &(TaylorSeries, TaylorSeries) {
        if !self.turns.contains_key(&argument) {
            let turn = self.turn(argument);
            self.broken |= turn.is_none();
            self.turns.insert(argument, turn.unwrap_or_default());
        }
        &self.turns[&argument]
    }

    fn turn(&self, argument: Expr) -> Option<(TaylorSeries, TaylorSeries)> {
        if let Node::Symbol(s) = self.graph.node(argument)
            && matches!(self.graph.symbols()[s.0 as usize].1, SymbolKind::Constant(_))
        {
            let constant = self.constants.get(s.0 as usize)?;
            return Some((TaylorSeries::number(constant.cos), TaylorSeries::number(constant.sin)));
        }
        let (symbol, n, d) = self.angles.ratio(argument)?;
        let moving = self.inputs.get(&symbol)?;
        let ratio = Residue::ratio((n as i128, d as i128));
        if moving.denominator % d != 0 {
            return None;
        }
        let point = times(moving.point, n.checked_mul(moving.denominator / d)?);
        Some(moving.value.scaled(ratio).turned(point, &self.reciprocals))
    }
}

impl Algebra for SeriesAlgebra<'_> {
    type Value = TaylorSeries;
    fn constant(&mut self, x: f64) -> TaylorSeries {
        TaylorSeries::number(self.angles.number(x))
    }
    fn symbol(&mut self, symbol: Symbol) -> TaylorSeries {
        let s = symbol.0 as usize;
        match self.graph.symbols()[s].1 {
            SymbolKind::Constant(_) => self.constants.get(s).map(|c| TaylorSeries::number(c.length)),
            SymbolKind::Input => self.inputs.get(&symbol).map(|moving| moving.value.clone()),
        }
        .unwrap_or_else(|| {
            self.broken = true;
            TaylorSeries::default()
        })
    }
    fn sin(&mut self, argument: Expr) -> TaylorSeries {
        self.angle(argument).1.clone()
    }
    fn cos(&mut self, argument: Expr) -> TaylorSeries {
        self.angle(argument).0.clone()
    }
    fn neg(&mut self, a: &TaylorSeries) -> TaylorSeries {
        a.negated()
    }
    fn add(&mut self, a: &TaylorSeries, b: &TaylorSeries) -> TaylorSeries {
        a.plus(b)
    }
    fn sub(&mut self, a: &TaylorSeries, b: &TaylorSeries) -> TaylorSeries {
        a.plus(&b.negated())
    }
    fn mul(&mut self, a: &TaylorSeries, b: &TaylorSeries) -> TaylorSeries {
        a.times(b, self.order)
    }
    fn div(&mut self, a: &TaylorSeries, b: &TaylorSeries) -> TaylorSeries {
        let inverse = b.inverse(self.order);
        self.broken |= inverse.is_none();
        inverse.map_or_else(TaylorSeries::default, |inverse| a.times(&inverse, self.order))
    }
    fn sqrt(&mut self, a: &TaylorSeries) -> TaylorSeries {
        // A named constant need not have a square root in the field. So the root of a constant is treated as another random
        // constant, as in the field algebra: its value is the cube of the constant.
        self.broken |= a.0.len() > 1;
        TaylorSeries::number(a.at(0).power(3))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::field::circle;
    use random::SplitMix;

    fn random(n: usize, seed: u64) -> TaylorSeries {
        let mut random = SplitMix(seed);
        TaylorSeries((0..n).map(|_| Residue::random(&mut random)).collect())
    }

    #[test]
    fn a_series_times_its_inverse_is_one() {
        let a = random(5, 1);
        let inverse = a.inverse(11).unwrap();
        assert_eq!(a.times(&inverse, 11), TaylorSeries::number(Residue::ONE));
        assert_eq!(TaylorSeries(vec![Residue::ZERO, Residue::ONE]).inverse(3), None);
    }

    #[test]
    fn reciprocals_are_inverses() {
        for order in 0..12 {
            let all = reciprocals(order);
            assert_eq!(all.len(), order + 1);
            assert!((1..=order).all(|k| all[k] == Residue(k as u64).inverse()));
        }
    }

    #[test]
    fn cosine_and_sine_stay_on_the_circle_and_follow_each_other() {
        let delta = random(4, 2);
        let (c, s) = delta.turned(circle(&mut SplitMix(3)), &reciprocals(9));
        let one = c.times(&c, 9).plus(&s.times(&s, 9));
        assert_eq!(one, TaylorSeries::number(Residue::ONE));
        // The derivatives must satisfy dS/dt = C d(delta)/dt; C, S: cosine and sine of the angle.
        let slope = |a: &TaylorSeries| TaylorSeries((1..a.0.len()).map(|k| Residue(k as u64) * a.0[k]).collect());
        assert_eq!(slope(&s), c.times(&slope(&delta), 8));
    }

    /// Checks that cos(q/2)^2 - sin(q/2)^2 = cos(q) at each order of t along a curve.
    #[test]
    fn a_ratio_of_an_angle_turns_with_it() {
        let mut g = Graph::new();
        let q = g.symbol("q", SymbolKind::Input);
        let half = g.constant(0.5);
        let half = g.mul(half, q);
        let (c, s) = (g.cos(half), g.sin(half));
        let (cc, ss) = (g.mul(c, c), g.mul(s, s));
        let double = g.sub(cc, ss);
        let cos = g.cos(q);
        let difference = g.sub(double, cos);
        let output = expr::Output { name: "y".into(), rows: 1, columns: 1, entries: vec![difference] };
        let function = expr::Function::new("f", &g, Vec::new(), vec![output]);
        let angles = GraphAngles::of(function.graph());
        let moving = CurveInput { point: circle(&mut SplitMix(4)), denominator: 2, value: random(6, 5) };
        let inputs = BTreeMap::from([(Symbol(0), moving)]);
        let mut algebra = SeriesAlgebra::new(function.graph(), &angles, &[], &inputs, 7);
        assert_eq!(function.evaluate_in(&mut algebra)[0][0], TaylorSeries::default());
        assert!(!algebra.broken);
    }
}
