//! A field of a request as data: its name, what it says, its default, its range and the words that it takes.
//!
//! The fields of a request are written once, by [`request!`](crate::request!). Flags and their help, keywords of Python,
//! stubs, tables and the JSON schema are made from what stands here.

use serde_json::Value;

use super::range::Range;
use super::shape::Shape;
use super::types::FieldType;

/// One field of a request.
#[derive(Clone, Debug)]
pub struct Field {
    /// As in Rust and Python; a flag has `-` for `_`.
    pub name: &'static str,
    /// What it says, without a full stop at the end; another field stands in brackets, as `[limits]`.
    pub doc: String,
    /// How values are written.
    pub shape: Shape,
    /// The value that it has if it is not given; null: none.
    pub default: Value,
    /// Where its numbers lie.
    pub range: Range,
    /// What the value of the flag is called in its help; empty: as the field.
    pub value_name: &'static str,
    /// The letter of a short flag.
    pub short: Option<char>,
    /// The heading of the help that it stands below; empty: that of all options.
    pub heading: &'static str,
}

impl Field {
    /// A field of this type, with the lines of its doc comment.
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
        }
    }

    /// The same with more words behind what it says.
    pub fn and(self, more: &str) -> Field {
        Field { doc: format!("{} {more}", self.doc), ..self }
    }

    /// The same, where the default is a constant of another crate: the value in place of the name that the doc has for it,
    /// as `[default: SignalOptions::order]`.
    pub fn default_from(self, value: impl std::fmt::Display) -> Field {
        let (before, behind) = self.doc.split_once("[default: ").expect("a doc that names its default");
        let (_, behind) = behind.split_once(']').expect("a bracket that closes");
        Field { doc: format!("{before}[default: {value}]{behind}"), ..self }
    }

    /// The same in a range.
    pub fn range(self, range: impl Into<Range>) -> Field {
        Field { range: range.into(), ..self }
    }

    /// The same with a name of its value.
    pub fn value_name(self, value_name: &'static str) -> Field {
        Field { value_name, ..self }
    }

    /// The same with a short flag.
    pub fn short(self, letter: char) -> Field {
        Field { short: Some(letter), ..self }
    }

    /// The same below a heading.
    pub fn heading(self, heading: &'static str) -> Field {
        Field { heading, ..self }
    }

    /// The name of its flag, without the dashes.
    pub fn flag_name(&self) -> String {
        self.name.replace('_', "-")
    }
}
