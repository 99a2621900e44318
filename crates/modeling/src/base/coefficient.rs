//! Coefficients of the regrouping rules: polynomials in lengths, cosines and sines, with negative powers allowed (Laurent
//! polynomials).
//!
//! `-D2^2`, `D10*cos(G10)/D4`, `cos(2*DEL)`: sums of rational multiples of products of integer
//! powers. Normal form: sin^2 is written 1 - cos^2, so that equal coefficients are equal as data.

use std::collections::BTreeMap;
use std::fmt;

use expr::{Expr, Graph, Node, SymbolKind};

use crate::base::field::{Assignment, P, Residue};

/// A factor of a product in a coefficient: a length, a cosine or a sine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Atom {
    /// The length with this symbol index.
    Length(u32),
    /// Cosine (`Cos`) and sine (`Sin`) of the angle with this symbol index.
    Cos(u32),
    Sin(u32),
}

/// A product of powers of atoms (lengths, cosines, sines): pairs (atom, exponent), sorted by atom; no exponent is zero.
pub(crate) type Monomial = Vec<(Atom, i32)>;

/// A reduced rational number: (numerator, positive denominator).
type Ratio = (i128, i128);

/// A coefficient of a regrouping rule: the sum of ratio times monomial over all terms; no ratio is zero.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub(crate) struct Coefficient {
    terms: BTreeMap<Monomial, Ratio>,
}

impl Coefficient {
    pub(crate) fn zero() -> Coefficient {
        Coefficient::default()
    }

    pub(crate) fn one() -> Coefficient {
        Coefficient::ratio((1, 1))
    }

    pub(crate) fn ratio(ratio: Ratio) -> Coefficient {
        Coefficient::product(Vec::new(), ratio)
    }

    /// The coefficient ratio * monomial. No sine in the monomial may have an exponent above one.
    pub(crate) fn product(monomial: Monomial, ratio: Ratio) -> Coefficient {
        let mut c = Coefficient::zero();
        c.add_term(monomial, ratio);
        c
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.terms.is_empty()
    }

    /// The coefficient for an expression in named constants. `None` if the expression is no Laurent polynomial, such as a
    /// division by a sum.
    pub(crate) fn from_expr(graph: &Graph, e: Expr) -> Option<Coefficient> {
        let part = |e: Expr| Coefficient::from_expr(graph, e);
        let symbol = |e: Expr| match graph.node(e) {
            Node::Symbol(s) if matches!(graph.symbols()[s.0 as usize].1, SymbolKind::Constant(_)) => Some(s.0),
            _ => None,
        };
        let positive = match graph.node(e.abs()) {
            Node::Constant(x) => Coefficient::ratio(short_fraction(x)?),
            Node::Symbol(_) => Coefficient::product(vec![(Atom::Length(symbol(e.abs())?), 1)], (1, 1)),
            Node::Cos(a) => Coefficient::product(vec![(Atom::Cos(symbol(a)?), 1)], (1, 1)),
            Node::Sin(a) => Coefficient::product(vec![(Atom::Sin(symbol(a)?), 1)], (1, 1)),
            Node::Add(a, b) => part(a)?.plus(&part(b)?),
            Node::Mul(a, b) => part(a)?.times(&part(b)?),
            Node::Div(a, b) => part(a)?.times(&part(b)?.inverse()?),
            Node::Sqrt(_) => return None,
        };
        Some(if e.is_negative() { positive.negated() } else { positive })
    }

    fn add_term(&mut self, monomial: Monomial, ratio: Ratio) {
        if ratio.0 == 0 {
            return;
        }
        let sum = match self.terms.get(&monomial) {
            Some(&old) => reduced(old.0 * ratio.1 + ratio.0 * old.1, old.1 * ratio.1),
            None => ratio,
        };
        if sum.0 == 0 {
            self.terms.remove(&monomial);
        } else {
            self.terms.insert(monomial, sum);
        }
    }

