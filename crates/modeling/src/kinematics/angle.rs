//! Angles as integer combinations of symbols and quarter turns, and their cosines and sines as expressions.
//!
//! cos and sin of a sum are expanded, so that an expression graph has only cosines and sines of single symbols. Parallel axes
//! then share the cos and sin of common sums. The cosine or sine of an angle q3 - DEL with a constant DEL then costs two
//! products. The graph can also be evaluated in a finite field, where a sine is not a function of a number.

use expr::{Expr, Graph, Node};

use crate::kinematics::vector::ZRotation;

/// An angle quarter_turns pi/2 + sum n_i symbol_i, with integers n_i.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Angle {
    /// Number of quarter turns, pi/2 each.
    pub quarter_turns: i64,
    /// Symbols with their integer factors n_i, in the order of creation; no factor is zero.
    pub terms: Vec<(Expr, i64)>,
}

impl Angle {
    /// The sum of two angles.
    pub fn plus(&self, other: &Angle) -> Angle {
        let mut sum = self.clone();
        sum.quarter_turns += other.quarter_turns;
        for &(symbol, n) in &other.terms {
            sum.add_term(symbol, n);
        }
        sum
    }

    /// The angle with the opposite sign.
    pub fn negated(&self) -> Angle {
        self.times(-1)
    }

    /// The angle times an integer.
    pub fn times(&self, factor: i64) -> Angle {
        let terms = self.terms.iter().map(|&(s, n)| (s, factor * n)).filter(|t| t.1 != 0).collect();
        Angle { quarter_turns: factor * self.quarter_turns, terms }
    }

    /// Whether the angle is a whole number of full turns.
    pub fn is_zero(&self) -> bool {
        self.quarter_turns.rem_euclid(4) == 0 && self.terms.is_empty()
    }

    /// Adds n times a symbol to the angle.
    pub fn add_term(&mut self, symbol: Expr, n: i64) {
        match self.terms.binary_search_by_key(&symbol, |t| t.0) {
            Ok(i) => {
                self.terms[i].1 += n;
                if self.terms[i].1 == 0 {
                    self.terms.remove(i);
                }
            }
            Err(i) => {
                if n != 0 {
                    self.terms.insert(i, (symbol, n));
                }
            }
        }
    }

    /// Cosine and sine of the angle as expressions; they are exactly 0, 1 or -1 for quarter turns.
    pub fn turn(&self, g: &mut Graph) -> ZRotation {
        let mut turn = match self.quarter_turns.rem_euclid(4) {
            0 => ZRotation { cos: Expr::ONE, sin: Expr::ZERO },
            1 => ZRotation { cos: Expr::ZERO, sin: Expr::ONE },
            2 => ZRotation { cos: -Expr::ONE, sin: Expr::ZERO },
            _ => ZRotation { cos: Expr::ZERO, sin: -Expr::ONE },
        };
        let mut name = String::new();
        for &(symbol, n) in &self.terms {
            let (cos, sin) = (g.cos(symbol), g.sin(symbol));
            let step = ZRotation { cos, sin: if n < 0 { -sin } else { sin } };
            for _ in 0..n.unsigned_abs() {
                turn = sum(g, turn, step);
                name_turn(g, turn, self.quarter_turns, (symbol, n), &mut name);
            }
        }
        turn
    }
}

/// Gives cosine and sine of a sum of symbols their names: C23 and S23 for q2 + q3, C2m3 and S2m3 for q2 - q3. Quarter turns in
/// the sum do not change the names. `name`: the name so far, without the letter C or S; the symbol is appended to it.
fn name_turn(g: &mut Graph, turn: ZRotation, quarter_turns: i64, (symbol, n): (Expr, i64), name: &mut String) {
    if !g.keeps_names() {
        return;
    }
    let symbol_name = match g.node(symbol) {
        Node::Symbol(s) => g.symbols()[s.0 as usize].0.clone(),
        _ => format!("q_{}_", symbol.node()),
    };
    *name += if n < 0 { "m" } else { "" };
    *name += &symbol_name.strip_prefix('q').map_or_else(|| format!("_{symbol_name}_"), str::to_string);
    let (cos, sin) = match quarter_turns.rem_euclid(4) {
        0 => (turn.cos, turn.sin),
        1 => (turn.sin, -turn.cos),
        2 => (-turn.cos, -turn.sin),
        _ => (-turn.sin, turn.cos),
    };
    for (letter, e) in [("C", cos), ("S", sin)] {
        if !matches!(g.node(e), Node::Cos(_) | Node::Sin(_)) {
            g.name(e, || format!("{letter}{name}"));
        }
    }
}

/// Cosine and sine of the sum of two angles: cos(a + b) = ca cb - sa sb, sin(a + b) = sa cb + ca sb.
fn sum(g: &mut Graph, a: ZRotation, b: ZRotation) -> ZRotation {
    let (cc, ss, sc, cs) = (g.mul(a.cos, b.cos), g.mul(a.sin, b.sin), g.mul(a.sin, b.cos), g.mul(a.cos, b.sin));
    ZRotation { cos: g.sub(cc, ss), sin: g.add(sc, cs) }
}
