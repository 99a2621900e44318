//! Converts a function (a graph of operations) to readable assignments. A node of the graph with a name, or with several uses,
//! becomes a variable; other nodes are written inside the expressions that use them.
//!
//! The operations are the same as in the graph. A variable has the name given by [`expr::Graph::name`]; sine and cosine of `q2`
//! are `S2` and `C2`; variables without a name are `t1`, `t2`. A name belongs to the value for which it was given. If the node
//! contains the negative of this value, the signs in the assignment and in all uses are changed.

use std::collections::HashSet;

use expr::{Expr, Function, Node, operands};

/// An expression made of variables and numbers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Term {
    /// A number; never negative.
    Number(f64),
    Variable(String),
    /// Summands, each with a flag: whether it is subtracted. The first one is added, unless all are subtracted.
    Sum(Vec<(bool, Term)>),
    /// Factors with their powers. A number is the first factor.
    Product(Vec<(Term, u32)>),
    Quotient(Box<Term>, Box<Term>),
    Root(Box<Term>),
    Sine(Box<Term>),
    Cosine(Box<Term>),
}

/// One output of the function.
pub(crate) struct ListedOutput {
    pub name: String,
    pub rows: usize,
    pub columns: usize,
    /// Entries as (row, column, value), row by row. If all entries are listed, those that are always zero are omitted.
    pub entries: Vec<(usize, usize, Term)>,
    /// Whether all entries are listed; otherwise only one chosen entry.
    pub is_whole: bool,
}

/// A function as assignments, and the outputs that are computed from them.
pub(crate) struct Listing {
    /// For each input, its name and the names of its entries.
    pub inputs: Vec<(String, Vec<String>)>,
    /// Names of the constants that stay symbols.
    pub constants: Vec<String>,
    pub assignments: Vec<(String, Term)>,
    pub outputs: Vec<ListedOutput>,
}

/// An entry of an output: index of the output, row and column, all counted from 0.
pub type OutputEntry = (usize, usize, usize);

/// The names of the nodes of the graph. The flag says whether the name belongs to the negative value of the node.
pub(crate) struct ListingNames {
    of_node: Vec<Option<(String, bool)>>,
    taken: HashSet<String>,
    unnamed: usize,
}

/// Words that cannot be names of variables, because they are reserved in one or more of the languages.
const RESERVED: &str = "
    and as assert break case catch class continue cos def del elif else end except finally for from function
    global if import in is lambda Matrix not or otherwise parfor pass persistent pi raise return sin spmd
    sqrt switch symbols try while with yield zeros
";

impl ListingNames {
    /// Gives names to inputs and constants. The outputs get their names from [`output_name`].
    pub(super) fn of(function: &Function) -> ListingNames {
        let graph = function.graph();
        let taken =
            RESERVED.split_whitespace().map(String::from).chain(function.outputs.iter().map(|o| output_name(&o.name)));
        let mut names = ListingNames { of_node: vec![None; graph.nodes().len()], taken: taken.collect(), unnamed: 0 };
        let inputs = function.inputs.iter().flat_map(|i| &i.entries).copied();
        for e in inputs.chain(function.constants().into_iter().map(|c| c.0)) {
            if let Node::Symbol(s) = graph.node(e) {
                names.give(e.node(), &graph.symbols()[s.0 as usize].0.clone(), false);
            }
        }
        names
    }

    /// Gives a node the name `wanted`, with underscores appended if another node has this name. A node that already has a name
    /// keeps it.
    fn give(&mut self, node: usize, wanted: &str, negative: bool) {
        if self.of_node[node].is_some() {
            return;
        }
        let mut name: String = wanted.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
            name.insert(0, 'v');
        }
        while !self.taken.insert(name.clone()) {
            name.push('_');
        }
        self.of_node[node] = Some((name, negative));
    }

    /// Gives a name to a node that becomes a variable: from its angle (S2, C2), from the graph, or a number (t1).
    pub(super) fn give_to_variable(&mut self, function: &Function, node: usize) {
        let graph = function.graph();
        match (graph.nodes()[node], graph.name_of(node)) {
            (Node::Sin(a), _) => self.give(node, &format!("S{}", self.angle(a)), false),
            (Node::Cos(a), _) => self.give(node, &format!("C{}", self.angle(a)), false),
            (_, Some((name, negative))) => self.give(node, name, negative),
            _ => {
                self.unnamed += 1;
                self.give(node, &format!("t{}", self.unnamed), false);
            }
        }
    }

    /// The name of an angle after S or C: `2` for `q2`; for other variables an underscore and the whole name.
    fn angle(&self, a: Expr) -> String {
        let name = self.of_node[a.node()].as_ref().map_or("", |(name, _)| name.as_str());
        match name.strip_prefix('q').filter(|rest| !rest.is_empty()) {
            Some(rest) => rest.to_string(),
            None => format!("_{name}"),
        }
    }

    pub(super) fn name(&self, node: usize) -> Option<&(String, bool)> {
        self.of_node[node].as_ref()
    }

    /// The names of these expressions; empty for an expression without a name.
    fn texts(&self, entries: &[Expr]) -> Vec<String> {
        entries.iter().map(|e| self.name(e.node()).map_or(String::new(), |(name, _)| name.clone())).collect()
    }
}