    pub(crate) fn plus(&self, other: &Coefficient) -> Coefficient {
        let mut sum = self.clone();
        for (m, &r) in &other.terms {
            sum.add_term(m.clone(), r);
        }
        sum
    }

    pub(crate) fn negated(&self) -> Coefficient {
        Coefficient { terms: self.terms.iter().map(|(m, &(n, d))| (m.clone(), (-n, d))).collect() }
    }

    pub(crate) fn times(&self, other: &Coefficient) -> Coefficient {
        let mut product = Coefficient::zero();
        for (a, &(an, ad)) in &self.terms {
            for (b, &(bn, bd)) in &other.terms {
                let ratio = reduced(an * bn, ad * bd);
                for (monomial, sign) in without_squared_sines(multiplied(a, b)) {
                    product.add_term(monomial, (sign * ratio.0, ratio.1));
                }
            }
        }
        product
    }

    /// The reciprocal 1 / self if self is one product without sines; otherwise `None`.
    fn inverse(&self) -> Option<Coefficient> {
        match self.terms.iter().next() {
            Some((m, &(n, d))) if self.terms.len() == 1 && !m.iter().any(|f| matches!(f.0, Atom::Sin(_))) => {
                let sign = n.signum();
                let inverse = m.iter().map(|&(a, k)| (a, -k)).collect();
                Some(Coefficient::product(inverse, (sign * d, sign * n)))
            }
            _ => None,
        }
    }

    /// The numeric value of the coefficient, from the values of the named constants in the graph.
    pub(crate) fn number(&self, graph: &Graph) -> f64 {
        let value = |s: u32| match graph.symbols()[s as usize].1 {
            SymbolKind::Constant(x) => x,
            SymbolKind::Input => f64::NAN,
        };
        let factor = |&(atom, k): &(Atom, i32)| {
            let x = match atom {
                Atom::Length(s) => value(s),
                Atom::Cos(s) => libm::cos(value(s)),
                Atom::Sin(s) => libm::sin(value(s)),
            };
            (0..k.abs()).fold(1.0, |product, _| if k > 0 { product * x } else { product / x })
        };
        self.terms.iter().map(|(m, &(n, d))| m.iter().map(factor).fold(n as f64 / d as f64, |a, b| a * b)).sum()
    }

    /// The element of the finite field for this coefficient; `constants`: the field elements of its symbols.
    pub(crate) fn residue(&self, constants: &[Assignment]) -> Residue {
        let ratio =
            |n: i128, d: i128| Residue::integer((n % i128::from(P)) as i64) * Residue::integer(d as i64).inverse();
        self.terms.iter().fold(Residue::ZERO, |sum, (m, &(n, d))| sum + ratio(n, d) * residue(m, constants))
    }

    /// The number of summands of the coefficient.
    pub(crate) fn n_terms(&self) -> usize {
        self.terms.len()
    }

    /// The coefficient as text; `name` gives the name of a symbol index.
    pub(crate) fn display<'a>(&'a self, name: &'a dyn Fn(u32) -> String) -> impl fmt::Display + 'a {
        Displayed { coefficient: self, name }
    }

    /// The summands of the coefficient, each as a coefficient. If [`double_angle`] writes the sum as one product, the only
    /// summand is the whole sum.
    pub(crate) fn summands(&self) -> Vec<Coefficient> {
        if double_angle(&self.terms, &|_| String::new()).is_some() {
            return vec![self.clone()];
        }
        self.terms.iter().map(|(m, &r)| Coefficient { terms: BTreeMap::from([(m.clone(), r)]) }).collect()
    }

    #[cfg(test)]
    pub(crate) fn is_one(&self) -> bool {
        *self == Coefficient::one()
    }
}

/// The element of the finite field for a monomial; `constants`: the field elements of its symbols.
pub(crate) fn residue(monomial: &Monomial, constants: &[Assignment]) -> Residue {
    monomial.iter().fold(Residue::ONE, |product, &(atom, k)| {
        let x = match atom {
            Atom::Length(s) => constants[s as usize].length,
            Atom::Cos(s) => constants[s as usize].cos,
            Atom::Sin(s) => constants[s as usize].sin,
        };
        let x = if k < 0 { x.inverse() } else { x };
        product * x.power(u64::from(k.unsigned_abs()))
    })
}

