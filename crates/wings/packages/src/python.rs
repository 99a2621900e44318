//! Writes a function as Python code with one assignment for each operation. The code computes with plain numbers, without
//! NumPy.

use expr::{Algebra, Expr, Function, Node, Symbol};

/// The algebra whose elements are texts of Python: names of variables, or numbers.
struct Text<'a> {
    function: &'a Function,
    lines: Vec<String>,
}

impl Text<'_> {
    fn assigned(&mut self, expression: &str) -> String {
        let name = format!("t{}", self.lines.len());
        self.lines.push(format!("    {name} = {expression}\n"));
        name
    }

    /// The Python text for a symbol: the input and the index of the entry with this symbol. `is_it` selects the symbol.
    fn entry(&self, is_it: impl Fn(Symbol) -> bool) -> String {
        let graph = self.function.graph();
        let is_entry = |e: &Expr| matches!(graph.node(*e), Node::Symbol(s) if is_it(s));
        let found = self.function.inputs.iter().find_map(|input| {
            let k = input.entries.iter().position(is_entry)?;
            Some(format!("{}[{k}]", input.name))
        });
        found.unwrap_or_else(|| "nan".into())
    }

    fn angle(&self, argument: Expr) -> String {
        match self.function.graph().node(argument) {
            Node::Symbol(symbol) => self.entry(|other| other == symbol),
            // A derived function has only sines of inputs.
            _ => "nan".into(),
        }
    }
}

impl Algebra for Text<'_> {
    type Value = String;
    fn constant(&mut self, x: f64) -> String {
        if x < 0.0 { format!("({x:?})") } else { format!("{x:?}") }
    }
    fn symbol(&mut self, symbol: Symbol) -> String {
        self.entry(|other| other == symbol)
    }
    fn sin(&mut self, argument: Expr) -> String {
        let angle = self.angle(argument);
        self.assigned(&format!("sin({angle})"))
    }
    fn cos(&mut self, argument: Expr) -> String {
        let angle = self.angle(argument);
        self.assigned(&format!("cos({angle})"))
    }
    fn neg(&mut self, a: &String) -> String {
        self.assigned(&format!("-{a}"))
    }
    fn add(&mut self, a: &String, b: &String) -> String {
        self.assigned(&format!("{a} + {b}"))
    }
    fn sub(&mut self, a: &String, b: &String) -> String {
        self.assigned(&format!("{a} - {b}"))
    }
    fn mul(&mut self, a: &String, b: &String) -> String {
        self.assigned(&format!("{a} * {b}"))
    }
    fn div(&mut self, a: &String, b: &String) -> String {
        self.assigned(&format!("{a} / {b}"))
    }
    fn sqrt(&mut self, a: &String) -> String {
        self.assigned(&format!("sqrt({a})"))
    }
}

/// The definition of a Python function that returns the first output of `function` as a list, row by row. Its arguments are the
/// inputs of `function`.
pub(crate) fn definition(function: &Function, doc: &str) -> String {
    let mut text = Text { function, lines: Vec::new() };
    let outputs = function.evaluate_in(&mut text);
    let inputs: Vec<&str> = function.inputs.iter().map(|input| input.name.as_str()).collect();
    let returned = outputs.first().map_or(String::new(), |entries| entries.join(", "));
    let (name, body) = (&function.name, text.lines.concat());
    format!("def {name}({}):\n    \"\"\"{doc}\"\"\"\n{body}    return [{returned}]\n", inputs.join(", "))
}
