//! A graph of expressions. Each subexpression is a node that is stored once. An expression is a handle: the number of a node, and
//! a sign. So x and -x have the same node.
//!
//! The nodes have a normal form. The first operand of a sum is positive. Operands of sums and products are in the order of their
//! creation, constants first. Zeros, ones, x - x, and operations of constants are simplified when the nodes are created, so that
//! an exact zero never becomes a rounding error such as 6e-17.

use rustc_hash::FxHashMap;

/// A handle of an expression: the number of a node, with a sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Expr(u32);

impl Expr {
    /// The constant zero, node 0 of every graph.
    pub const ZERO: Expr = Expr(0);
    /// The constant one, node 1 of every graph.
    pub const ONE: Expr = Expr(2);

    pub(crate) fn new(node: usize, negative: bool) -> Expr {
        Expr((node as u32) << 1 | u32::from(negative))
    }

    pub(crate) fn bits(self) -> u32 {
        self.0
    }

    /// Index of the node in [`Graph::nodes`].
    pub fn node(self) -> usize {
        (self.0 >> 1) as usize
    }

    /// Whether the handle has a minus.
    pub fn is_negative(self) -> bool {
        self.0 & 1 == 1
    }

    /// Whether the expression is the constant 0. Zero is always the same node, without a sign.
    pub fn is_zero(self) -> bool {
        self == Expr::ZERO
    }

    /// The expression without its sign.
    pub fn abs(self) -> Expr {
        Expr(self.0 & !1)
    }

    fn with_sign(self, negative: bool) -> Expr {
        if negative { -self } else { self }
    }
}

impl std::ops::Neg for Expr {
    type Output = Expr;
    fn neg(self) -> Expr {
        if self.is_zero() { self } else { Expr(self.0 ^ 1) }
    }
}

/// Index of a symbol in [`Graph::symbols`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Symbol(pub u32);

/// The role of a symbol in a function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SymbolKind {
    /// An input: its value is given at each evaluation.
    Input,
    /// A constant with a name and this value.
    Constant(f64),
}

/// An operation on expressions, or a leaf of the graph. The sign of a value is stored in the handle (`Expr`), not in the node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Node {
    /// A constant, zero or positive.
    Constant(f64),
    /// An input or a named constant.
    Symbol(Symbol),
    /// Sine of an expression without sign.
    Sin(Expr),
    /// Cosine of an expression without sign.
    Cos(Expr),
    /// a + b; only b may have a minus.
    Add(Expr, Expr),
    /// a b. Both operands are without sign.
    Mul(Expr, Expr),
    /// a / b. Both operands are without sign.
    Div(Expr, Expr),
    /// Square root of an expression.
    Sqrt(Expr),
}

/// A growing list of nodes; operands precede the nodes that use them.
#[derive(Clone, Debug)]
pub struct Graph {
    nodes: Vec<Node>,
    /// Whether each node depends on an input.
    varies: Vec<bool>,
    symbols: Vec<(String, SymbolKind)>,
    known: FxHashMap<Key, u32>,
    /// Names of nodes for formulas, by node number: the name, and whether it stands for the negative of the node. `None` if names
    /// are not kept.
    names: Option<FxHashMap<u32, (String, bool)>>,
}

/// The key of a node in the hash map. It contains the numbers of the node as bits.
type Key = (u8, u64, u32);

fn key(node: Node) -> Key {
    match node {
        Node::Constant(x) => (0, x.to_bits(), 0),
        Node::Symbol(s) => (1, u64::from(s.0), 0),
        Node::Sin(a) => (2, u64::from(a.0), 0),
        Node::Cos(a) => (3, u64::from(a.0), 0),
        Node::Add(a, b) => (4, u64::from(a.0), b.0),
        Node::Mul(a, b) => (5, u64::from(a.0), b.0),
        Node::Div(a, b) => (6, u64::from(a.0), b.0),
        Node::Sqrt(a) => (7, u64::from(a.0), 0),
    }
}

impl Default for Graph {
    fn default() -> Self {
        Graph::new()
    }
}

impl Graph {
    /// A graph with only the constants 0 and 1.
    pub fn new() -> Graph {
        Graph::with_symbols(Vec::new())
    }

    /// A graph with only the constants 0 and 1, and with `symbols` defined.
    pub fn with_symbols(symbols: Vec<(String, SymbolKind)>) -> Graph {
        let mut g = Graph { nodes: Vec::new(), varies: Vec::new(), symbols, known: FxHashMap::default(), names: None };
        g.intern(Node::Constant(0.0));
        g.intern(Node::Constant(1.0));
        g
    }

    /// This graph, set to keep the names that are given to its nodes from now on.
    pub fn with_names(self) -> Graph {
        Graph { names: Some(self.names.unwrap_or_default()), ..self }
    }