fn multiplied(a: &Monomial, b: &Monomial) -> Monomial {
    let mut product: BTreeMap<Atom, i32> = a.iter().copied().collect();
    for &(atom, k) in b {
        *product.entry(atom).or_insert(0) += k;
    }
    product.into_iter().filter(|f| f.1 != 0).collect()
}

/// Replaces sin^2 by 1 - cos^2 until no sine is squared. The result is a sum of terms (monomial, sign).
fn without_squared_sines(monomial: Monomial) -> Vec<(Monomial, i128)> {
    match monomial.iter().find(|f| matches!(f.0, Atom::Sin(_)) && f.1 > 1) {
        None => vec![(monomial, 1)],
        Some(&(Atom::Sin(s), _)) => {
            let plain = multiplied(&monomial, &vec![(Atom::Sin(s), -2)]);
            let squared = multiplied(&plain, &vec![(Atom::Cos(s), 2)]);
            let mut terms = without_squared_sines(plain);
            terms.extend(without_squared_sines(squared).into_iter().map(|(m, sign)| (m, -sign)));
            terms
        }
        Some(_) => unreachable!("only sines are looked for"),
    }
}

fn reduced(n: i128, d: i128) -> Ratio {
    let (mut a, mut b) = (n.unsigned_abs(), d.unsigned_abs());
    while b != 0 {
        (a, b) = (b, a % b);
    }
    let g = a.max(1) as i128;
    (n / g, d / g)
}

/// The denominators that [`short_fraction`] tries.
const FRACTION_DENOMINATORS: [i128; 7] = [1, 2, 4, 8, 16, 1000, 1_000_000];
/// Upper bound of the numerators that [`short_fraction`] accepts.
const MAX_FRACTION_NUMERATOR: f64 = 1e9;

/// The ratio of small integers that equals `x` exactly; `None` if there is no such ratio.
fn short_fraction(x: f64) -> Option<Ratio> {
    FRACTION_DENOMINATORS.into_iter().find_map(|d| {
        let n = x * d as f64;
        (n.fract() == 0.0 && n.abs() < MAX_FRACTION_NUMERATOR).then(|| reduced(n as i128, d))
    })
}

struct Displayed<'a> {
    coefficient: &'a Coefficient,
    name: &'a dyn Fn(u32) -> String,
}

impl fmt::Display for Displayed<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let terms = &self.coefficient.terms;
        if terms.is_empty() {
            return f.write_str("0");
        }
        if let Some(text) = double_angle(terms, self.name) {
            return f.write_str(&text);
        }
        // Positive terms are written first, so that the text does not start with a minus.
        let ordered = terms.iter().filter(|t| t.1.0 > 0).chain(terms.iter().filter(|t| t.1.0 < 0));
        for (i, (monomial, &(n, d))) in ordered.enumerate() {
            match (i, n < 0) {
                (0, false) => {}
                (0, true) => f.write_str("-")?,
                (_, false) => f.write_str(" + ")?,
                (_, true) => f.write_str(" - ")?,
            }
            f.write_str(&product_text(monomial, (n.abs(), d), self.name))?;
        }
        Ok(())
    }
}

fn product_text(monomial: &Monomial, (n, d): Ratio, name: &dyn Fn(u32) -> String) -> String {
    let factor = |atom: Atom, k: i32| {
        let base = match atom {
            Atom::Length(s) => name(s),
            Atom::Cos(s) => format!("cos({})", name(s)),
            Atom::Sin(s) => format!("sin({})", name(s)),
        };
        if k == 1 { base } else { format!("{base}^{k}") }
    };
    let above: Vec<String> = monomial.iter().filter(|f| f.1 > 0).map(|f| factor(f.0, f.1)).collect();
    let below: Vec<String> = monomial.iter().filter(|f| f.1 < 0).map(|f| factor(f.0, -f.1)).collect();
    let mut text = match (n, above.is_empty()) {
        (n, true) => n.to_string(),
        (1, false) => above.join("*"),
        (n, false) => format!("{n}*{}", above.join("*")),
    };
    if d != 1 {
        text += &format!("/{d}");
    }
    for b in below {
        text += &format!("/{b}");
    }
    text
}

