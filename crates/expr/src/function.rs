//! A mathematical function (for example a regressor) from named inputs to named outputs. It is stored as a graph whose nodes are
//! operations, constants and symbols. The graph has only the nodes that the outputs need.

use std::collections::BTreeMap;

use crate::graph::{Expr, Graph, Node, Symbol, SymbolKind};

/// A vector of inputs under one name.
#[derive(Clone, Debug)]
pub struct Input {
    /// Name of the argument in generated code: `q`.
    pub name: String,
    /// Input symbols, one per entry.
    pub entries: Vec<Expr>,
}

/// An output matrix and its name. The entries are stored row by row.
#[derive(Clone, Debug)]
pub struct Output {
    /// Name of the argument in generated code: `y`.
    pub name: String,
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// rows x columns expressions, row after row.
    pub entries: Vec<Expr>,
}

impl Output {
    /// The entries in the order in which they are computed: block by block, each block row by row. Adjacent columns form a
    /// block if their last non-zero entries are in the same row. In a regressor, these are the columns of one link. All entries
    /// of a block use the motion of this link, and each row uses the twist of one coordinate. Therefore only few values must be
    /// kept in registers.
    fn by_blocks(&self) -> Vec<Expr> {
        let last_row = |c: usize| (0..self.rows).rev().find(|r| !self.entries[r * self.columns + c].is_zero());
        let columns: Vec<usize> = (0..self.columns).collect();
        let blocks = columns.chunk_by(|&c, &d| last_row(c) == last_row(d));
        blocks
            .flat_map(|block| (0..self.rows).flat_map(move |r| block.iter().map(move |c| r * self.columns + c)))
            .map(|i| self.entries[i])
            .collect()
    }
}

/// A function from named inputs to named outputs.
#[derive(Clone, Debug)]
pub struct Function {
    /// Name in generated code: `base_regressor`.
    pub name: String,
    /// The inputs, in the order of the arguments.
    pub inputs: Vec<Input>,
    /// The outputs, in the order of the arguments, after the inputs.
    pub outputs: Vec<Output>,
    graph: Graph,
}

/// Number of operations of one evaluation. A product or a square is one multiplication, a binary + or - is one addition. Signs
/// are not counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Multiplications and divisions; a square root is not counted.
    pub mul: usize,
    /// Additions and subtractions.
    pub add: usize,
    /// Number of angles of which the sine, the cosine or both are computed.
    pub sin_cos: usize,
}

/// The values and operations with which a function can be evaluated: for example f64, a finite field, or polynomials.
pub trait Algebra {
    /// An element of the algebra.
    type Value: Clone;
    /// The element for the number x.
    fn constant(&mut self, x: f64) -> Self::Value;
    /// The element for an input or a named constant.
    fn symbol(&mut self, symbol: Symbol) -> Self::Value;
    /// Sine of the expression `argument`. An implementation must use the same angle whenever it is called with an equal
    /// expression, also in [`Algebra::cos`], so that sin^2 + cos^2 = 1.
    fn sin(&mut self, argument: Expr) -> Self::Value;
    /// Cosine of the expression `argument`; see [`Algebra::sin`].
    fn cos(&mut self, argument: Expr) -> Self::Value;
    /// -a.
    fn neg(&mut self, a: &Self::Value) -> Self::Value;
    /// a + b.
    fn add(&mut self, a: &Self::Value, b: &Self::Value) -> Self::Value;
    /// a - b.
    fn sub(&mut self, a: &Self::Value, b: &Self::Value) -> Self::Value;
    /// a b.
    fn mul(&mut self, a: &Self::Value, b: &Self::Value) -> Self::Value;
    /// a / b.
    fn div(&mut self, a: &Self::Value, b: &Self::Value) -> Self::Value;
    /// Square root of a.
    fn sqrt(&mut self, a: &Self::Value) -> Self::Value;
}

/// The positions of the entries that determine an output matrix. Other entries are zero, or follow by symmetry.
#[derive(Clone, Debug, PartialEq)]
pub struct SparsityPattern {
    /// (row, column) of each entry that determines the matrix.
    pub places: Vec<(usize, usize)>,
    /// Whether the matrix is symmetric. If so, `places` has no entries below the diagonal.
    pub is_symmetric: bool,
}

impl Function {
    /// Makes a function. It copies only those nodes of `graph` that the outputs need.
    pub fn new(name: &str, graph: &Graph, inputs: Vec<Input>, outputs: Vec<Output>) -> Function {
        debug_assert!(outputs.iter().all(|o| o.entries.len() == o.rows * o.columns));
        Function { name: name.to_string(), inputs, outputs, graph: Graph::new() }.rebuilt(graph, &|_| None)
    }

