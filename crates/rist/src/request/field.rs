//! Describes one option of a step (a command, for example `rist identify`) as data: name, text, default, range and allowed words.
//!
//! Each option is defined once, with the macro [`request!`](crate::request!). The flags of the program with their help, the
//! keywords and stubs of Python, the tables of the docs and the JSON schema are generated from this data.

use serde_json::Value;

use super::range::Range;
use super::shape::ValueShape;
use super::types::FieldType;

/// One option of a request.
#[derive(Clone, Debug)]
pub struct Field {
    /// The name in Rust and Python. The flag has `-` instead of `_`.
    pub name: &'static str,
    /// The description, without a full stop at the end. Names of other fields are in brackets: `[limits]`.
    pub doc: String,
    /// The form of the values on a command line, in Python and in JSON.
    pub shape: ValueShape,
    /// The value if the user gives none; null if there is none.
    pub default: Value,
    /// The allowed range of the numbers.
    pub range: Range,
    /// The heading above this flag in the help; if empty, the flag is under the general heading of options.
    pub value_name: &'static str,
    /// The letter of the short flag, if there is one.
    pub short: Option<char>,
    /// The heading in the help; if empty, the general heading of options.
    pub heading: &'static str,
    /// The name of the flag if it is not the name of the field: a word such as `as`, which Rust and Python reserve.
    flag: Option<&'static str>,
}

impl Field {
    /// Makes a field of type `T`; `doc`: the lines of its doc comment.
    pub fn new<T: FieldType>(name: &'static str, doc: &[&str], default: &T) -> Field {
        let doc = doc.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ");
        Field {
            name,
            doc: doc.strip_suffix('.').filter(|doc| !doc.ends_with('.')).unwrap_or(&doc).to_string(),
            shape: T::shape(),
            default: default.to_value(),
            range: Range::Any,
            value_name: "",
            short: None,
            heading: "",
            flag: None,
        }
    }

    /// Appends `more` to the description of the field.
    pub fn and(self, more: &str) -> Field {
        Field { doc: format!("{} {more}", self.doc), ..self }
    }

    /// Replaces the bracket `[default: ..]` in the description by `[default: value]`. Needed for defaults from other crates,
    /// whose doc names a constant, for example `[default: SignalOptions::order]`.
    pub fn default_from(self, value: impl std::fmt::Display) -> Field {
        let (before, behind) = self.doc.split_once("[default: ").expect("a doc that names its default");
        let (_, behind) = behind.split_once(']').expect("a bracket that closes");
        Field { doc: format!("{before}[default: {value}]{behind}"), ..self }
    }

    /// Sets the allowed range.
    pub fn range(self, range: impl Into<Range>) -> Field {
        Field { range: range.into(), ..self }
    }

    /// Sets the name of the flag's value in the help.
    pub fn value_name(self, value_name: &'static str) -> Field {
        Field { value_name, ..self }
    }

    /// Sets the letter of a short flag.
    pub fn short(self, letter: char) -> Field {
        Field { short: Some(letter), ..self }
    }

    /// Sets the heading in the help.
    pub fn heading(self, heading: &'static str) -> Field {
        Field { heading, ..self }
    }

    /// Sets the name of the flag, where it is not the name of the field.
    pub fn flag(self, flag: &'static str) -> Field {
        Field { flag: Some(flag), ..self }
    }

    /// The name of this field's flag, without the dashes.
    pub fn flag_name(&self) -> String {
        self.flag.map_or_else(|| self.name.replace('_', "-"), String::from)
    }
}
