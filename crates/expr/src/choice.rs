//! Which of several ways to write an entry takes fewest operations, where entries share what they read.
//!
//! A node is made once, however many read it, so that the cost of a way depends on the ways of the other entries. From a
//! start, sets of entries are moved to other ways together, and back where that takes no fewer operations, until no move
//! helps. Readers of a node are counted, so a move costs what it changes and not the whole graph. The result hangs on the order
//! of the moves alone.

use crate::function::operands;
use crate::graph::{Expr, Graph, Node};

/// So many times are all moves tried at most.
const PASSES: usize = 4;

/// An entry and the way that it is moved to.
pub type Move = (usize, usize);

/// The way of each entry, by its place in `ways`. `fixed` is made in any case, `start` has the way of each entry at first.
pub fn fewest_operations(
    graph: &Graph,
    fixed: &[Expr],
    ways: &[Vec<Expr>],
    start: Vec<usize>,
    moves: &[Vec<Move>],
) -> Vec<usize> {
    let mut readers = Readers { graph, count: vec![0; graph.nodes().len()], operations: 0 };
    let mut chosen = start;
    for &e in fixed.iter().chain(ways.iter().zip(&chosen).map(|(ways, &way)| &ways[way])) {
        readers.take(e);
    }
    for _ in 0..PASSES {
        let mut has_moved = false;
        for set in moves {
            let before = readers.operations;
            let back: Vec<Move> = set.iter().map(|&(entry, _)| (entry, chosen[entry])).collect();
            readers.follow(ways, &mut chosen, set);
            if readers.operations < before {
                has_moved = true;
            } else {
                readers.follow(ways, &mut chosen, &back);
            }
        }
        if !has_moved {
            break;
        }
    }
    chosen
}

/// How many read each node, and how many operations are made for them.
struct Readers<'a> {
    graph: &'a Graph,
    count: Vec<u32>,
    operations: usize,
}

impl Readers<'_> {
    fn follow(&mut self, ways: &[Vec<Expr>], chosen: &mut [usize], set: &[Move]) {
        for &(entry, way) in set {
            self.take(ways[entry][way]);
            self.release(ways[entry][chosen[entry]]);
            chosen[entry] = way;
        }
    }

    fn take(&mut self, e: Expr) {
        let mut stack = vec![e.node()];
        while let Some(n) = stack.pop() {
            self.count[n] += 1;
            if self.count[n] == 1 {
                self.operations += self.cost(n);
                stack.extend(operands(self.graph.nodes()[n]).map(Expr::node));
            }
        }
    }

    fn release(&mut self, e: Expr) {
        let mut stack = vec![e.node()];
        while let Some(n) = stack.pop() {
            self.count[n] -= 1;
            if self.count[n] == 0 {
                self.operations -= self.cost(n);
                stack.extend(operands(self.graph.nodes()[n]).map(Expr::node));
            }
        }
    }

    fn cost(&self, n: usize) -> usize {
        let is_operation = matches!(self.graph.nodes()[n], Node::Add(..) | Node::Mul(..) | Node::Div(..));
        usize::from(is_operation && self.graph.varies(Expr::new(n, false)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SymbolKind;

    /// a c + b c and a d + b d, or (a + b) c and (a + b) d: alone each takes one operation less, both together three.
    #[test]
    fn what_ways_share_counts_once() {
        let mut g = Graph::new();
        let [a, b, c, d] = ["a", "b", "c", "d"].map(|name| g.symbol(name, SymbolKind::Input));
        let ways: Vec<Vec<Expr>> = [c, d]
            .into_iter()
            .map(|factor| {
                let (x, y, sum) = (g.mul(a, factor), g.mul(b, factor), g.add(a, b));
                vec![g.add(x, y), g.mul(sum, factor)]
            })
            .collect();
        let singly = [vec![(0, 1)], vec![(1, 1)]];
        assert_eq!(fewest_operations(&g, &[], &ways, vec![0, 0], &singly), [1, 1]);
        // The products are made in any case: the sums of them alone are fewest.
        let made: Vec<Expr> = ways.iter().flat_map(|ways| operands(g.node(ways[0]))).collect();
        assert_eq!(fewest_operations(&g, &made, &ways, vec![0, 0], &singly), [0, 0]);
    }

    /// A common part that pays for two entries and not for one is found by moving both.
    #[test]
    fn a_part_that_two_pay_for_needs_a_move_of_both() {
        let mut g = Graph::new();
        let [a, b, c, d] = ["a", "b", "c", "d"].map(|name| g.symbol(name, SymbolKind::Input));
        // Each entry takes two operations, or one on top of a part of two.
        let part = {
            let ab = g.mul(a, b);
            g.add(ab, c)
        };
        let ways: Vec<Vec<Expr>> = [c, d]
            .into_iter()
            .map(|e| {
                let long = (0..3).fold(e, |x, _| g.mul(x, x));
                vec![long, g.mul(part, e)]
            })
            .collect();
        let singly = [vec![(0, 1)], vec![(1, 1)]];
        assert_eq!(fewest_operations(&g, &[], &ways, vec![0, 0], &singly), [0, 0]);
        assert_eq!(fewest_operations(&g, &[], &ways, vec![0, 0], &[vec![(0, 1), (1, 1)]]), [1, 1]);
    }
}
