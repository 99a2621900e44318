//! Writes a Function as a Rust function: one statement for each operation, in the order of the schedule.
//!
//! ```text
//! pub fn NAME<R: Real>(q: &[R; 3], ..., y: &mut [[R; 18]; 3]) {
//!     let ([s1, s2], [c1, c2]) = R::sin_cos_of_each([q[1], q[2]]);
//!     let t4 = s1 * dq[0];
//!     let t5 = t4.mul_add(c1, -q[0]);
//!     y[0][2] = t5;
//! ```
//! `mul_add` is a method of the trait `Real`: fused if the target can fuse. Only stores, sums and square roots have minus signs.

use std::fmt::Write as _;

use expr::{Entries, Expr, Function, Operation};
use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};

use crate::steps::{Name, Statement, is_read, names, steps};

/// A statement of the generated Rust function, as text or as tokens.
enum RustStatement {
    /// Text of a short statement, which the formatter would leave on one line.
    Line(String),
    /// Tokens of a statement that the formatter has to lay out.
    Tokens(TokenStream),
}

/// Blocks of short statements as text. The tokens for the formatter contain only the number of each block: a function has
/// thousands of short statements, and the formatter would spend most of its time and memory on them, although each is one line.
#[derive(Default)]
pub(crate) struct Lines(Vec<String>);

/// The formatter's spelling of `__lines!(`. In its output the call `__lines!(N);` represents block N until `put_into` replaces it
/// by the text of the block.
const BLOCK_NUMBER_PREFIX: &str = "__lines!(";
/// A statement of at most this many characters stays on one line, because the formatter breaks only lines of 90 or more.
const MAX_LINE_CHARACTERS: usize = 80;

impl Lines {
    /// The tokens of all statements, in order. The lines between two token statements become one numbered block.
    fn body(&mut self, statements: impl Iterator<Item = RustStatement>) -> TokenStream {
        let mut tokens = TokenStream::new();
        let mut text = String::new();
        for statement in statements {
            match statement {
                RustStatement::Line(line) => {
                    text += &line;
                    text.push('\n');
                }
                RustStatement::Tokens(laid_out) => {
                    tokens.extend(self.place(std::mem::take(&mut text)));
                    tokens.extend(laid_out);
                }
            }
        }
        tokens.extend(self.place(text));
        tokens
    }

