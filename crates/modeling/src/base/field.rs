//! The field of integers modulo 2^61 - 1, where a zero is a zero.
//!
//! A polynomial identity that holds at random points of this field holds, up to a chance of
//! degree / 2^61 per point [Schwartz 1980]. Lengths are random elements; an angle is a random point
//! (c, s) of the circle c^2 + s^2 = 1, so that no angle needs a value.

use expr::{Algebra, Expr, Graph, Node, Symbol, SymbolKind};

use crate::random::SplitMix;

pub(crate) const P: u64 = (1 << 61) - 1;

/// An element, 0 <= x < P.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) struct Residue(pub u64);

impl Residue {
    pub const ZERO: Residue = Residue(0);
    pub const ONE: Residue = Residue(1);

    pub fn integer(n: i64) -> Residue {
        Residue(n.rem_euclid(P as i64) as u64)
    }

    /// The f64 as the dyadic rational it is.
    pub fn number(x: f64) -> Residue {
        let bits = x.abs().to_bits();
        let exponent = (bits >> 52) as i64;
        let fraction = bits & ((1 << 52) - 1);
        let (mantissa, power) = if exponent == 0 { (fraction, -1074) } else { (fraction | 1 << 52, exponent - 1075) };
        // 2^61 = 1, so powers of two repeat with period 61.
        let scaled = Residue(mantissa) * Residue(1 << power.rem_euclid(61));
        if x < 0.0 { -scaled } else { scaled }
    }

    /// Uniform, but neither zero nor one.
    pub fn random(random: &mut SplitMix) -> Residue {
        loop {
            let x = random.next() >> 3;
            if x < P && x > 1 {
                return Residue(x);
            }
        }
    }

    pub fn inverse(self) -> Residue {
        self.power(P - 2)
    }

    pub fn power(self, mut n: u64) -> Residue {
        let (mut square, mut result) = (self, Residue::ONE);
        while n > 0 {
            if n & 1 == 1 {
                result = result * square;
            }
            square = square * square;
            n >>= 1;
        }
        result
    }

    /// n/d with |n|, d <= bound, when there is one.
    pub fn as_ratio(self, bound: i64) -> Option<(i64, i64)> {
        for d in 1..=bound {
            let n = (self * Residue::integer(d)).0;
            if n <= bound as u64 {
                return Some((n as i64, d));
            }
            if P - n <= bound as u64 {
                return Some((-((P - n) as i64), d));
            }
        }
        None
    }
}

impl std::ops::Add for Residue {
    type Output = Residue;
    fn add(self, b: Residue) -> Residue {
        let sum = self.0 + b.0;
        Residue(if sum >= P { sum - P } else { sum })
    }
}

impl std::ops::Neg for Residue {
    type Output = Residue;
    fn neg(self) -> Residue {
        Residue(if self.0 == 0 { 0 } else { P - self.0 })
    }
}

impl std::ops::Sub for Residue {
    type Output = Residue;
    fn sub(self, b: Residue) -> Residue {
        self + -b
    }
}

impl std::ops::Mul for Residue {
    type Output = Residue;
    fn mul(self, b: Residue) -> Residue {
        let product = u128::from(self.0) * u128::from(b.0);
        let (low, high) = (product as u64 & P, (product >> 61) as u64);
        Residue(low) + Residue(high)
    }
}

/// The elements that stand for one constant: as a length, and as an angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Assignment {
    pub length: Residue,
    pub cos: Residue,
    pub sin: Residue,
}

impl Assignment {
    pub fn random(random: &mut SplitMix) -> Assignment {
        let length = Residue::random(random);
        let (cos, sin) = circle(random);
        Assignment { length, cos, sin }
    }
}

/// A random point of the circle: ((1 - t^2), 2 t) / (1 + t^2). P = 3 mod 4, so 1 + t^2 is not zero.
fn circle(random: &mut SplitMix) -> (Residue, Residue) {
    let t = Residue::random(random);
    let scale = (Residue::ONE + t * t).inverse();
    ((Residue::ONE - t * t) * scale, (t + t) * scale)
}

/// One evaluation of a function in the field: constants as `constants` assigns them (by symbol),
/// inputs random.
pub(crate) struct FieldAlgebra<'a> {
    pub graph: &'a Graph,
    pub constants: &'a [Assignment],
    pub random: &'a mut SplitMix,
    /// Argument of a sine or cosine -> its point of the circle.
    angles: Vec<(Expr, (Residue, Residue))>,
}

