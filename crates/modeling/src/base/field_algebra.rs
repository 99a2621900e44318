//! Evaluates a function in the finite field ([`crate::base::field`]), with random values for the inputs of the function.

use std::collections::BTreeMap;

use expr::{Algebra, Expr, Graph, Node, Symbol, SymbolKind};

use crate::base::angles::GraphAngles;
use crate::base::field::{Assignment, CirclePoint, Residue, circle, times};
use random::SplitMix;

/// One evaluation of a function in the finite field, with given constants (by symbol) and random inputs.
pub(crate) struct FieldAlgebra<'a> {
    graph: &'a Graph,
    angles: &'a GraphAngles,
    constants: &'a [Assignment],
    random: &'a mut SplitMix,
    /// Symbol -> the point (cos, sin) of the angle symbol / D. D: common denominator of the ratios with which the symbol
    /// occurs.
    points: BTreeMap<Symbol, CirclePoint>,
    /// Argument of a sine or cosine that is no rational multiple of a symbol -> its random point (cos, sin).
    others: BTreeMap<Expr, CirclePoint>,
}

impl<'a> FieldAlgebra<'a> {
    pub(crate) fn new(
        graph: &'a Graph,
        angles: &'a GraphAngles,
        constants: &'a [Assignment],
        random: &'a mut SplitMix,
    ) -> Self {
        FieldAlgebra { graph, angles, constants, random, points: BTreeMap::new(), others: BTreeMap::new() }
    }

    fn angle(&mut self, argument: Expr) -> CirclePoint {
        if let Node::Symbol(s) = self.graph.node(argument)
            && matches!(self.graph.symbols()[s.0 as usize].1, SymbolKind::Constant(_))
        {
            let assignment = self.constants[s.0 as usize];
            return (assignment.cos, assignment.sin);
        }
        match self.angles.power(argument) {
            Some((symbol, power)) => {
                let point = *self.points.entry(symbol).or_insert_with(|| circle(self.random));
                times(point, power)
            }
            None => *self.others.entry(argument).or_insert_with(|| circle(self.random)),
        }
    }
}

impl Algebra for FieldAlgebra<'_> {
    type Value = Residue;
    fn constant(&mut self, x: f64) -> Residue {
        self.angles.number(x)
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
        // Roots of numbers have been evaluated before. A named constant need not have a square root in the field. So the root
        // of a constant is treated as another random element: its value is the cube of the constant.
        a.power(3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_of_an_angle_are_powers_of_its_point() {
        let mut g = Graph::new();
        let q = g.symbol("q", SymbolKind::Input);
        let ratios = [4.0 / 3.0, 0.5, 0.35, 1.0];
        let turns: Vec<[Expr; 2]> = ratios
            .iter()
            .map(|&c| {
                let factor = g.constant(c);
                let angle = g.mul(factor, q);
                [g.cos(angle), g.sin(angle)]
            })
            .collect();
        let angles = GraphAngles::of(&g);
        let random = &mut SplitMix(3);
        let mut algebra = FieldAlgebra::new(&g, &angles, &[], random);
        let mut point = |k: usize| {
            let Node::Cos(argument) = g.node(turns[k][0]) else { unreachable!() };
            algebra.angle(argument)
        };
        let [third, half, decimal, whole] = [0, 1, 2, 3].map(&mut point);
        assert_eq!(times(third, 3), times(whole, 4));
        assert_eq!(times(half, 2), whole);
        assert_eq!(times(decimal, 20), times(whole, 7));
        assert_ne!(third, whole);
    }
}
