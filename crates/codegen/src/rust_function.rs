//! A Function as a Rust function: one statement an operation, in the order of the schedule.
//!
//! ```text
//! pub fn NAME<R: Real>(q: &[R; 3], ..., y: &mut [[R; 18]; 3]) {
//!     let (s1, c1) = q[1].sin_cos();
//!     let t4 = s1 * dq[0];
//!     y[0][2] = t4;
//! ```
//! An entry is stored as soon as it is known. Signs stand only where a store or a sum needs them.

use expr::{Expr, Function, Graph, Node, SymbolKind, operands};
use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};

/// Tokens of `bound`, which has no named constants left, generic over the trait `Real`.
///
/// Inputs become `&[R; n]`, outputs `&mut [[R; columns]; rows]`, or `&mut [R; rows]` with one column.
pub(crate) fn render(bound: &Function) -> TokenStream {
    let graph = bound.graph();
    let writer = Writer { graph, names: names(bound) };

    let name = Ident::new(&bound.name, Span::call_site());
    let inputs = bound.inputs.iter().map(|input| {
        let (name, n) = (format_ident!("{}", input.name), Literal::usize_unsuffixed(input.entries.len()));
        quote!(#name: &[R; #n])
    });
    let outputs = bound.outputs.iter().map(|output| {
        let name = format_ident!("{}", output.name);
        let (rows, columns) = (Literal::usize_unsuffixed(output.rows), Literal::usize_unsuffixed(output.columns));
        if output.columns == 1 { quote!(#name: &mut [R; #rows]) } else { quote!(#name: &mut [[R; #columns]; #rows]) }
    });

    // Node -> the places it is stored to; constants are stored first.
    let mut places: Vec<Vec<(TokenStream, bool)>> = vec![Vec::new(); graph.nodes().len()];
    for output in &bound.outputs {
        let name = format_ident!("{}", output.name);
        for (i, e) in output.entries.iter().enumerate() {
            let row = Literal::usize_unsuffixed(i / output.columns);
            let column = Literal::usize_unsuffixed(i % output.columns);
            let place = if output.columns == 1 { quote!(#name[#row]) } else { quote!(#name[#row][#column]) };
            places[e.node()].push((place, e.is_negative()));
        }
    }
    let mut statements = Vec::new();
    for (n, places) in places.iter().enumerate() {
        statements.extend(writer.statement(n));
        for (place, negative) in places {
            let value = writer.operand(n);
            statements.push(if *negative { quote!(#place = -#value;) } else { quote!(#place = #value;) });
        }
    }
    let unread = bound.inputs.iter().filter(|input| {
        let reads = |node: &Node| operands(*node).any(|e| input.entries.contains(&e));
        let stored = |e: &Expr| input.entries.contains(&e.abs());
        !graph.nodes().iter().any(reads) && !bound.outputs.iter().flat_map(|o| &o.entries).any(stored)
    });
    let unread = unread.map(|input| {
        let name = format_ident!("{}", input.name);
        quote!(let _ = #name;)
    });
    quote! {
        #[inline(always)]
        pub fn #name<R: Real>(#(#inputs,)* #(#outputs,)*) {
            #(#unread)*
            #(#statements)*
        }
    }
}

/// How a node is read by those that use it.
#[derive(Clone)]
enum NodeName {
    /// A literal.
    Constant(f64),
    /// An entry of an input.
    Input(TokenStream),
    /// A variable.
    Variable(Ident),
}

fn names(function: &Function) -> Vec<NodeName> {
    let graph = function.graph();
    // The sine of the first input's entry i is s{i}, of another's s_{name}{i}.
    let inputs: Vec<(Expr, TokenStream, String)> = function
        .inputs
        .iter()
        .enumerate()
        .flat_map(|(k, input)| {
            let name = format_ident!("{}", input.name);
            let of = if k == 0 { String::new() } else { format!("_{}", input.name) };
            input.entries.iter().enumerate().map(move |(i, &e)| {
                let at = Literal::usize_unsuffixed(i);
                (e, quote!(#name[#at]), format!("{of}{i}"))
            })
        })
        .collect();
    let input = |e: Expr| inputs.iter().find(|i| i.0 == e);
    let mut names: Vec<NodeName> = Vec::new();
    for (n, &node) in graph.nodes().iter().enumerate() {
        let name = match node {
            Node::Constant(x) => NodeName::Constant(x),
            Node::Symbol(s) => {
                debug_assert_eq!(graph.symbols()[s.0 as usize].1, SymbolKind::Input);
                match inputs.iter().find(|i| i.0.node() == n) {
                    Some(i) => NodeName::Input(i.1.clone()),
                    None => unreachable!("a bound function reads its inputs only"),
                }
            }
            Node::Sin(a) => NodeName::Variable(match input(a) {
                Some(i) => format_ident!("s{}", i.2),
                None => format_ident!("s_t{}", a.node()),
            }),
            Node::Cos(a) => NodeName::Variable(match input(a) {
                Some(i) => format_ident!("c{}", i.2),
                None => format_ident!("c_t{}", a.node()),
            }),
            _ => NodeName::Variable(format_ident!("t{}", n)),
        };
        names.push(name);
    }
    names
}

struct Writer<'a> {
    graph: &'a Graph,
    names: Vec<NodeName>,
}

impl Writer<'_> {
    fn operand(&self, n: usize) -> TokenStream {
        match &self.names[n] {
            NodeName::Constant(x) => {
                let x = Literal::f64_unsuffixed(*x);
                quote!(R::from_f64(#x))
            }
            NodeName::Input(tokens) => tokens.clone(),
            NodeName::Variable(name) => quote!(#name),
        }
    }

    fn statement(&self, n: usize) -> Option<TokenStream> {
        let NodeName::Variable(name) = &self.names[n] else { return None };
        let read = |e: Expr| self.operand(e.node());
        Some(match self.graph.nodes()[n] {
            Node::Add(a, b) => {
                let (x, y) = (read(a), read(b));
                if b.is_negative() { quote!(let #name = #x - #y;) } else { quote!(let #name = #x + #y;) }
            }
            Node::Mul(a, b) => {
                let (x, y) = (read(a), read(b));
                quote!(let #name = #x * #y;)
            }
            // The pair is made at the place of the first of the two.
            Node::Sin(a) | Node::Cos(a) => {
                let is_pair = |m: &usize| matches!(self.graph.nodes()[*m], Node::Sin(b) | Node::Cos(b) if b == a);
                let pair: Vec<usize> = (0..self.names.len()).filter(is_pair).collect();
                if pair[0] != n {
                    return None;
                }
                let of = |wanted: fn(&Node) -> bool| {
                    let found = pair.iter().find(|&&m| wanted(&self.graph.nodes()[m]));
                    found.map_or_else(|| quote!(_), |&m| self.operand(m))
                };
                let (sine, cosine) = (of(|m| matches!(m, Node::Sin(_))), of(|m| matches!(m, Node::Cos(_))));
                let x = read(a);
                quote!(let (#sine, #cosine) = (#x).sin_cos();)
            }
            Node::Div(a, b) => {
                let (x, y) = (read(a), read(b));
                quote!(let #name = #x / #y;)
            }
            // A root is not odd: the sign of its argument stays.
            Node::Sqrt(a) => {
                let x = read(a);
                if a.is_negative() { quote!(let #name = (-#x).sqrt();) } else { quote!(let #name = (#x).sqrt();) }
            }
            Node::Constant(_) | Node::Symbol(_) => return None,
        })
    }
}
