//! Functions that share a file, with the comments for the reader of that file.

use crate::function::Function;

/// The content of one generated file, in whatever language.
#[derive(Clone, Debug)]
pub struct Module {
    /// Lower-case letters, digits and underscores, a letter first.
    pub name: String,
    /// Lines of the file's head.
    pub doc: Vec<String>,
    /// In the order of the file.
    pub constants: Vec<Constant>,
    /// In the order of the file, after the constants.
    pub functions: Vec<Documented>,
    /// Whether the file also holds a controller that calls its functions `inverse_dynamics` and `gravity`.
    pub has_controller: bool,
}

/// A constant of the file.
#[derive(Clone, Debug)]
pub struct Constant {
    /// Upper-case letters, digits and underscores.
    pub name: String,
    /// One line that says what it is.
    pub doc: String,
    /// Its value.
    pub value: Value,
}

/// The value of a [`Constant`].
#[derive(Clone, Debug)]
pub enum Value {
    /// One text.
    Text(String),
    /// A list of texts.
    Texts(Vec<String>),
    /// A whole number, such as a fingerprint.
    Number(u64),
    /// A list of numbers, not empty and all finite.
    Reals(Vec<f64>),
}

/// A function and the lines above it: its equation, shapes and units.
#[derive(Clone, Debug)]
pub struct Documented {
    /// One entry a line.
    pub doc: Vec<String>,
    /// The function itself.
    pub function: Function,
    /// Whether the file also has a second function, which writes only the entries that are not zero for all inputs, and
    /// the list of their places. Such a function has one output, and is the only one of its file.
    pub is_sparse: bool,
}

impl Module {
    /// An empty module; `name` is made an identifier.
    pub fn new(name: &str) -> Module {
        Module {
            name: identifier(name),
            doc: Vec::new(),
            constants: Vec::new(),
            functions: Vec::new(),
            has_controller: false,
        }
    }

    /// Adds a constant with its line.
    pub fn constant(&mut self, name: &str, doc: &str, value: Value) {
        self.constants.push(Constant { name: name.into(), doc: doc.into(), value });
    }

    /// Adds a function with the lines of `doc`.
    pub fn function(&mut self, doc: &str, function: Function) {
        self.functions.push(Documented { doc: doc.lines().map(String::from).collect(), function, is_sparse: false });
    }

    /// Adds a function with the lines of `doc`, and beside it the one that leaves out zeros.
    pub fn sparse_function(&mut self, doc: &str, function: Function) {
        self.functions.push(Documented { doc: doc.lines().map(String::from).collect(), function, is_sparse: true });
    }
}

/// `name` as an identifier: lower case, anything else an underscore, a letter first.
fn identifier(name: &str) -> String {
    let mut identifier: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect();
    if identifier.chars().next().is_none_or(|c| !c.is_ascii_alphabetic()) {
        identifier.insert_str(0, "robot_");
    }
    identifier
}