    /// Whether names of nodes are kept.
    pub fn keeps_names(&self) -> bool {
        self.names.is_some()
    }

    /// Gives the node of `e` a name, if names are kept and the node has no name yet. Constants and symbols get no name.
    pub fn name(&mut self, e: Expr, name: impl FnOnce() -> String) {
        if matches!(self.node(e), Node::Constant(_) | Node::Symbol(_)) {
            return;
        }
        if let Some(names) = &mut self.names {
            names.entry(e.node() as u32).or_insert_with(|| (name(), e.is_negative()));
        }
    }

    /// The name of a node, and whether it stands for the negative of the node. `None` if the node has no name.
    pub fn name_of(&self, node: usize) -> Option<(&str, bool)> {
        let (name, negative) = self.names.as_ref()?.get(&(node as u32))?;
        Some((name, *negative))
    }

    /// All nodes, each after its operands.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The node of a handle, without the sign of the handle.
    pub fn node(&self, e: Expr) -> Node {
        self.nodes[e.node()]
    }

    /// Names and kinds of the symbols, in the order of their creation.
    pub fn symbols(&self) -> &[(String, SymbolKind)] {
        &self.symbols
    }

    /// Whether the expression depends on an input.
    pub fn varies(&self, e: Expr) -> bool {
        self.varies[e.node()]
    }

    fn intern(&mut self, node: Node) -> Expr {
        let nodes = &mut self.nodes;
        let varies = &mut self.varies;
        let symbols = &self.symbols;
        let n = *self.known.entry(key(node)).or_insert_with(|| {
            let v = |e: Expr| varies[e.node()];
            let it_varies = match node {
                Node::Constant(_) => false,
                Node::Symbol(s) => symbols[s.0 as usize].1 == SymbolKind::Input,
                Node::Sin(a) | Node::Cos(a) | Node::Sqrt(a) => v(a),
                Node::Add(a, b) | Node::Mul(a, b) | Node::Div(a, b) => v(a) || v(b),
            };
            varies.push(it_varies);
            nodes.push(node);
            nodes.len() as u32 - 1
        });
        Expr::new(n as usize, false)
    }

    /// Makes a new symbol. Names are only for display: two symbols may have the same name.
    pub fn symbol(&mut self, name: &str, kind: SymbolKind) -> Expr {
        self.symbols.push((name.to_string(), kind));
        self.of_symbol(Symbol(self.symbols.len() as u32 - 1))
    }

    /// Changes the named constant `name` into an input. If there is no such constant, an input is created. Operands are ordered
    /// with constants first; existing nodes keep their old order until the graph is rebuilt.
    pub(crate) fn constant_as_input(&mut self, name: &str) -> Expr {
        let is = |(known, kind): &(String, SymbolKind)| known == name && *kind != SymbolKind::Input;
        match self.symbols.iter().position(is) {
            Some(s) => {
                self.symbols[s].1 = SymbolKind::Input;
                self.of_symbol(Symbol(s as u32))
            }
            None => self.symbol(name, SymbolKind::Input),
        }
    }

    pub(crate) fn of_symbol(&mut self, symbol: Symbol) -> Expr {
        self.intern(Node::Symbol(symbol))
    }

    /// The constant x, which must be finite.
    pub fn constant(&mut self, x: f64) -> Expr {
        debug_assert!(x.is_finite());
        if x == 0.0 {
            return Expr::ZERO;
        }
        self.intern(Node::Constant(x.abs())).with_sign(x < 0.0)
    }

    /// The value of a constant; `None` for other expressions.
    pub fn as_constant(&self, e: Expr) -> Option<f64> {
        match self.node(e) {
            Node::Constant(x) => Some(if e.is_negative() { -x } else { x }),
            _ => None,
        }
    }

    /// a + b. Two numbers are added immediately, and a + a is stored as 2 a. b + a has the same node, and -a - b has the same
    /// node with the opposite sign.
    pub fn add(&mut self, a: Expr, b: Expr) -> Expr {
        if a.is_zero() {
            return b;
        }
        if b.is_zero() {
            return a;
        }
        if a == -b {
            return Expr::ZERO;
        }
        if a == b {
            let two = self.constant(2.0);
            return self.mul(two, a);
        }
        if let (Some(x), Some(y)) = (self.as_constant(a), self.as_constant(b)) {
            return self.constant(x + y);
        }
        let (a, b) = if a.node() < b.node() { (a, b) } else { (b, a) };
        let negative = a.is_negative();
        self.intern(Node::Add(a.abs(), b.with_sign(negative))).with_sign(negative)
    }

    /// a - b, which shares its node with b - a.
    pub fn sub(&mut self, a: Expr, b: Expr) -> Expr {
        self.add(a, -b)
    }