/// The name of an output: `A` for a matrix `a`. Names with several letters, such as `tau`, are not changed.
pub fn output_name(name: &str) -> String {
    if name.len() == 1 { name.to_uppercase() } else { name.to_string() }
}

impl Listing {
    /// The listing of `function`. `place`: the only entry to list; `None`: all entries.
    pub(super) fn of(function: &Function, place: Option<OutputEntry>) -> Listing {
        let only = place.map(|(output, row, column)| function.with_entries(output, &[(row, column)]));
        let shown = only.as_ref().unwrap_or(function);
        let mut names = ListingNames::of(shown);
        let mut assignments = Vec::new();
        let is_variable = variables(shown);
        for n in 0..shown.graph().nodes().len() {
            if is_variable[n] {
                let value = TermReader { function: shown, names: &names }.node(n);
                names.give_to_variable(shown, n);
                if let Some((name, negative)) = names.name(n) {
                    assignments.push((name.clone(), if *negative { negated(value) } else { value }));
                }
            }
        }
        let entry = |e: Expr| TermReader { function: shown, names: &names }.signed(e);
        Listing::around(function, shown, &names, assignments, place, |i, k| {
            if only.is_some() { entry(shown.outputs[0].entries[0]) } else { entry(shown.outputs[i].entries[k]) }
        })
    }

    /// A listing with these assignments. `value` gives the term of an entry from the index of the output and the index of the
    /// entry. `shown`: the part of `function` that is listed; `names`: the names of its nodes.
    pub(super) fn around(
        function: &Function,
        shown: &Function,
        names: &ListingNames,
        assignments: Vec<(String, Term)>,
        place: Option<OutputEntry>,
        value: impl Fn(usize, usize) -> Term,
    ) -> Listing {
        let outputs =
            function.outputs.iter().enumerate().filter(|(i, _)| place.is_none_or(|(output, ..)| output == *i));
        let output = |(i, o): (usize, &expr::Output)| {
            let is_listed = |k: usize| match place {
                Some((_, row, column)) => k == row * o.columns + column,
                None => !o.entries[k].is_zero(),
            };
            let entries = (0..o.entries.len()).filter(|&k| is_listed(k));
            ListedOutput {
                name: output_name(&o.name),
                rows: o.rows,
                columns: o.columns,
                entries: entries.map(|k| (k / o.columns, k % o.columns, value(i, k))).collect(),
                is_whole: place.is_none(),
            }
        };
        let mut listing = Listing {
            inputs: shown.inputs.iter().map(|i| (i.name.clone(), names.texts(&i.entries))).collect(),
            constants: shown.constants().into_iter().map(|(e, ..)| names.texts(&[e]).concat()).collect(),
            outputs: outputs.map(output).collect(),
            assignments,
        };
        // An expansion may use fewer constants than the function, so unused constants are removed.
        let mut read = HashSet::new();
        let entries = listing.outputs.iter().flat_map(|o| o.entries.iter().map(|(_, _, term)| term));
        listing.assignments.iter().map(|(_, term)| term).chain(entries).for_each(|term| collect(term, &mut read));
        listing.constants.retain(|name| read.contains(name));
        listing
    }
}

fn collect(term: &Term, read: &mut HashSet<String>) {
    match term {
        Term::Number(_) => {}
        Term::Variable(name) => {
            read.insert(name.clone());
        }
        Term::Sum(terms) => terms.iter().for_each(|(_, term)| collect(term, read)),
        Term::Product(factors) => factors.iter().for_each(|(factor, _)| collect(factor, read)),
        Term::Quotient(a, b) => {
            collect(a, read);
            collect(b, read);
        }
        Term::Root(a) | Term::Sine(a) | Term::Cosine(a) => collect(a, read),
    }
}

