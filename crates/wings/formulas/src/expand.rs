//! Expands the entries of a function to sums of products of symbols, sines and cosines.
//!
//! sin^2 is replaced by 1 - cos^2, because some terms cancel only by this identity. Sine and cosine of a named sum of angles (C23
//! = cos(q2 + q3)) are one factor, as in textbooks.

use std::collections::BTreeMap;

use expr::{Expr, Function, Node};

use crate::listing::{Listing, ListingNames, OutputEntry, Term, TermReader, sum};

/// A product of factors. A factor is given by the index of its node in the graph and its power; the factors are in the order of
/// their nodes.
type Monomial = Vec<(usize, u32)>;
/// A sum of products. For each product: its coefficient, and the sum of the magnitudes of all terms that were added to this
/// coefficient.
type Polynomial = BTreeMap<Monomial, (f64, f64)>;

/// Largest number of terms of an expansion: longer formulas are not readable.
const MAX_TERMS: usize = 20_000;
/// A coefficient counts as zero if its magnitude is below this fraction of the sum of the magnitudes of the terms added to it.
const CANCELLED: f64 = 1e-14;

/// The reason why an entry cannot be expanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TooLong {
    /// The expansion has more than this number of terms.
    Terms(usize),
    /// The entry has a quotient or a root, so it cannot be a sum of products.
    Quotient,
}

impl std::fmt::Display for TooLong {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            TooLong::Terms(n) => {
                write!(f, "expanded it has more than {n} terms: leave [expand] out, or name one [entry]")
            }
            TooLong::Quotient => f.write_str("it has quotients, which are no sums of products: leave [expand] out"),
        }
    }
}

impl std::error::Error for TooLong {}

/// The expanded function. `place`: the only entry to expand; `None`: all entries.
pub(crate) fn expanded(function: &Function, place: Option<OutputEntry>) -> Result<Listing, TooLong> {
    let mut expansion = Expansion { function, squares: squares(function), of_node: BTreeMap::new() };
    let graph = function.graph();
    let mut names = ListingNames::of(function);
    let mut values = BTreeMap::new();
    for (i, output) in function.outputs.iter().enumerate() {
        for (k, &e) in output.entries.iter().enumerate() {
            if place.is_none_or(|(o, r, c)| (o, r * output.columns + c) == (i, k)) {
                values.insert((i, k), expansion.of(e)?);
            }
        }
    }
    // Finds the factors that occur in the entries, and the factors from which these are computed.
    let mut read = vec![false; graph.nodes().len()];
    for (factor, _) in values.values().flat_map(BTreeMap::keys).flatten() {
        read[*factor] = true;
    }
    for n in (0..read.len()).rev().filter(|&n| is_factor(function, n)) {
        if read[n] {
            mark(function, n, &mut read);
        }
    }
    let mut assignments = Vec::new();
    for n in (0..read.len()).filter(|&n| read[n]) {
        if is_factor(function, n) && !matches!(graph.nodes()[n], Node::Symbol(_)) {
            let value = TermReader { function, names: &names }.node(n);
            names.give_to_variable(function, n);
            if let Some((name, negative)) = names.name(n) {
                let value = if *negative { crate::listing::negated(value) } else { value };
                assignments.push((name.clone(), value));
            }
        }
    }
    Ok(Listing::around(function, function, &names, assignments, place, |i, k| term(&values[&(i, k)], &names)))
}

/// Marks in `read` the factors from which the node n is computed directly.
fn mark(function: &Function, n: usize, read: &mut [bool]) {
    for e in expr::operands(function.graph().nodes()[n]) {
        if is_factor(function, e.node()) {
            read[e.node()] = true;
        } else {
            mark(function, e.node(), read);
        }
    }
}

/// Whether a node of the graph is one factor: a symbol, a sine, a cosine, or the sine or cosine of a named sum of angles (C23).
fn is_factor(function: &Function, n: usize) -> bool {
    let of_sum =
        |name: &str| name.starts_with(['C', 'S']) && name[1..].starts_with(|c: char| c.is_ascii_digit() || c == 'm');
    match function.graph().nodes()[n] {
        Node::Symbol(_) | Node::Sin(_) | Node::Cos(_) => true,
        Node::Add(..) => function.graph().name_of(n).is_some_and(|(name, _)| of_sum(name)),
        _ => false,
    }
}

/// For each sine (index of its node), the index of the node with the cosine of the same angle.
fn squares(function: &Function) -> BTreeMap<usize, usize> {
    let graph = function.graph();
    let place = |wanted: Node| graph.nodes().iter().position(|node| *node == wanted);
    let called =
        |wanted: &str| (0..graph.nodes().len()).find(|&n| graph.name_of(n).is_some_and(|(name, _)| name == wanted));
    let cosine = |n: usize| match (graph.nodes()[n], graph.name_of(n)) {
        (Node::Sin(a), _) => place(Node::Cos(a)),
        (Node::Add(..), Some((name, _))) if is_factor(function, n) => called(&format!("C{}", name.strip_prefix('S')?)),
        _ => None,
    };
    (0..graph.nodes().len()).filter_map(|n| Some((n, cosine(n)?))).collect()
}

