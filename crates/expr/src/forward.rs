//! The forward mode of differentiation: computes expressions for the rates of change of entries (expressions of a graph) when
//! symbols change.
//!
//! Let x' be the rate of change of a symbol x. The rates of the other nodes are (a + b)' = a' + b', (a b)' = a' b + a b', (a /
//! b)' = (a' - (a / b) b') / b, sqrt(a)' = a' / (2 sqrt a), (sin a)' = a' cos a, (cos a)' = -a' sin a [Griewank, Walther 2008].

use crate::graph::{Expr, Graph, Node};

impl Graph {
    /// The rates of change of `entries`, one expression per entry. `seeds`: symbols with their rates of change; all other symbols
    /// are constant.
    pub fn derivatives(&mut self, entries: &[Expr], seeds: &[(Expr, Expr)]) -> Vec<Expr> {
        let last = entries.iter().map(|e| e.node()).max().unwrap_or(0);
        // Mark the nodes that the entries need.
        let mut needed = vec![false; last + 1];
        entries.iter().for_each(|e| needed[e.node()] = true);
        for n in (0..=last).rev() {
            if needed[n] {
                crate::function::operands(self.nodes()[n]).for_each(|e| needed[e.node()] = true);
            }
        }
        // The rates of the symbols are given in `seeds`, and are zero for other symbols.
        let mut slopes = vec![Expr::ZERO; last + 1];
        for (symbol, change) in seeds {
            if let Some(slope) = slopes.get_mut(symbol.node()) {
                *slope = Graph::negate_if(*change, symbol.is_negative());
            }
        }
        // The rate of each other node is computed after the rates of its operands.
        for n in (0..=last).filter(|&n| needed[n]) {
            let slope = |e: Expr| Graph::negate_if(slopes[e.node()], e.is_negative());
            slopes[n] = match self.nodes()[n] {
                Node::Constant(_) => Expr::ZERO,
                Node::Symbol(_) => continue,
                Node::Add(a, b) => {
                    let (a, b) = (slope(a), slope(b));
                    self.add(a, b)
                }
                Node::Mul(a, b) => {
                    let (u, v) = (slope(a), slope(b));
                    let (u, v) = (self.mul(u, b), self.mul(a, v));
                    self.add(u, v)
                }
                Node::Div(a, b) => {
                    let (u, v) = (slope(a), slope(b));
                    let v = self.mul(Expr::new(n, false), v);
                    let change = self.sub(u, v);
                    self.div(change, b)
                }
                Node::Sqrt(a) => {
                    let (two, u) = (self.constant(2.0), slope(a));
                    let twice = self.mul(two, Expr::new(n, false));
                    self.div(u, twice)
                }
                Node::Sin(a) => {
                    let (u, cos) = (slope(a), self.cos(a));
                    self.mul(u, cos)
                }
                Node::Cos(a) => {
                    let (u, sin) = (slope(a), self.sin(a));
                    -self.mul(u, sin)
                }
            };
        }
        entries.iter().map(|e| Graph::negate_if(slopes[e.node()], e.is_negative())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Adjoint, Function, Input, Output, SymbolKind, Tape};

    #[test]
    fn forward_is_reverse() {
        let mut g = Graph::new();
        let (x, y) = (g.symbol("x", SymbolKind::Input), g.symbol("y", SymbolKind::Input));
        let (s, c, difference) = (g.sin(x), g.cos(y), g.sub(x, y));
        let (product, squares) = (g.mul(s, difference), [g.mul(x, x), g.mul(y, y)]);
        let square = g.add(squares[0], squares[1]);
        let (quotient, root) = (g.div(product, c), g.sqrt(square));
        let entry = g.sub(root, quotient);
        let function = |g: &Graph, name: &str, entries: Vec<Expr>| {
            let inputs = vec![Input { name: "v".into(), entries: vec![x, y] }];
            let output = Output { name: "w".into(), rows: entries.len(), columns: 1, entries };
            Function::new(name, g, inputs, vec![output])
        };
        let value = function(&g, "f", vec![entry]);
        let gradient: Vec<Expr> =
            [x, y].into_iter().flat_map(|symbol| g.derivatives(&[entry], &[(symbol, Expr::ONE)])).collect();
        let (adjoint, tape) = (Adjoint::new(&value), Tape::new(&function(&g, "slope", gradient)));
        let (inputs, mut reverse, mut forward) = ([0.7, -0.4], [f64::NAN; 2], [f64::NAN; 2]);
        adjoint.pull_back(&inputs, &[1.0], &mut adjoint.workspace(), &mut reverse);
        tape.evaluate(&inputs, &mut tape.workspace(), &mut forward);
        for (a, b) in forward.iter().zip(reverse) {
            // Allowed error: rounding of a dozen operations on numbers of order one.
            assert!((a - b).abs() < 1e-14, "{a} {b}");
        }
    }
}