    /// The graph of this function; it has only the nodes that the outputs need.
    pub fn graph(&self) -> &Graph {
        &self.graph
    }

    /// This function with each named constant replaced by its value. Operations whose operands are all numbers are replaced by
    /// their result.
    pub fn bound(&self) -> Function {
        self.outline().rebuilt(&self.graph, &|s| match self.graph.symbols()[s.0 as usize].1 {
            SymbolKind::Constant(x) => Some(x),
            SymbolKind::Input => None,
        })
    }

    /// This function with named constants replaced by their values, except the constants for which `is_kept(name)` is true.
    pub fn bound_except(&self, is_kept: &dyn Fn(&str) -> bool) -> Function {
        self.outline().rebuilt(&self.graph, &|s| match &self.graph.symbols()[s.0 as usize] {
            (name, SymbolKind::Constant(x)) if !is_kept(name) => Some(*x),
            _ => None,
        })
    }

    /// This function with one more input after the others: `input`, which holds the named constants `names`.
    pub fn with_constants_as_input(&self, input: &str, names: &[String]) -> Function {
        let mut graph = self.graph.clone();
        let entries = names.iter().map(|name| graph.constant_as_input(name)).collect();
        let mut function = self.outline();
        function.inputs.push(Input { name: input.into(), entries });
        function.rebuilt(&graph, &|_| None)
    }

    /// The named constants that were not replaced by their values, in the order of creation: (expression, name, value).
    pub fn constants(&self) -> Vec<(Expr, String, f64)> {
        let nodes = self.graph.nodes().iter().enumerate();
        let mut found: Vec<(Symbol, (Expr, String, f64))> = nodes
            .filter_map(|(n, node)| match node {
                Node::Symbol(s) => match &self.graph.symbols()[s.0 as usize] {
                    (name, SymbolKind::Constant(x)) => Some((*s, (Expr::new(n, false), name.clone(), *x))),
                    _ => None,
                },
                _ => None,
            })
            .collect();
        found.sort_by_key(|(symbol, _)| *symbol);
        found.into_iter().map(|(_, constant)| constant).collect()
    }

    /// A function of the same inputs with a single output: a column of the entries at `places` (row, column) of output number
    /// `output`.
    pub fn with_entries(&self, output: usize, places: &[(usize, usize)]) -> Function {
        let o = &self.outputs[output];
        let entries: Vec<Expr> = places.iter().map(|(row, column)| o.entries[row * o.columns + column]).collect();
        let kept = Output { name: o.name.clone(), rows: entries.len(), columns: 1, entries };
        Function { outputs: vec![kept], ..self.outline() }.rebuilt(&self.graph, &|_| None)
    }

    /// This function under a new name, with one input set to zero. This input and all nodes that depend only on this input are
    /// removed.
    pub fn without(&self, name: &str, input: &str) -> Function {
        self.at_input(name, input, &[])
    }

    /// This function under a new name, with one input fixed at `values` and removed; missing values are zero.
    pub fn at_input(&self, name: &str, input: &str, values: &[f64]) -> Function {
        let Function { inputs, outputs, .. } = self.outline();
        let (gone, inputs): (Vec<Input>, Vec<Input>) = inputs.into_iter().partition(|i| i.name == input);
        let outline = Function { name: name.to_string(), inputs, outputs, graph: Graph::new() };
        let symbol = |e: &Expr| if let Node::Symbol(s) = self.graph.node(*e) { Some(s) } else { None };
        let values = values.iter().copied().chain(std::iter::repeat(0.0));
        let values: BTreeMap<_, _> = gone.iter().flat_map(|i| &i.entries).filter_map(symbol).zip(values).collect();
        outline.rebuilt(&self.graph, &|s| values.get(&s).copied())
    }

    /// A function whose only output has the given columns of output number `output`, in this order. All inputs stay, even if they
    /// are not used.
    pub fn with_columns(&self, name: &str, output: usize, columns: &[usize]) -> Function {
        let o = &self.outputs[output];
        let entries =
            (0..o.rows).flat_map(|r| columns.iter().map(move |&c| o.entries[r * o.columns + c])).collect::<Vec<_>>();
        let kept = Output { name: o.name.clone(), rows: o.rows, columns: columns.len(), entries };
        Function { name: name.to_string(), inputs: self.inputs.clone(), outputs: vec![kept], graph: Graph::new() }
            .rebuilt(&self.graph, &|_| None)
    }

    /// (row, column) of each entry of an output that is not identically zero, row by row.
    pub fn non_zeros(&self, output: usize) -> Vec<(usize, usize)> {
        let o = &self.outputs[output];
        let places = o.entries.iter().enumerate().filter(|(_, e)| !e.is_zero());
        places.map(|(i, _)| (i / o.columns, i % o.columns)).collect()
    }

