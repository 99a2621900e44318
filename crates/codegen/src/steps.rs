//! Converts a Function to straight-line steps, one per operation, in the order of its schedule. The Rust and the C code are
//! written from the same steps.
//!
//! An entry of an output is stored as soon as it is computed. Sines and cosines of several inputs are one step. [`expr::Fusion`]
//! determines which product is fused into which sum.

use std::collections::BTreeMap;

use expr::{Expr, Function, Fusion, Node, Operation, SymbolKind, operands};

/// A text from a user's file as one line: characters that would end the line are replaced by spaces.
pub fn in_line(text: &str) -> String {
    gate::shown::line(text).into_owned()
}

/// One step (statement) of a generated function.
pub(crate) enum Statement {
    /// Assigns the result of the operation to the variable of the node with this number.
    Compute(usize, Operation),
    /// Computes sines and cosines of at most eight angles.
    SinCos(Vec<Angle>),
    /// Stores the value of a node, or its negative, in an entry of an output.
    Store { output: usize, row: usize, column: usize, node: usize, negative: bool },
}

/// An angle whose sine or cosine is computed: the numbers of the nodes of the angle, of its sine and of its cosine. `None`: not
/// needed.
#[derive(Clone, Copy)]
pub(crate) struct Angle {
    pub angle: usize,
    pub sine: Option<usize>,
    pub cosine: Option<usize>,
}

/// If at most this many inputs are angles, all their sines and cosines are computed first. If there are more, they are computed
/// in groups, each before the first use of one of them, because a value computed long before its use is spilled from its
/// register.
const MAX_SINES_AT_ONCE: usize = 8;
/// Number of angles in a group whose sines are computed together, if there are more than [`MAX_SINES_AT_ONCE`].
const SINES_PER_GROUP: usize = 4;

/// The way in which statements refer to the value of a node: a constant, an entry of an input, or a variable.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Name {
    Constant(f64),
    Input { input: usize, entry: usize },
    Variable(String),
}

/// The steps that compute `function`, which must not have named constants.
pub(crate) fn steps(function: &Function) -> Vec<Statement> {
    let nodes = function.graph().nodes();
    let fusion = Fusion::of(function);
    // For each node, the stores of its value in outputs. Constants are stored first.
    let mut places: Vec<Vec<Statement>> = nodes.iter().map(|_| Vec::new()).collect();
    for (output, o) in function.outputs.iter().enumerate() {
        for (i, e) in o.entries.iter().enumerate() {
            let (row, column) = (i / o.columns, i % o.columns);
            let (node, negative) = (e.node(), fusion.held(*e).is_negative());
            places[node].push(Statement::Store { output, row, column, node, negative });
        }
    }
    let (first, mut groups) = groups(nodes);
    let mut steps: Vec<Statement> = first.into_iter().map(Statement::SinCos).collect();
    for (n, places) in places.into_iter().enumerate() {
        match (nodes[n], fusion.operation_of(n)) {
            (Node::Sin(_) | Node::Cos(_), _) => steps.extend(groups.remove(&n).map(Statement::SinCos)),
            (_, Operation::None) => {}
            (_, operation) => steps.push(Statement::Compute(n, operation)),
        }
        steps.extend(places);
    }
    steps
}

/// Groups of angles whose sines and cosines are computed together. First result: the group that is computed before all other
/// steps; `None` if there is none. Second result: the other groups, each with the number of the node before which it is computed
/// (its first sine or cosine).
fn groups(nodes: &[Node]) -> (Option<Vec<Angle>>, BTreeMap<usize, Vec<Angle>>) {
    let mut pairs: BTreeMap<usize, Angle> = BTreeMap::new();
    for (n, node) in nodes.iter().enumerate() {
        let (Node::Sin(a) | Node::Cos(a)) = node else { continue };
        let pair = pairs.entry(a.node()).or_insert(Angle { angle: a.node(), sine: None, cosine: None });
        match node {
            Node::Sin(_) => pair.sine = Some(n),
            _ => pair.cosine = Some(n),
        }
    }
    let first = |pair: &Angle| pair.sine.into_iter().chain(pair.cosine).min().unwrap_or(pair.angle);
    let mut pairs: Vec<Angle> = pairs.into_values().collect();
    pairs.sort_by_key(first);
    // An angle that is not an input is known only after its own step, so it forms a group alone.
    let (of_inputs, others): (Vec<Angle>, Vec<Angle>) =
        pairs.into_iter().partition(|pair| matches!(nodes[pair.angle], Node::Symbol(_)));
    let at_node = |group: &[Angle]| (first(&group[0]), group.to_vec());
    let alone = others.chunks(1).map(at_node);
    match of_inputs.len() {
        0 => (None, alone.collect()),
        1..=MAX_SINES_AT_ONCE => (Some(of_inputs), alone.collect()),
        _ => (None, of_inputs.chunks(SINES_PER_GROUP).map(at_node).chain(alone).collect()),
    }
}

/// The name of each node in the generated code: `t12` for node 12, `s1` and `c1` for sine and cosine of entry 1 of the first
/// input.
pub(crate) fn names(function: &Function) -> Vec<Name> {
    let graph = function.graph();
    let mut inputs = vec![None; graph.nodes().len()];
    for (input, i) in function.inputs.iter().enumerate() {
        for (entry, e) in i.entries.iter().enumerate() {
            inputs[e.node()].get_or_insert((input, entry));
        }
    }
    let angle = |a: Expr| match inputs[a.node()] {
        Some((0, entry)) => entry.to_string(),
        Some((input, entry)) => format!("_{}{entry}", function.inputs[input].name),
        None => format!("_t{}", a.node()),
    };
    let name = |(n, &node): (usize, &Node)| match node {
        Node::Constant(x) => Name::Constant(x),
        Node::Symbol(s) => {
            debug_assert_eq!(graph.symbols()[s.0 as usize].1, SymbolKind::Input);
            match inputs[n] {
                Some((input, entry)) => Name::Input { input, entry },
                None => unreachable!("a bound function reads its inputs only"),
            }
        }
        Node::Sin(a) => Name::Variable(format!("s{}", angle(a))),
        Node::Cos(a) => Name::Variable(format!("c{}", angle(a))),
        Node::Add(..) | Node::Mul(..) | Node::Div(..) | Node::Sqrt(_) => Name::Variable(format!("t{n}")),
    };
    graph.nodes().iter().enumerate().map(name).collect()
}

/// Whether a node or an output of the function uses this entry of an input.
pub(crate) fn is_read(function: &Function, input: usize, entry: usize) -> bool {
    is_read_by(function, input, entry, |_| true)
}

/// Whether an output of the function, or a node other than a sine or cosine, uses this entry of an input.
pub(crate) fn is_read_beside_sines(function: &Function, input: usize, entry: usize) -> bool {
    is_read_by(function, input, entry, |node| !matches!(node, Node::Sin(_) | Node::Cos(_)))
}

fn is_read_by(function: &Function, input: usize, entry: usize, counts: impl Fn(&Node) -> bool) -> bool {
    let e = function.inputs[input].entries[entry];
    function.graph().nodes().iter().any(|node| counts(node) && operands(*node).any(|o| o.abs() == e))
        || function.outputs.iter().flat_map(|o| &o.entries).any(|o| o.abs() == e)
}