    fn place(&mut self, text: String) -> TokenStream {
        if text.is_empty() {
            return TokenStream::new();
        }
        self.0.push(text);
        let number = Literal::usize_unsuffixed(self.0.len() - 1);
        quote!(__lines!(#number);)
    }

    /// Replaces each call `__lines!(N);` in `text` by the text of block N, with the same indentation.
    pub(crate) fn put_into(self, text: &str) -> String {
        let mut all = String::with_capacity(text.len() + self.0.iter().map(|lines| 2 * lines.len()).sum::<usize>());
        for line in text.split_inclusive('\n') {
            let inner = line.trim_start();
            let number =
                inner.strip_prefix(BLOCK_NUMBER_PREFIX).and_then(|rest| rest.split(')').next()?.parse::<usize>().ok());
            match number.and_then(|n| self.0.get(n)) {
                Some(lines) => {
                    let indent = &line[..line.len() - inner.len()];
                    lines.lines().for_each(|line| all.extend([indent, line, "\n"]));
                }
                None => all += line,
            }
        }
        all
    }
}

/// Tokens of a Rust function that computes `bound` (a function without named constants), generic over the trait `Real`.
///
/// Inputs become `&[R; n]`, outputs `&mut [[R; columns]; rows]`, or `&mut [R; rows]` with one column; an input that is not used
/// is named `_NAME`.
pub(crate) fn render(bound: &Function, lines: &mut Lines) -> TokenStream {
    let steps = steps(bound);
    let writer = Writer::new(bound);
    let (head, body) = (head(bound), lines.body(steps.iter().map(|step| writer.statement(step))));
    quote! {
        #[inline(always)]
        #head {
            #body
        }
    }
}

/// Tokens of three Rust functions for `bound`: a dense one, a sparse one that writes only the entries in the list `entries`, and
/// a third one that the two others call. The third one has the operations and passes each entry to a closure. The list of places
/// comes before the functions; `doc` is the comment of the dense function. The dense function does not fill the matrix from the
/// list, because then all entries would have to be kept until the end, and would be spilled from their registers.
pub(crate) fn render_entries(bound: &Function, entries: &Entries, doc: &TokenStream, lines: &mut Lines) -> TokenStream {
    let (places, is_symmetric) = (&entries.of.places, entries.of.is_symmetric);
    let (n, literal) = (Literal::usize_unsuffixed(places.len()), Literal::usize_unsuffixed);
    let pair = |row: Literal, column: Literal| quote!((#row, #column));
    let list = places.iter().map(|&(row, column)| pair(literal(row), literal(column)));
    let (steps, writer) = (steps(bound), Writer::new(bound));
    let statements = steps.iter().filter_map(|step| match *step {
        Statement::Store { row, column, node, negative, .. } => {
            // Entries that are always zero, or below the diagonal of a symmetric matrix, are not in the list and are not stored.
            let k = places.binary_search(&(row, column)).ok()?;
            let (sign, value) = (if negative { "-" } else { "" }, writer.operand(node));
            Some(RustStatement::Line(format!("set({k}, {row}, {column}, {sign}{value});")))
        }
        _ => Some(writer.statement(step)),
    });
    let body = lines.body(statements);
    let output = &bound.outputs[0];
    let (handed, sparse) = (format_ident!("{}_entries", bound.name), format_ident!("{}_non_zeros", bound.name));
    let (head, arguments, inputs) = (head(bound), input_arguments(bound), input_names(bound));
    let (y, zero) = (format_ident!("{}", output.name), quote!(R::from_f64(0.0)));
    let (rows, columns) = (literal(output.rows), literal(output.columns));
    // The dense function stores each entry at its place, and an entry of a symmetric matrix also at the mirrored place.
    let (zeros, place) = match (output.columns, is_symmetric) {
        (1, _) => (quote!([#zero; #rows]), quote!(|_, row, _, x| #y[row] = x)),
        (_, false) => (quote!([[#zero; #columns]; #rows]), quote!(|_, row, column, x| #y[row][column] = x)),
        (_, true) => {
            let place = quote!(|_, row: usize, column: usize, x| {
                #y[row][column] = x;
                #y[column][row] = x;
            });
            (quote!([[#zero; #columns]; #rows]), place)
        }
    };
    let name = format_ident!("{}", entries.list);
    let of = if is_symmetric { " of the upper triangle" } else { "" };
    let list_doc = format!(" Row and column of each entry{of} that is not always zero, row by row.");
    let sparse_doc =
        format!(" The entries{of} of `{}` that are not always zero, in the order of `{name}`.", bound.name);
    let entries_doc = format!(
        " Hands every entry{of} that is not always zero to `set`, after its number in `{name}`, row and column."
    );
    quote! {
        #[doc = #list_doc]
        pub const #name: [(usize, usize); #n] = [#(#list),*];
        #doc
        #[inline(always)]
        #head {
            *#y = #zeros;
            #handed(#(#inputs,)* #place);
        }
        #[doc = #sparse_doc]
        #[inline(always)]
        pub fn #sparse<R: Real>(#arguments #y: &mut [R; #n]) {
            #handed(#(#inputs,)* |entry, _, _, x| #y[entry] = x);
        }
        #[doc = #entries_doc]
        #[inline(always)]
        pub fn #handed<R: Real>(#arguments mut set: impl FnMut(usize, usize, usize, R)) {
            #body
        }
    }
}

fn input_names(bound: &Function) -> Vec<Ident> {
    bound.inputs.iter().enumerate().map(|(k, input)| input_name(bound, k, &input.name)).collect()
}

/// The arguments of the Rust function for its inputs, as tokens, each followed by a comma.
fn input_arguments(bound: &Function) -> TokenStream {
    let arguments = input_names(bound).into_iter().zip(&bound.inputs).map(|(name, input)| {
        let n = Literal::usize_unsuffixed(input.entries.len());
        quote!(#name: &[R; #n])
    });
    quote!(#(#arguments,)*)
}

/// The name of the Rust argument for input k; it begins with an underscore if the function does not use the input.
fn input_name(bound: &Function, k: usize, name: &str) -> Ident {
    let read = (0..bound.inputs[k].entries.len()).any(|i| is_read(bound, k, i));
    if read { format_ident!("{name}") } else { format_ident!("_{name}") }
}

/// Tokens of the Rust function's name and arguments with their types, without its body.
fn head(bound: &Function) -> TokenStream {
    let name = Ident::new(&bound.name, Span::call_site());
    let inputs = input_arguments(bound);
    let outputs = bound.outputs.iter().map(|output| {
        let name = format_ident!("{}", output.name);
        let (rows, columns) = (Literal::usize_unsuffixed(output.rows), Literal::usize_unsuffixed(output.columns));
        if output.columns == 1 { quote!(#name: &mut [R; #rows]) } else { quote!(#name: &mut [[R; #columns]; #rows]) }
    });
    quote!(pub fn #name<R: Real>(#inputs #(#outputs,)*))
}

struct Writer<'a> {
    function: &'a Function,
    names: Vec<Name>,
}

impl Writer<'_> {
    fn new(function: &Function) -> Writer<'_> {
        Writer { function, names: names(function) }
    }

    fn operand_or_nothing(&self, n: Option<usize>) -> TokenStream {
        n.map_or_else(|| quote!(_), |n| self.tokens(n))
    }

    /// The value of node n as an operand, in tokens: constant, entry of an input, or variable.
    fn tokens(&self, n: usize) -> TokenStream {
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

    /// The value of node n as an operand, in text: constant, entry of an input, or variable.
    fn operand(&self, n: usize) -> String {
        match &self.names[n] {
            Name::Constant(x) => format!("R::from_f64({})", Literal::f64_unsuffixed(*x)),
            Name::Input { input, entry } => format!("{}[{entry}]", self.function.inputs[*input].name),
            Name::Variable(name) => name.to_string(),
        }
    }

    fn statement(&self, step: &Statement) -> RustStatement {
        match *step {
            Statement::Compute(n, operation) => {
                self.line(format!("let {} = {};", self.operand(n), self.value(operation)))
            }
            Statement::SinCos(ref angles) => {
                let sines: Vec<_> = angles.iter().map(|a| self.operand_or_nothing(a.sine)).collect();
                let cosines: Vec<_> = angles.iter().map(|a| self.operand_or_nothing(a.cosine)).collect();
                let of: Vec<_> = angles.iter().map(|a| self.tokens(a.angle)).collect();
                RustStatement::Tokens(match &of[..] {
                    [angle] => quote!(let (#(#sines),*, #(#cosines),*) = (#angle).sin_cos();),
                    _ => quote!(let ([#(#sines),*], [#(#cosines),*]) = R::sin_cos_of_each([#(#of),*]);),
                })
            }
            Statement::Store { output, row, column, node, negative } => {
                let output = &self.function.outputs[output];
                let mut line = format!("{}[{row}]", output.name);
                if output.columns > 1 {
                    // Writing to a String cannot fail.
                    let _ = write!(line, "[{column}]");
                }
                let sign = if negative { "-" } else { "" };
                self.line(format!("{line} = {sign}{};", self.operand(node)))
            }
        }
    }

    /// The statement with this text: as text if it is short enough, otherwise as tokens.
    fn line(&self, text: String) -> RustStatement {
        if text.len() <= MAX_LINE_CHARACTERS {
            return RustStatement::Line(text);
        }
        // Text written by this module always parses.
        text.parse().map_or(RustStatement::Line(text), RustStatement::Tokens)
    }

    /// The value of the node of `e` as an operand, in text, with a minus if `e` is negative.
    fn signed(&self, e: Expr) -> String {
        match (e.is_negative(), &self.names[e.node()]) {
            (false, _) => self.operand(e.node()),
            (true, Name::Constant(x)) => format!("R::from_f64(-{})", Literal::f64_unsuffixed(*x)),
            (true, _) => format!("-{}", self.operand(e.node())),
        }
    }

    fn value(&self, operation: Operation) -> String {
        let read = |e: Expr| self.operand(e.node());
        match operation {
            Operation::Add(a, b) => {
                let sign = if b.is_negative() { '-' } else { '+' };
                format!("{} {sign} {}", read(a), read(b))
            }
            Operation::MulAdd(a, b, c) => {
                let (x, y, z) = (self.signed(a), read(b), self.signed(c));
                let bare = !a.is_negative() || matches!(self.names[a.node()], Name::Constant(_));
                if bare { format!("{x}.mul_add({y}, {z})") } else { format!("({x}).mul_add({y}, {z})") }
            }
            Operation::Mul(a, b) => format!("{} * {}", read(a), read(b)),
            Operation::Div(a, b) => format!("{} / {}", read(a), read(b)),
            // sqrt(-a) differs from -sqrt(a), so the sign of the argument stays inside the root.
            Operation::Sqrt(a) => format!("({}).sqrt()", self.signed(a)),
            Operation::None => unreachable!("a step computes"),
        }
    }
}