    /// The positions of the entries that determine an output, row by row. Entries that are identically zero are left out, and so
    /// is the lower triangle of a symmetric matrix.
    pub fn sparsity_pattern(&self, output: usize) -> SparsityPattern {
        let o = &self.outputs[output];
        let at = |row: usize, column: usize| o.entries[row * o.columns + column];
        let mirrored = |row: usize| (0..row).all(|column| at(row, column) == at(column, row));
        let is_symmetric = o.rows == o.columns && o.rows > 1 && (0..o.rows).all(mirrored);
        let mut places = self.non_zeros(output);
        places.retain(|(row, column)| !is_symmetric || row <= column);
        SparsityPattern { places, is_symmetric }
    }

    /// A copy under a new name with the same operations. Its first output has only the entries at `places` (row, column), in one
    /// column.
    pub fn at_places(&self, name: &str, places: &[(usize, usize)]) -> Function {
        let mut function = Function { graph: self.graph.clone(), ..self.outline() };
        function.name = name.to_string();
        let o = &mut function.outputs[0];
        o.entries = places.iter().map(|(row, column)| o.entries[row * o.columns + column]).collect();
        (o.rows, o.columns) = (o.entries.len(), 1);
        function
    }

    /// A copy with the same name, inputs and outputs, but with an empty graph. [`Function::rebuilt`] fills the graph.
    fn outline(&self) -> Function {
        let (name, inputs, outputs) = (self.name.clone(), self.inputs.clone(), self.outputs.clone());
        Function { name, inputs, outputs, graph: Graph::new() }
    }

    /// This function with a new graph that has only the needed nodes of `old`. `value`: the number that replaces a symbol; `None`
    /// keeps the symbol. Unused symbols and inputs keep their positions in their lists.
    fn rebuilt(mut self, old: &Graph, value: &dyn Fn(Symbol) -> Option<f64>) -> Function {
        let mut new = Graph::with_symbols(old.symbols().to_vec());
        if old.keeps_names() {
            new = new.with_names();
        }
        let mut map = vec![Expr::ZERO; old.nodes().len()];
        // Each node is simplified again, because a number may have replaced a symbol. Operands come first.
        for n in self.schedule(old) {
            let node = old.nodes()[n];
            let m = |e: Expr| Graph::negate_if(map[e.node()], e.is_negative());
            let made = match node {
                Node::Constant(x) => new.constant(x),
                Node::Symbol(s) => match value(s) {
                    Some(x) => new.constant(x),
                    None => new.of_symbol(s),
                },
                Node::Sin(a) => new.sin(m(a)),
                Node::Cos(a) => new.cos(m(a)),
                Node::Add(a, b) => new.add(m(a), m(b)),
                Node::Mul(a, b) => new.mul(m(a), m(b)),
                Node::Div(a, b) => new.div(m(a), m(b)),
                Node::Sqrt(a) => new.sqrt(m(a)),
            };
            map[n] = made;
            if let Some((name, negative)) = old.name_of(n) {
                new.name(Graph::negate_if(made, negative), || name.to_string());
            }
        }
        let mapped = |e: &Expr| Graph::negate_if(map[e.node()], e.is_negative());
        for i in &mut self.inputs {
            i.entries = i.entries.iter().map(mapped).collect();
        }
        for o in &mut self.outputs {
            o.entries = o.entries.iter().map(mapped).collect();
        }
        self.graph = new;
        self
    }

    /// The order of computation: the nodes of `graph` that the outputs need, each after its operands and just before its first
    /// use. The outputs are computed block by block.
    fn schedule(&self, graph: &Graph) -> Vec<usize> {
        let mut order = Vec::new();
        let mut seen = vec![false; graph.nodes().len()];
        let inputs = self.inputs.iter().flat_map(|i| i.entries.clone());
        let wanted: Vec<Expr> = inputs.chain(self.outputs.iter().flat_map(Output::by_blocks)).collect();
        for e in wanted {
            let mut stack = vec![(e.node(), false)];
            while let Some((n, operands_done)) = stack.pop() {
                if operands_done {
                    order.push(n);
                } else if !std::mem::replace(&mut seen[n], true) {
                    stack.push((n, true));
                    let mut below: Vec<usize> = operands(graph.nodes()[n]).map(Expr::node).collect();
                    below.reverse();
                    stack.extend(below.into_iter().map(|m| (m, false)));
                }
            }
        }
        order
    }

