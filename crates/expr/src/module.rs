//! The functions of one generated file, with the comments that explain them in this file.

use crate::function::{Function, SparsityPattern};

/// The content of one generated file, independent of its language.
#[derive(Clone, Debug)]
pub struct Module {
    /// Name of lower-case letters, digits and underscores, a letter first.
    pub name: String,
    /// Comment lines at the head of the file.
    pub doc: Vec<String>,
    /// The constants in the order of the file.
    pub constants: Vec<Constant>,
    /// The functions in the order of the file, after the constants.
    pub functions: Vec<Documented>,
    /// Whether the file also contains a controller that calls its functions `inverse_dynamics` and `gravity`.
    pub has_controller: bool,
}

/// A constant of the file.
#[derive(Clone, Debug)]
pub struct Constant {
    /// Name of upper-case letters, digits and underscores.
    pub name: String,
    /// One comment line with the meaning of the constant.
    pub doc: String,
    /// The value of the constant.
    pub value: ConstantValue,
}

/// The value of a [`Constant`].
#[derive(Clone, Debug)]
pub enum ConstantValue {
    /// One text.
    Text(String),
    /// A list of texts.
    Texts(Vec<String>),
    /// A whole number, such as a fingerprint.
    Number(u64),
    /// A list of numbers, not empty and all finite.
    Reals(Vec<f64>),
}

/// A function and the comment lines above it: its equation, shapes and units.
#[derive(Clone, Debug)]
pub struct Documented {
    /// The comment lines above the function.
    pub doc: Vec<String>,
    /// The function itself.
    pub function: Function,
    /// The matrix entries that a second function in the file computes; `None` if there is no second function. If there is one,
    /// `function` has only one output.
    pub entries: Option<Entries>,
}

/// The entries of a matrix that a second function in the file writes.
#[derive(Clone, Debug)]
pub struct Entries {
    /// Name of the constant that lists the positions of the entries: upper-case letters and underscores.
    pub list: String,
    /// The positions of the entries.
    pub of: SparsityPattern,
}

impl Module {
    /// An empty module; `name` is converted to an identifier.
    pub fn new(name: &str) -> Module {
        Module {
            name: identifier(name),
            doc: Vec::new(),
            constants: Vec::new(),
            functions: Vec::new(),
            has_controller: false,
        }
    }

    /// Adds a constant; `doc` is its comment line.
    pub fn constant(&mut self, name: &str, doc: &str, value: ConstantValue) {
        self.constants.push(Constant { name: name.into(), doc: doc.into(), value });
    }

    /// Adds a function; `doc`: its comment lines. If some entries of its matrix are zero or follow by symmetry, a second function
    /// is generated that writes only the other entries.
    pub fn function(&mut self, doc: &str, function: Function) {
        let entries = match &function.outputs[..] {
            [o] if o.columns > 1 => {
                let (of, list) = (function.sparsity_pattern(0), function.name.to_ascii_uppercase() + "_PLACES");
                (of.places.len() < o.entries.len()).then_some(Entries { list, of })
            }
            _ => None,
        };
        self.functions.push(Documented { doc: doc.lines().map(String::from).collect(), function, entries });
    }

    /// Adds the base regressor, and a second function that writes only its non-zero entries. The constant `NON_ZEROS` lists the
    /// positions of these entries.
    pub fn regressor(&mut self, doc: &str, function: Function) {
        let of = SparsityPattern { places: function.non_zeros(0), is_symmetric: false };
        let entries = Some(Entries { list: "NON_ZEROS".into(), of });
        self.functions.push(Documented { doc: doc.lines().map(String::from).collect(), function, entries });
    }
}

/// `name` converted to an identifier: in lower case, with underscores for other characters, and starting with a letter.
fn identifier(name: &str) -> String {
    let mut identifier: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect();
    if identifier.chars().next().is_none_or(|c| !c.is_ascii_alphabetic()) {
        identifier.insert_str(0, "robot_");
    }
    identifier
}
