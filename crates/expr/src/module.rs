//! Functions that share a file, with the comments for the reader of that file.

use crate::function::{Function, TellingPlaces};

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
    /// What a second function of the file writes alone, where it has one. Such a function has one output.
    pub entries: Option<Entries>,
}

/// The entries of a matrix that a function of their own writes.
#[derive(Clone, Debug)]
pub struct Entries {
    /// The constant that lists their places: upper-case letters and underscores.
    pub list: String,
    /// The places.
    pub of: TellingPlaces,
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

    /// Adds a function with the lines of `doc`, and beside it the one of the entries that tell all of it, where these are
    /// fewer than all of a matrix.
    pub fn function(&mut self, doc: &str, function: Function) {
        let entries = match &function.outputs[..] {
            [o] if o.columns > 1 => {
                let (of, list) = (function.telling_places(0), function.name.to_ascii_uppercase() + "_PLACES");
                (of.places.len() < o.entries.len()).then_some(Entries { list, of })
            }
            _ => None,
        };
        self.functions.push(Documented { doc: doc.lines().map(String::from).collect(), function, entries });
    }

    /// Adds the base regressor: the places of its entries are `NON_ZEROS`, however many they are.
    pub fn regressor(&mut self, doc: &str, function: Function) {
        let of = TellingPlaces { places: function.non_zeros(0), is_symmetric: false };
        let entries = Some(Entries { list: "NON_ZEROS".into(), of });
        self.functions.push(Documented { doc: doc.lines().map(String::from).collect(), function, entries });
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