    /// Hash (FNV-1a) of the graph, the inputs and the outputs. Equal functions with equal constants have the same hash on every
    /// machine.
    pub fn fingerprint(&self) -> u64 {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut feed = |x: u64| {
            for byte in x.to_le_bytes() {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
            }
        };
        for &node in self.graph.nodes() {
            match node {
                Node::Constant(x) => feed(x.to_bits()),
                Node::Symbol(s) => feed(u64::from(s.0)),
                Node::Sin(_) => feed(1),
                Node::Cos(_) => feed(2),
                Node::Add(..) => feed(3),
                Node::Mul(..) => feed(4),
                Node::Div(..) => feed(5),
                Node::Sqrt(_) => feed(6),
            }
            for e in operands(node) {
                feed(u64::from(e.bits()));
            }
        }
        for e in self.inputs.iter().flat_map(|i| &i.entries).chain(self.outputs.iter().flat_map(|o| &o.entries)) {
            feed(u64::from(e.bits()));
        }
        hash
    }

    /// Number of operations of one evaluation. A node that depends on no input is computed once and is not counted.
    pub fn count(&self) -> Count {
        let mut count = Count::default();
        let mut angles = Vec::new();
        for (n, &node) in self.graph.nodes().iter().enumerate() {
            if !self.graph.varies(Expr::new(n, false)) {
                continue;
            }
            match node {
                Node::Add(..) => count.add += 1,
                Node::Mul(..) | Node::Div(..) => count.mul += 1,
                Node::Sin(a) | Node::Cos(a) => angles.push(a),
                Node::Sqrt(_) | Node::Constant(_) | Node::Symbol(_) => {}
            }
        }
        angles.sort();
        angles.dedup();
        count.sin_cos = angles.len();
        count
    }

    /// The entries of each output, computed in the algebra `algebra` (for example, a finite field).
    pub fn evaluate_in<A: Algebra>(&self, algebra: &mut A) -> Vec<Vec<A::Value>> {
        let zero = algebra.constant(0.0);
        let mut values: Vec<A::Value> = Vec::with_capacity(self.graph.nodes().len());
        for &node in self.graph.nodes() {
            let value = match node {
                Node::Constant(x) => algebra.constant(x),
                Node::Symbol(s) => algebra.symbol(s),
                Node::Sin(a) => algebra.sin(a),
                Node::Cos(a) => algebra.cos(a),
                Node::Add(a, b) if b.is_negative() => algebra.sub(&values[a.node()], &values[b.node()]),
                Node::Add(a, b) => algebra.add(&values[a.node()], &values[b.node()]),
                Node::Mul(a, b) => algebra.mul(&values[a.node()], &values[b.node()]),
                Node::Div(a, b) => algebra.div(&values[a.node()], &values[b.node()]),
                // sqrt(-a) is not -sqrt(a), so a minus sign stays inside the root.
                Node::Sqrt(a) if a.is_negative() => {
                    let argument = algebra.neg(&values[a.node()]);
                    algebra.sqrt(&argument)
                }
                Node::Sqrt(a) => algebra.sqrt(&values[a.node()]),
            };
            values.push(value);
        }
        let mut read = |e: &Expr| match (e.is_zero(), e.is_negative()) {
            (true, _) => zero.clone(),
            (false, false) => values[e.node()].clone(),
            (false, true) => algebra.neg(&values[e.node()]),
        };
        self.outputs.iter().map(|o| o.entries.iter().map(&mut read).collect()).collect()
    }
}

/// The operands of a node.
pub fn operands(node: Node) -> impl Iterator<Item = Expr> {
    let (a, b) = match node {
        Node::Constant(_) | Node::Symbol(_) => (None, None),
        Node::Sin(a) | Node::Cos(a) | Node::Sqrt(a) => (Some(a), None),
        Node::Add(a, b) | Node::Mul(a, b) | Node::Div(a, b) => (Some(a), Some(b)),
    };
    a.into_iter().chain(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_columns_of_a_block_are_wanted_row_by_row() {
        let mut g = Graph::new();
        let inputs = ["a", "b", "c"].map(|name| g.symbol(name, SymbolKind::Input));
        let [a, b, c] = inputs;
        // Columns 0 and 1 have their last non-zero entry in row 1, column 2 in row 0.
        let entries = vec![g.mul(a, a), g.mul(a, b), g.mul(a, c), g.mul(b, b), g.mul(b, c), Expr::ZERO];
        let output = Output { name: "y".into(), rows: 2, columns: 3, entries };
        let f = Function::new("f", &g, vec![Input { name: "x".into(), entries: inputs.to_vec() }], vec![output]);
        let nodes: Vec<usize> = f.outputs[0].entries.iter().map(|e| e.node()).collect();
        let order = [nodes[0], nodes[1], nodes[3], nodes[4], nodes[2]];
        assert!(order.is_sorted(), "{nodes:?}");
    }
}
