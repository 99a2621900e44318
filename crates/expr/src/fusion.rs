//! Fuses products into sums: a b + c becomes one operation with one rounding. The tape (the interpreter of functions) and
//! generated code perform the operations that are determined here.
//!
//! A product that is used only by one sum is fused into this sum. If both operands of a sum are such products, the product that
//! depends on the longer chain of operations is fused. A product that is used only by sums is fused into all of them if none of
//! them has another fused product; the product itself is then not computed. The tape, generated Rust and generated C perform the
//! operations in the same order.
//!
//! If more outputs need the negative of a sum than the sum, the node of the sum stores the negative. This is done only if it
//! costs no operation: in a b + c all signs can be chosen freely; in a - b the two operands are exchanged.

use crate::function::{Function, operands};
use crate::graph::{Expr, Node};

/// The operation that computes a node. Each operand is the value that a node stores, with a sign; see [`Fusion::held`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operation {
    /// No operation: a number, an input, a sine or a cosine, or a product that is fused into sums.
    None,
    /// a + b; only b may have a minus.
    Add(Expr, Expr),
    /// a b + c; only a and c may have a minus.
    MulAdd(Expr, Expr, Expr),
    /// a b. Both operands are without sign.
    Mul(Expr, Expr),
    /// a / b. Both operands are without sign.
    Div(Expr, Expr),
    /// Square root.
    Sqrt(Expr),
}

/// The operation of each node of a function without named constants.
#[derive(Clone, Debug)]
pub struct Fusion {
    operations: Vec<Operation>,
    /// Whether each node stores the negative of its value.
    negated: Vec<bool>,
    /// Number of products that are computed only as part of sums.
    products: usize,
}

impl Fusion {
    /// Determines the operation of each node of `function`, which must have no named constants.
    pub fn of(function: &Function) -> Fusion {
        let nodes = function.graph().nodes();
        let uses = Uses::of(function);
        // The fused products are determined first, because a product precedes the sum into which it is fused.
        let (taken_up, is_part) = products_taken_up(nodes, &uses);
        let mut fusion = Fusion {
            operations: vec![Operation::None; nodes.len()],
            negated: vec![false; nodes.len()],
            products: is_part.iter().filter(|part| **part).count(),
        };
        for (n, &node) in nodes.iter().enumerate() {
            if !is_part[n] {
                let wanted = uses.negative[n] > uses.positive[n];
                (fusion.operations[n], fusion.negated[n]) = fusion.operation(nodes, node, taken_up[n], wanted);
            }
        }
        fusion
    }

    /// The operation that computes `node`, and whether its result is the negative of the node. The operations of the operands
    /// must be known. `product`: the product that is fused into the node; `wanted`: whether the negative is preferred if it costs
    /// no operation.
    fn operation(&self, nodes: &[Node], node: Node, product: Option<Expr>, wanted: bool) -> (Operation, bool) {
        let held = |e: Expr| self.held(e);
        match (node, product) {
            (Node::Add(a, b), Some(product)) => {
                let Node::Mul(x, y) = nodes[product.node()] else { return (Operation::None, false) };
                let rest = held(if product.node() == a.node() { b } else { a });
                let negative = held(x).is_negative() ^ held(y).is_negative() ^ product.is_negative() ^ wanted;
                (Operation::MulAdd(signed(x, negative), y.abs(), signed(rest, rest.is_negative() ^ wanted)), wanted)
            }
            (Node::Add(a, b), None) => match (held(a), held(b)) {
                (a, b) if a.is_negative() && b.is_negative() => (Operation::Add(a.abs(), b.abs()), true),
                (a, b) if !a.is_negative() && !b.is_negative() => (Operation::Add(a, b), false),
                (a, b) => {
                    let (plus, minus) = if a.is_negative() { (b, a.abs()) } else { (a, b.abs()) };
                    let (first, second) = if wanted { (minus, plus) } else { (plus, minus) };
                    (Operation::Add(first, -second), wanted)
                }
            },
            (Node::Mul(a, b), _) => (Operation::Mul(a.abs(), b.abs()), held(a).is_negative() ^ held(b).is_negative()),
            (Node::Div(a, b), _) => (Operation::Div(a.abs(), b.abs()), held(a).is_negative() ^ held(b).is_negative()),
            (Node::Sqrt(a), _) => (Operation::Sqrt(held(a)), false),
            // sin(-x) = -sin(x), and cos(-x) = cos(x).
            (Node::Sin(a), _) => (Operation::None, held(a).is_negative()),
            (Node::Cos(_) | Node::Constant(_) | Node::Symbol(_), _) => (Operation::None, false),
        }
    }