struct Expansion<'a> {
    function: &'a Function,
    squares: BTreeMap<usize, usize>,
    of_node: BTreeMap<usize, Polynomial>,
}

impl Expansion<'_> {
    fn of(&mut self, e: Expr) -> Result<Polynomial, TooLong> {
        let mut needed = vec![e.node()];
        while let Some(&n) = needed.last() {
            let node = self.function.graph().nodes()[n];
            let below: Vec<usize> =
                if is_factor(self.function, n) { Vec::new() } else { expr::operands(node).map(Expr::node).collect() };
            let missing: Vec<usize> = below.into_iter().filter(|m| !self.of_node.contains_key(m)).collect();
            if missing.is_empty() {
                needed.pop();
                if !self.of_node.contains_key(&n) {
                    let value = self.node(n, node)?;
                    self.of_node.insert(n, value);
                }
            } else {
                needed.extend(missing);
            }
        }
        Ok(scaled(&self.of_node[&e.node()], if e.is_negative() { -1.0 } else { 1.0 }))
    }

    fn node(&self, n: usize, node: Node) -> Result<Polynomial, TooLong> {
        if is_factor(self.function, n) {
            return Ok(BTreeMap::from([(vec![(n, 1)], (1.0, 1.0))]));
        }
        let at = |e: Expr| scaled(&self.of_node[&e.node()], if e.is_negative() { -1.0 } else { 1.0 });
        let mut value = match node {
            Node::Constant(x) => BTreeMap::from([(Vec::new(), (x, x))]),
            Node::Add(a, b) => {
                let mut value = at(a);
                at(b).into_iter().for_each(|(monomial, x)| accumulate(&mut value, monomial, x));
                value
            }
            Node::Mul(a, b) => self.product(&at(a), &at(b))?,
            Node::Div(a, b) => match self.function.graph().as_constant(b) {
                Some(x) => scaled(&at(a), 1.0 / x),
                None => return Err(TooLong::Quotient),
            },
            _ => return Err(TooLong::Quotient),
        };
        // Removes coefficients that are zero up to rounding.
        value.retain(|_, (x, size)| x.abs() > CANCELLED * *size);
        if value.len() > MAX_TERMS { Err(TooLong::Terms(MAX_TERMS)) } else { Ok(value) }
    }

    fn product(&self, a: &Polynomial, b: &Polynomial) -> Result<Polynomial, TooLong> {
        let mut product = Polynomial::new();
        for (m, x) in a {
            for (n, y) in b {
                let mut powers: BTreeMap<usize, u32> = m.iter().copied().collect();
                n.iter().for_each(|(factor, power)| *powers.entry(*factor).or_insert(0) += power);
                self.reduced(powers, (x.0 * y.0, x.1 * y.1), &mut product);
            }
            if product.len() > MAX_TERMS {
                return Err(TooLong::Terms(MAX_TERMS));
            }
        }
        Ok(product)
    }

    /// Adds a product to `sum`, with sin^2 replaced by 1 - cos^2.
    fn reduced(&self, mut powers: BTreeMap<usize, u32>, (x, size): (f64, f64), sum: &mut Polynomial) {
        let square =
            powers.iter().find(|(factor, power)| **power >= 2 && self.squares.contains_key(factor)).map(|p| *p.0);
        let Some(sine) = square else {
            return accumulate(sum, powers.into_iter().collect(), (x, size));
        };
        match powers.get(&sine) {
            Some(2) => powers.remove(&sine),
            Some(&power) => powers.insert(sine, power - 2),
            None => None,
        };
        self.reduced(powers.clone(), (x, size), sum);
        *powers.entry(self.squares[&sine]).or_insert(0) += 2;
        self.reduced(powers, (-x, size), sum);
    }
}

fn accumulate(sum: &mut Polynomial, monomial: Monomial, (x, size): (f64, f64)) {
    let entry = sum.entry(monomial).or_insert((0.0, 0.0));
    *entry = (entry.0 + x, entry.1 + size);
}

fn scaled(a: &Polynomial, factor: f64) -> Polynomial {
    a.iter().map(|(m, (x, size))| (m.clone(), (factor * x, factor.abs() * size))).collect()
}

/// Writes a polynomial as a term of the listing, with the names of its factors.
fn term(polynomial: &Polynomial, names: &ListingNames) -> Term {
    let product = |(monomial, (x, _)): (&Monomial, &(f64, f64))| {
        let mut negative = *x < 0.0;
        let mut factors = Vec::new();
        if x.abs() != 1.0 || monomial.is_empty() {
            factors.push((Term::Number(x.abs()), 1));
        }
        for &(factor, power) in monomial {
            if let Some((name, is_negative)) = names.name(factor) {
                negative ^= *is_negative && power % 2 == 1;
                factors.push((Term::Variable(name.clone()), power));
            }
        }
        match &factors[..] {
            [(single, 1)] => (negative, single.clone()),
            _ => (negative, Term::Product(factors)),
        }
    };
    let terms: Vec<(bool, Term)> = polynomial.iter().map(product).collect();
    match &terms[..] {
        [] => Term::Number(0.0),
        [(false, single)] => single.clone(),
        _ => sum(terms),
    }
}