impl<'a> FieldAlgebra<'a> {
    pub fn new(graph: &'a Graph, constants: &'a [Assignment], random: &'a mut SplitMix) -> Self {
        FieldAlgebra { graph, constants, random, angles: Vec::new() }
    }

    fn angle(&mut self, argument: Expr) -> (Residue, Residue) {
        if let Node::Symbol(s) = self.graph.node(argument)
            && matches!(self.graph.symbols()[s.0 as usize].1, SymbolKind::Constant(_))
        {
            let assignment = self.constants[s.0 as usize];
            return (assignment.cos, assignment.sin);
        }
        if let Some(known) = self.angles.iter().find(|a| a.0 == argument) {
            return known.1;
        }
        let point = circle(self.random);
        self.angles.push((argument, point));
        point
    }
}

impl Algebra for FieldAlgebra<'_> {
    type Value = Residue;
    fn constant(&mut self, x: f64) -> Residue {
        Residue::number(x)
    }
    fn symbol(&mut self, symbol: Symbol) -> Residue {
        match self.graph.symbols()[symbol.0 as usize].1 {
            SymbolKind::Constant(_) => self.constants[symbol.0 as usize].length,
            SymbolKind::Input => Residue::random(self.random),
        }
    }
    fn sin(&mut self, argument: Expr) -> Residue {
        self.angle(argument).1
    }
    fn cos(&mut self, argument: Expr) -> Residue {
        self.angle(argument).0
    }
    fn neg(&mut self, a: &Residue) -> Residue {
        -*a
    }
    fn add(&mut self, a: &Residue, b: &Residue) -> Residue {
        *a + *b
    }
    fn sub(&mut self, a: &Residue, b: &Residue) -> Residue {
        *a - *b
    }
    fn mul(&mut self, a: &Residue, b: &Residue) -> Residue {
        *a * *b
    }
    fn div(&mut self, a: &Residue, b: &Residue) -> Residue {
        *a * b.inverse()
    }
    fn sqrt(&mut self, a: &Residue) -> Residue {
        // Roots of constants are folded as numbers; one of a named constant is another constant.
        a.power(3)
    }
}

/// Solves A x = b by elimination; rows are [a_1 .. a_n b]. `None` when no x satisfies every row or
/// more than one does.
pub(crate) fn solve(mut rows: Vec<Vec<Residue>>, n: usize) -> Option<Vec<Residue>> {
    for c in 0..n {
        let pivot = (c..rows.len()).find(|&r| rows[r][c] != Residue::ZERO)?;
        rows.swap(c, pivot);
        let scale = rows[c][c].inverse();
        for x in &mut rows[c][c..] {
            *x = *x * scale;
        }
        let (head, tail) = rows.split_at_mut(c + 1);
        let pivot = &head[c];
        for row in tail {
            let factor = row[c];
            if factor != Residue::ZERO {
                for k in c..=n {
                    row[k] = row[k] - factor * pivot[k];
                }
            }
        }
    }
    if rows[n..].iter().any(|row| row[n] != Residue::ZERO) {
        return None;
    }
    let mut x = vec![Residue::ZERO; n];
    for c in (0..n).rev() {
        let known = (c + 1..n).fold(Residue::ZERO, |s, k| s + rows[c][k] * x[k]);
        x[c] = rows[c][n] - known;
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic() {
        let half = Residue::number(0.5);
        assert_eq!(half + half, Residue::ONE);
        assert_eq!(Residue::number(-3.0), Residue::integer(-3));
        assert_eq!(Residue::number(0.1) * Residue::number(1.0 / 1024.0), Residue::number(0.1 / 1024.0));
        let x = Residue::random(&mut SplitMix(7));
        assert_eq!(x * x.inverse(), Residue::ONE);
        assert_eq!((Residue::integer(-2) * Residue::integer(3).inverse()).as_ratio(100), Some((-2, 3)));
        let (c, s) = circle(&mut SplitMix(1));
        assert_eq!(c * c + s * s, Residue::ONE);
    }

    #[test]
    fn solves_and_refuses() {
        let row = |v: [i64; 3]| v.map(Residue::integer).to_vec();
        let rows = vec![row([0, 1, 2]), row([1, 1, 3]), row([1, 2, 5])];
        assert_eq!(solve(rows, 2), Some(vec![Residue::ONE, Residue::integer(2)]));
        assert_eq!(solve(vec![row([1, 1, 3]), row([2, 2, 6])], 2), None);
        assert_eq!(solve(vec![row([1, 0, 3]), row([0, 1, 6]), row([1, 1, 1])], 2), None);
    }
}