    /// a b. Two numbers are multiplied immediately. The sign of the product is in the handle.
    pub fn mul(&mut self, a: Expr, b: Expr) -> Expr {
        if a.is_zero() || b.is_zero() {
            return Expr::ZERO;
        }
        let negative = a.is_negative() != b.is_negative();
        let (a, b) = (a.abs(), b.abs());
        if a == Expr::ONE {
            return b.with_sign(negative);
        }
        if b == Expr::ONE {
            return a.with_sign(negative);
        }
        let (a, b) = self.constant_first(a, b);
        if let Node::Constant(x) = self.node(a) {
            match self.node(b) {
                Node::Constant(y) => return self.constant(x * y).with_sign(negative),
                // x (y c) = (x y) c
                Node::Mul(y, c) => {
                    if let Node::Constant(y) = self.node(y) {
                        let xy = self.constant(x * y);
                        return self.mul(xy, c).with_sign(negative);
                    }
                }
                _ => {}
            }
        }
        self.intern(Node::Mul(a, b)).with_sign(negative)
    }

    /// Orders two operands: numbers first, then expressions that depend on no input, then others. Within each group the order is
    /// the order of creation.
    fn constant_first(&self, a: Expr, b: Expr) -> (Expr, Expr) {
        let rank = |e: Expr| match self.node(e) {
            Node::Constant(_) => 0,
            _ if !self.varies(e) => 1,
            _ => 2,
        };
        if (rank(a), a.node()) <= (rank(b), b.node()) { (a, b) } else { (b, a) }
    }

    /// a / b; b must not be the constant zero.
    pub fn div(&mut self, a: Expr, b: Expr) -> Expr {
        debug_assert!(!b.is_zero());
        let negative = a.is_negative() != b.is_negative();
        let (a, b) = (a.abs(), b.abs());
        if a.is_zero() || b == Expr::ONE {
            return a.with_sign(negative);
        }
        if a == b {
            return Expr::ONE.with_sign(negative);
        }
        if let (Some(x), Some(y)) = (self.as_constant(a), self.as_constant(b)) {
            return self.constant(x / y).with_sign(negative);
        }
        self.intern(Node::Div(a, b)).with_sign(negative)
    }

    /// Square root; NaN for a negative number.
    pub fn sqrt(&mut self, a: Expr) -> Expr {
        match self.as_constant(a) {
            Some(x) => self.constant(libm::sqrt(x)),
            None => self.intern(Node::Sqrt(a)),
        }
    }

    /// Sine, with sin(-x) = -sin(x).
    pub fn sin(&mut self, a: Expr) -> Expr {
        match self.as_constant(a.abs()) {
            Some(x) => self.constant(libm::sin(x)).with_sign(a.is_negative()),
            None => self.intern(Node::Sin(a.abs())).with_sign(a.is_negative()),
        }
    }

    /// Cosine, with cos(-x) = cos(x).
    pub fn cos(&mut self, a: Expr) -> Expr {
        match self.as_constant(a.abs()) {
            Some(x) => self.constant(libm::cos(x)),
            None => self.intern(Node::Cos(a.abs())),
        }
    }

    pub(crate) fn negate_if(e: Expr, negative: bool) -> Expr {
        e.with_sign(negative)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facts() {
        let mut g = Graph::new();
        let x = g.symbol("x", SymbolKind::Input);
        let y = g.symbol("y", SymbolKind::Input);
        let two = g.constant(2.0);
        macro_rules! fact {
            ($a:expr => $b:expr) => {
                assert_eq!($a, $b, "{}", stringify!($a => $b));
            };
        }
        fact!(g.add(x, Expr::ZERO) => x);
        fact!(g.sub(x, x) => Expr::ZERO);
        fact!(g.add(x, x) => g.mul(two, x));
        fact!(g.mul(x, Expr::ZERO) => Expr::ZERO);
        fact!(g.mul(x, Expr::ONE) => x);
        fact!(g.mul(x, -Expr::ONE) => -x);
        fact!(-Expr::ZERO => Expr::ZERO);
        fact!(g.sub(x, y) => -g.sub(y, x));
        fact!(g.add(-x, -y) => -g.add(y, x));
        fact!(g.mul(-x, y) => -g.mul(y, x));
        fact!(g.mul(-x, -y) => g.mul(x, y));
        fact!(g.sin(-x) => -g.sin(x));
        fact!(g.cos(-x) => g.cos(x));
        fact!(g.constant(-2.0) => -two);
        fact!(g.add(two, two) => g.constant(4.0));
        fact!({ let a = g.mul(two, x); g.mul(two, a) } => { let c = g.constant(4.0); g.mul(c, x) });
        fact!({ let d = g.symbol("D", SymbolKind::Constant(0.3)); g.div(d, -d) } => -Expr::ONE);
    }
}
