//! A Function as a Rust function: one statement an operation, in the order of the schedule.
//!
//! ```text
//! pub fn NAME<R: Real>(q: &[R; 3], ..., y: &mut [[R; 18]; 3]) {
//!     let (s1, c1) = q[1].sin_cos();
//!     let t4 = s1 * dq[0];
//!     y[0][2] = t4;
//! ```
//! Signs stand only where a store or a sum needs them.

use expr::{Expr, Function, Node};
use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};

use crate::steps::{Name, Step, is_read, names, steps};

/// Tokens of `bound`, which has no named constants left, generic over the trait `Real`.
///
/// Inputs become `&[R; n]`, outputs `&mut [[R; columns]; rows]`, or `&mut [R; rows]` with one column;
/// an input that nothing reads is named `_NAME`.
pub(crate) fn render(bound: &Function) -> TokenStream {
    let writer = Writer { function: bound, names: names(bound) };
    let name = Ident::new(&bound.name, Span::call_site());
    let inputs = bound.inputs.iter().enumerate().map(|(k, input)| {
        let n = Literal::usize_unsuffixed(input.entries.len());
        let read = (0..input.entries.len()).any(|i| is_read(bound, k, i));
        let name = if read { format_ident!("{}", input.name) } else { format_ident!("_{}", input.name) };
        quote!(#name: &[R; #n])
    });
    let outputs = bound.outputs.iter().map(|output| {
        let name = format_ident!("{}", output.name);
        let (rows, columns) = (Literal::usize_unsuffixed(output.rows), Literal::usize_unsuffixed(output.columns));
        if output.columns == 1 { quote!(#name: &mut [R; #rows]) } else { quote!(#name: &mut [[R; #columns]; #rows]) }
    });
    let statements = steps(bound).into_iter().map(|step| writer.statement(&step));
    quote! {
        #[inline(always)]
        pub fn #name<R: Real>(#(#inputs,)* #(#outputs,)*) {
            #(#statements)*
        }
    }
}

struct Writer<'a> {
    function: &'a Function,
    names: Vec<Name>,
}

impl Writer<'_> {
    fn operand(&self, n: usize) -> TokenStream {
        match &self.names[n] {
            Name::Constant(x) => {
                let x = Literal::f64_unsuffixed(*x);
                quote!(R::from_f64(#x))
            }
            Name::Input { input, entry } => {
                let name = format_ident!("{}", self.function.inputs[*input].name);
                let entry = Literal::usize_unsuffixed(*entry);
                quote!(#name[#entry])
            }
            Name::Variable(name) => {
                let name = format_ident!("{name}");
                quote!(#name)
            }
        }
    }

    fn statement(&self, step: &Step) -> TokenStream {
        match *step {
            Step::Compute(n) => {
                let (name, value) = (self.operand(n), self.value(n));
                quote!(let #name = #value;)
            }
            Step::SinCos { angle, sine, cosine } => {
                let name = |n: Option<usize>| n.map_or_else(|| quote!(_), |n| self.operand(n));
                let (angle, sine, cosine) = (self.operand(angle), name(sine), name(cosine));
                quote!(let (#sine, #cosine) = (#angle).sin_cos();)
            }
            Step::Store { output, row, column, node, negative } => {
                let output = &self.function.outputs[output];
                let (name, value) = (format_ident!("{}", output.name), self.operand(node));
                let (row, column) = (Literal::usize_unsuffixed(row), Literal::usize_unsuffixed(column));
                let place = if output.columns == 1 { quote!(#name[#row]) } else { quote!(#name[#row][#column]) };
                if negative { quote!(#place = -#value;) } else { quote!(#place = #value;) }
            }
        }
    }

    fn value(&self, n: usize) -> TokenStream {
        let read = |e: Expr| self.operand(e.node());
        match self.function.graph().nodes()[n] {
            Node::Add(a, b) => {
                let (x, y) = (read(a), read(b));
                if b.is_negative() { quote!(#x - #y) } else { quote!(#x + #y) }
            }
            Node::Mul(a, b) => {
                let (x, y) = (read(a), read(b));
                quote!(#x * #y)
            }
            Node::Div(a, b) => {
                let (x, y) = (read(a), read(b));
                quote!(#x / #y)
            }
            Node::Sqrt(a) => {
                let x = read(a);
                // A root is not odd: the sign of its argument stays.
                if a.is_negative() { quote!((-#x).sqrt()) } else { quote!((#x).sqrt()) }
            }
            _ => unreachable!("a step computes"),
        }
    }
}