    /// The operation that computes the node.
    pub fn operation_of(&self, node: usize) -> Operation {
        self.operations[node]
    }

    /// `e` in terms of the value that is stored at its node. If the node stores the negative of its expression, the sign of `e`
    /// is changed.
    pub fn held(&self, e: Expr) -> Expr {
        signed(e, e.is_negative() ^ self.negated[e.node()])
    }

    /// The operands of the node's operation.
    pub(crate) fn operands_of(&self, node: usize) -> impl Iterator<Item = Expr> {
        let (a, b, c) = match self.operations[node] {
            Operation::None => (None, None, None),
            Operation::Sqrt(a) => (Some(a), None, None),
            Operation::Add(a, b) | Operation::Mul(a, b) | Operation::Div(a, b) => (Some(a), Some(b), None),
            Operation::MulAdd(a, b, c) => (Some(a), Some(b), Some(c)),
        };
        a.into_iter().chain(b).chain(c)
    }

    /// Number of sums into which a product is fused.
    pub fn fused_sums(&self) -> usize {
        self.operations.iter().filter(|o| matches!(o, Operation::MulAdd(..))).count()
    }

    /// Number of products that are computed only as part of one or several sums.
    pub fn fused_products(&self) -> usize {
        self.products
    }
}

/// For each node: the product that is fused into it, if any, and whether the node itself is a product that is fused into sums.
fn products_taken_up(nodes: &[Node], uses: &Uses) -> (Vec<Option<Expr>>, Vec<bool>) {
    let mut depth = vec![0_usize; nodes.len()];
    let mut taken_up = vec![None; nodes.len()];
    let mut is_part = vec![false; nodes.len()];
    // For each product: the sums that use it, each with the sign of the product in it.
    let mut readers: Vec<Vec<(usize, Expr)>> = vec![Vec::new(); nodes.len()];
    for (n, &node) in nodes.iter().enumerate() {
        depth[n] = operands(node).map(|e| depth[e.node()] + 1).max().unwrap_or(0);
        if let Node::Add(a, b) = node {
            let is_product = |e: &Expr| matches!(nodes[e.node()], Node::Mul(..));
            let alone = |e: &Expr| is_product(e) && uses.count[e.node()] == 1;
            taken_up[n] = [a, b].into_iter().filter(alone).max_by_key(|e| depth[e.node()]);
            is_part[taken_up[n].map_or(n, Expr::node)] |= taken_up[n].is_some();
            for product in [a, b].into_iter().filter(is_product) {
                readers[product.node()].push((n, product));
            }
        }
    }
    for (product, sums) in readers.iter().enumerate() {
        // A sum of a product with itself (p + p) is excluded: if p were fused, p would still be needed as the addend.
        let is_free =
            |&(n, _): &(usize, Expr)| taken_up[n].is_none() && operands(nodes[n]).any(|e| e.node() != product);
        if sums.len() > 1 && sums.len() == uses.count[product] && sums.iter().all(is_free) {
            is_part[product] = true;
            for &(n, signed) in sums {
                taken_up[n] = Some(signed);
            }
        }
    }
    (taken_up, is_part)
}

fn signed(e: Expr, negative: bool) -> Expr {
    if negative { -e.abs() } else { e.abs() }
}