/// For each node of the graph, whether it becomes a variable. Variables are: sines, cosines, nodes with several uses, and nodes
/// with a name, except nodes that only an output uses.
fn variables(function: &Function) -> Vec<bool> {
    let graph = function.graph();
    let mut reads = vec![0_usize; graph.nodes().len()];
    let mut by_output = vec![false; graph.nodes().len()];
    for e in graph.nodes().iter().flat_map(|node| operands(*node)) {
        reads[e.node()] += 1;
    }
    for e in function.outputs.iter().flat_map(|o| &o.entries) {
        reads[e.node()] += 1;
        by_output[e.node()] = true;
    }
    let is_variable = |(n, node): (usize, &Node)| match node {
        Node::Constant(_) | Node::Symbol(_) => false,
        Node::Sin(_) | Node::Cos(_) => reads[n] > 0,
        _ => reads[n] > 1 || (graph.name_of(n).is_some() && !by_output[n]),
    };
    graph.nodes().iter().enumerate().map(is_variable).collect()
}

/// Converts nodes of the graph to terms: a variable becomes its name, and any other node becomes an expression.
pub(crate) struct TermReader<'a> {
    pub function: &'a Function,
    pub names: &'a ListingNames,
}

impl TermReader<'_> {
    pub(super) fn signed(&self, e: Expr) -> Term {
        let (negative, term) = self.operand(e);
        if negative { negated(term) } else { term }
    }

    /// The term of an expression, and whether it is subtracted.
    fn operand(&self, e: Expr) -> (bool, Term) {
        match self.names.name(e.node()) {
            Some((name, negative)) => (e.is_negative() ^ negative, Term::Variable(name.clone())),
            None => match self.node(e.node()) {
                Term::Sum(terms) if terms.len() == 1 => (e.is_negative() ^ terms[0].0, terms[0].1.clone()),
                term => (e.is_negative(), term),
            },
        }
    }

    /// The term of a node in terms of its operands.
    pub(super) fn node(&self, n: usize) -> Term {
        match self.function.graph().nodes()[n] {
            Node::Constant(x) => Term::Number(x),
            Node::Symbol(_) => self.names.name(n).map_or(Term::Number(0.0), |(name, _)| Term::Variable(name.clone())),
            Node::Add(a, b) => sum([a, b].map(|e| self.operand(e)).to_vec()),
            Node::Mul(a, b) => self.product([a, b]),
            Node::Div(a, b) => {
                let ((x, a), (y, b)) = (self.operand(a), self.operand(b));
                let quotient = Term::Quotient(Box::new(a), Box::new(b));
                if x ^ y { negated(quotient) } else { quotient }
            }
            Node::Sqrt(a) => Term::Root(Box::new(self.signed(a))),
            Node::Sin(a) => Term::Sine(Box::new(self.signed(a))),
            Node::Cos(a) => Term::Cosine(Box::new(self.signed(a))),
        }
    }

    fn product(&self, factors: [Expr; 2]) -> Term {
        let (mut negative, mut number, mut powers) = (false, 1.0, Vec::<(Term, u32)>::new());
        for e in factors {
            let (is_subtracted, term) = self.operand(e);
            negative ^= is_subtracted;
            let inner = if let Term::Product(inner) = term { inner } else { vec![(term, 1)] };
            for (factor, power) in inner {
                match (factor, powers.last_mut()) {
                    (Term::Number(x), _) => number *= x.powi(power as i32),
                    (factor, Some((last, n))) if *last == factor => *n += power,
                    (factor, _) => powers.push((factor, power)),
                }
            }
        }
        if number != 1.0 || powers.is_empty() {
            powers.insert(0, (Term::Number(number), 1));
        }
        let product = if powers.len() == 1 && powers[0].1 == 1 { powers.remove(0).0 } else { Term::Product(powers) };
        if negative { negated(product) } else { product }
    }
}

/// A sum without nested sums. If there is a positive summand, one comes first.
pub(crate) fn sum(terms: Vec<(bool, Term)>) -> Term {
    let mut flat = Vec::new();
    for (negative, term) in terms {
        match term {
            Term::Sum(inner) => flat.extend(inner.into_iter().map(|(n, t)| (n ^ negative, t))),
            term => flat.push((negative, term)),
        }
    }
    if let Some(first) = flat.iter().position(|(negative, _)| !negative) {
        flat[..=first].rotate_right(1);
    }
    Term::Sum(flat)
}

pub(crate) fn negated(term: Term) -> Term {
    match term {
        Term::Sum(terms) if terms.len() == 1 && terms[0].0 => {
            terms.into_iter().next().map_or(Term::Number(0.0), |t| t.1)
        }
        Term::Sum(terms) => sum(terms.into_iter().map(|(negative, term)| (!negative, term)).collect()),
        term => Term::Sum(vec![(true, term)]),
    }
}
