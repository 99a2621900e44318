//! How the values of a type are written: on a command line, in Python, in JSON.

use serde_json::Value;

/// How the values of a type are written.
#[derive(Clone, Debug)]
pub struct Shape {
    /// `a whole number`.
    pub expected: String,
    /// The type in a stub of Python.
    pub python: String,
    /// The type in a JSON schema.
    pub json: Value,
    /// How a command line gives it.
    pub flag: Flag,
    /// The words that it takes, each with a line of help; none: it takes other texts too.
    pub words: Vec<(&'static str, &'static str)>,
    /// Whether a text of it is the path of a file that is read.
    pub is_file: bool,
    /// Refuses a text of the command line before anything else is done.
    pub check: fn(&str) -> Result<(), String>,
}

/// How a command line gives a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flag {
    /// It is there or not.
    Switch,
    /// With one text.
    One,
    /// With a number, which may be negative.
    Number,
    /// With numbers that commas divide; the first may be negative.
    Numbers,
    /// With texts that commas divide; it may be repeated.
    List,
    /// With one text each time; it may be repeated.
    Repeated,
}

impl Shape {
    /// Of a plain type; `check` refuses texts.
    pub fn plain(
        expected: &str,
        python: &str,
        json: Value,
        flag: Flag,
        check: fn(&str) -> Result<(), String>,
    ) -> Shape {
        Shape { expected: expected.into(), python: python.into(), json, flag, words: Vec::new(), is_file: false, check }
    }
}