/// The text of a sum that can be written as one product; otherwise `None`. x (2 cos^2 - 1) becomes x cos(2 a), 2 x sin cos
/// becomes x sin(2 a), and x - x cos^2 becomes x sin^2.
fn double_angle(terms: &BTreeMap<Monomial, Ratio>, name: &dyn Fn(u32) -> String) -> Option<String> {
    let signed = |rest: &Monomial, (n, d): Ratio, pair: String| {
        let mut text = product_text(rest, (n.abs(), d), name);
        text = if text == "1" { pair } else { format!("{text}*{pair}") };
        Some(if n < 0 { format!("-{text}") } else { text })
    };
    // One term 2 x sin cos becomes x sin(2 a).
    if terms.len() == 1 {
        let (monomial, &(n, d)) = terms.iter().next()?;
        let s = monomial.iter().find_map(|f| match f {
            (Atom::Sin(s), 1) if monomial.contains(&(Atom::Cos(*s), 1)) => Some(*s),
            _ => None,
        })?;
        if n % 2 != 0 {
            return None;
        }
        let rest = multiplied(monomial, &vec![(Atom::Cos(s), -1), (Atom::Sin(s), -1)]);
        return signed(&rest, (n / 2, d), format!("sin(2*{})", name(s)));
    }
    if terms.len() != 2 {
        return None;
    }
    // Two terms: x cos^2, and the same x without cos^2, multiplied by -1 or -1/2.
    let (squared, &(n, d)) = terms.iter().find(|(m, _)| m.iter().any(|f| matches!(f, (Atom::Cos(_), 2))))?;
    let s = squared.iter().find_map(|f| if let (Atom::Cos(s), 2) = f { Some(*s) } else { None })?;
    let rest = multiplied(squared, &vec![(Atom::Cos(s), -2)]);
    if terms.get(&rest) == Some(&(-n, d)) {
        return signed(&rest, (-n, d), format!("sin({})^2", name(s)));
    }
    let half = reduced(-n, 2 * d);
    (terms.get(&rest) == Some(&half)).then_some(())?;
    signed(&rest, reduced(n, 2 * d), format!("cos(2*{})", name(s)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_form_and_text() {
        let mut g = Graph::new();
        let d2 = g.symbol("D2", SymbolKind::Constant(0.3));
        let d4 = g.symbol("D4", SymbolKind::Constant(0.5));
        let del = g.symbol("DEL", SymbolKind::Constant(0.7));
        let (c, s) = (g.cos(del), g.sin(del));
        let read = |g: &Graph, e: Expr| Coefficient::from_expr(g, e).unwrap();
        let names = g.symbols().to_vec();
        let text = |c: Coefficient| c.display(&|s| names[s as usize].0.clone()).to_string();

        let (cc, ss) = (g.mul(c, c), g.mul(s, s));
        let one = g.add(cc, ss);
        assert!(read(&g, one).is_one());

        let cos_2 = g.sub(cc, ss);
        let x = g.mul(d2, cos_2);
        assert_eq!(text(read(&g, x)), "D2*cos(2*DEL)");
        assert!((read(&g, x).number(&g) - 0.3 * libm::cos(1.4)).abs() < 1e-16);

        let sc = g.mul(s, c);
        let y = g.add(sc, sc);
        assert_eq!(text(read(&g, -y)), "-sin(2*DEL)");

        let ratio = g.div(d2, d4);
        let z = g.mul(ratio, c);
        assert_eq!(text(read(&g, z)), "D2*cos(DEL)/D4");
        let square = g.mul(d2, d2);
        let w = g.sub(d4, square);
        assert_eq!(text(read(&g, w)), "D4 - D2^2");
    }
}
