//! Chooses one of several equal forms (expressions) of each entry of a matrix, so that all entries together need the fewest
//! operations.
//!
//! A node is computed once, even if several entries use it, so the cost of a form depends on the forms of the other entries. The
//! search starts with given forms. Sets of entries change their forms together, and change back if this does not reduce the
//! number of operations, until no change helps. The uses of each node are counted, so the work for a change is proportional to
//! the number of changed nodes. The result depends only on the order of the changes.

use crate::function::operands;
use crate::graph::{Expr, Graph, Node};

/// Largest number of passes; each pass tries all sets of changes.
const MAX_PASSES: usize = 4;

/// A change of form: (entry, index of its new form).
pub type FormChange = (usize, usize);

/// The chosen form of each entry, as its index in `forms`. `fixed`: expressions that are computed in any case; `start`: the
/// initial form of each entry; `moves`: the sets of changes that are tried.
pub fn fewest_operations(
    graph: &Graph,
    fixed: &[Expr],
    forms: &[Vec<Expr>],
    start: Vec<usize>,
    moves: &[Vec<FormChange>],
) -> Vec<usize> {
    let mut readers = Readers { graph, count: vec![0; graph.nodes().len()], operations: 0 };
    let mut chosen = start;
    for &e in fixed.iter().chain(forms.iter().zip(&chosen).map(|(ways, &way)| &ways[way])) {
        readers.take(e);
    }
    for _ in 0..MAX_PASSES {
        let mut has_moved = false;
        // Only a set that reduces the number of operations is kept. So the search never returns to earlier forms.
        for set in moves {
            let before = readers.operations;
            let back: Vec<FormChange> = set.iter().map(|&(entry, _)| (entry, chosen[entry])).collect();
            readers.follow(forms, &mut chosen, set);
            if readers.operations < before {
                has_moved = true;
            } else {
                readers.follow(forms, &mut chosen, &back);
            }
        }
        if !has_moved {
            break;
        }
    }
    chosen
}

/// For each node, the number of its uses (`count`). `operations`: number of operations of all used nodes.
struct Readers<'a> {
    graph: &'a Graph,
    count: Vec<u32>,
    operations: usize,
}

impl Readers<'_> {
    fn follow(&mut self, ways: &[Vec<Expr>], chosen: &mut [usize], set: &[FormChange]) {
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

    /// The entries are a c + b c and a d + b d, or (a + b) c and (a + b) d. Changing one entry saves one operation; changing both
    /// saves three.
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
        // If the products are computed anyway (`fixed`), the forms that add these products need the fewest operations.
        let made: Vec<Expr> = ways.iter().flat_map(|ways| operands(g.node(ways[0]))).collect();
        assert_eq!(fewest_operations(&g, &made, &ways, vec![0, 0], &singly), [0, 0]);
    }

    /// A common subexpression saves operations only if both entries use it. The search finds it if both forms change together.
    #[test]
    fn a_part_that_two_pay_for_needs_a_move_of_both() {
        let mut g = Graph::new();
        let [a, b, c, d] = ["a", "b", "c", "d"].map(|name| g.symbol(name, SymbolKind::Input));
        // Each entry needs three operations, or one operation and a common subexpression of two.
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