/// For each node: the number of its uses, and the numbers of outputs that store it with a plus and with a minus.
struct Uses {
    count: Vec<usize>,
    positive: Vec<usize>,
    negative: Vec<usize>,
}

impl Uses {
    fn of(function: &Function) -> Uses {
        let nodes = function.graph().nodes();
        let zeros = vec![0; nodes.len()];
        let mut uses = Uses { count: zeros.clone(), positive: zeros.clone(), negative: zeros };
        for e in nodes.iter().flat_map(|node| operands(*node)) {
            uses.count[e.node()] += 1;
        }
        for e in function.outputs.iter().flat_map(|o| &o.entries) {
            uses.count[e.node()] += 1;
            let stored = if e.is_negative() { &mut uses.negative } else { &mut uses.positive };
            stored[e.node()] += 1;
        }
        uses
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Graph, Input, Output, SymbolKind};

    fn function(make: impl Fn(&mut Graph, [Expr; 4]) -> Vec<Expr>) -> Function {
        let mut g = Graph::new();
        let inputs = ["a", "b", "c", "d"].map(|name| g.symbol(name, SymbolKind::Input));
        let entries = make(&mut g, inputs);
        let output = Output { name: "y".into(), rows: entries.len(), columns: 1, entries };
        Function::new("f", &g, vec![Input { name: "x".into(), entries: inputs.to_vec() }], vec![output])
    }

    /// Two results for a test: all operations of `f` except `None`; and the first output entry in terms of the value that is
    /// stored at its node.
    fn operations(f: &Function) -> (Vec<Operation>, Expr) {
        let fusion = Fusion::of(f);
        let all = (0..f.graph().nodes().len()).map(|n| fusion.operation_of(n)).filter(|o| *o != Operation::None);
        (all.collect(), fusion.held(f.outputs[0].entries[0]))
    }

    #[test]
    fn a_product_read_once_is_part_of_its_sum() {
        let f = function(|g, [a, b, c, _]| {
            let ab = g.mul(a, b);
            vec![g.sub(c, ab)]
        });
        let (all, y) = operations(&f);
        let [a, b, c] = [0, 1, 2].map(|k| f.inputs[0].entries[k]);
        assert_eq!(all, [Operation::MulAdd(-a, b, c)]);
        assert!(!y.is_negative());
    }

    #[test]
    fn a_product_that_sums_alone_read_is_part_of_each() {
        let f = function(|g, [a, b, c, d]| {
            let ab = g.mul(a, b);
            vec![g.add(c, ab), g.sub(d, ab)]
        });
        let (all, _) = operations(&f);
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| f.inputs[0].entries[k]);
        assert_eq!(all, [Operation::MulAdd(a, b, c), Operation::MulAdd(-a, b, d)]);
    }

    #[test]
    fn a_product_that_something_else_needs_is_made_once() {
        let f = function(|g, [a, b, c, d]| {
            let ab = g.mul(a, b);
            let cd = g.mul(c, d);
            // The product a b is an output, and it is also the addend of the product c d, which is used only once. So a b must be
            // computed.
            vec![ab, g.add(c, ab), g.sub(d, ab), g.add(cd, ab)]
        });
        let (all, _) = operations(&f);
        let made = all.iter().filter(|o| matches!(o, Operation::Mul(..))).count();
        assert_eq!((made, all.len()), (1, 4), "{all:?}");
        let twice = function(|g, [a, b, ..]| {
            let ab = g.mul(a, b);
            vec![g.add(ab, ab)]
        });
        assert_eq!(operations(&twice).0.len(), 2);
    }

    #[test]
    fn what_is_stored_negative_is_held_negative() {
        let f = function(|g, [a, b, c, d]| {
            let ab = g.mul(a, b);
            let cd = g.mul(c, d);
            vec![-g.add(ab, cd), -g.sub(a, b)]
        });
        let fusion = Fusion::of(&f);
        for e in &f.outputs[0].entries {
            assert!(!fusion.held(*e).is_negative());
        }
        assert_eq!((fusion.fused_sums(), fusion.fused_products()), (1, 1));
    }
}
