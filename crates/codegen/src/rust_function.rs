//! A Function as a Rust function: one statement an operation, in the order of the schedule.
//!
//! ```text
//! pub fn NAME<R: Real>(q: &[R; 3], ..., y: &mut [[R; 18]; 3]) {
//!     let (s1, c1) = q[1].sin_cos();
//!     let t4 = s1 * dq[0];
//!     let t5 = t4.mul_add(c1, -q[0]);
//!     y[0][2] = t5;
//! ```
//! `mul_add` is the trait's: fused where the target fuses. Signs stand only where a store or a sum needs them.

use expr::{Expr, Function, Operation};
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
            Step::Compute(n, operation) => {
                let (name, value) = (self.operand(n), self.value(operation));
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

    /// What is held at the node of `e`, or its negative.
    fn signed(&self, e: Expr) -> TokenStream {
        let x = self.operand(e.node());
        match (e.is_negative(), &self.names[e.node()]) {
            (false, _) => x,
            (true, Name::Constant(x)) => {
                let x = Literal::f64_unsuffixed(*x);
                quote!(R::from_f64(-#x))
            }
            (true, _) => quote!(-#x),
        }
    }

    fn value(&self, operation: Operation) -> TokenStream {
        let read = |e: Expr| self.operand(e.node());
        match operation {
            Operation::Add(a, b) => {
                let (x, y) = (read(a), read(b));
                if b.is_negative() { quote!(#x - #y) } else { quote!(#x + #y) }
            }
            Operation::MulAdd(a, b, c) => {
                let (x, y, z) = (self.signed(a), read(b), self.signed(c));
                let bare = !a.is_negative() || matches!(self.names[a.node()], Name::Constant(_));
                if bare { quote!(#x.mul_add(#y, #z)) } else { quote!((#x).mul_add(#y, #z)) }
            }
            Operation::Mul(a, b) => {
                let (x, y) = (read(a), read(b));
                quote!(#x * #y)
            }
            Operation::Div(a, b) => {
                let (x, y) = (read(a), read(b));
                quote!(#x / #y)
            }
            // A root is not odd: the sign of its argument stays.
            Operation::Sqrt(a) => {
                let x = self.signed(a);
                quote!((#x).sqrt())
            }
            Operation::None => unreachable!("a step computes"),
        }
    }
}
