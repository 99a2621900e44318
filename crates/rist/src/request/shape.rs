//! The form of a field's values on a command line, in Python and in JSON.
//!
//! A field is one option of a request (a struct with all options of a command).

use serde_json::Value;

/// Describes how values of a type are written on a command line, in Python and in JSON.
#[derive(Clone, Debug)]
pub struct ValueShape {
    /// The expected values in words, for messages: `a whole number`.
    pub expected: String,
    /// The type in the Python stub.
    pub python: String,
    /// The type in a JSON schema.
    pub json: Value,
    /// How the value is given on a command line.
    pub flag: Flag,
    /// The allowed words, each with a line of help; if empty, all texts are allowed.
    pub words: Vec<(&'static str, &'static str)>,
    /// Whether a text is the path of a file to read.
    pub is_file: bool,
    /// Checks a text of the command line, before the step starts.
    pub check: fn(&str) -> Result<(), String>,
}

/// How a value is given on a command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flag {
    /// The flag is present or not, and has no value.
    Switch,
    /// The flag has one text as value.
    One,
    /// The flag has a number as value, which may be negative.
    Number,
    /// The flag has numbers as value, separated by commas; the first may be negative.
    Numbers,
    /// The flag has texts as value, separated by commas; it may be repeated.
    List,
    /// The flag has one text as value; it may be repeated.
    Repeated,
}

impl ValueShape {
    /// The form of a value that is one text, such as a number or a name. Types with a fixed list of words and types that are
    /// files have forms of their own. `check` fails for an invalid text.
    pub fn plain(
        expected: &str,
        python: &str,
        json: Value,
        flag: Flag,
        check: fn(&str) -> Result<(), String>,
    ) -> ValueShape {
        ValueShape {
            expected: expected.into(),
            python: python.into(),
            json,
            flag,
            words: Vec::new(),
            is_file: false,
            check,
        }
    }
}
