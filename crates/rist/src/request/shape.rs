//! The forms of the values of a type: on a command line, in Python, in JSON.

use serde_json::Value;

/// The forms of the values of a type.
#[derive(Clone, Debug)]
pub struct ValueShape {
    /// The expected values in words: `a whole number`.
    pub expected: String,
    /// The type in a stub of Python.
    pub python: String,
    /// The type in a JSON schema.
    pub json: Value,
    /// The form on a command line.
    pub flag: Flag,
    /// The allowed words, each with a line of help; empty: other texts are allowed.
    pub words: Vec<(&'static str, &'static str)>,
    /// Whether a text is the path of a file that is read.
    pub is_file: bool,
    /// Checks a text of the command line before any work is done.
    pub check: fn(&str) -> Result<(), String>,
}

/// The form of a value on a command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flag {
    /// Present or not, without a value.
    Switch,
    /// With one text.
    One,
    /// With a number, which may be negative.
    Number,
    /// With numbers, separated by commas; the first may be negative.
    Numbers,
    /// With texts, separated by commas; it may be repeated.
    List,
    /// With one text each time; it may be repeated.
    Repeated,
}

impl ValueShape {
    /// The form of a type without words that is no file; `check` refuses texts.
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
