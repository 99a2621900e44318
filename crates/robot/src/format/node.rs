//! Parses a YAML text into a tree. Every value has its line and column.
//!
//! Only this file uses the YAML library. The library refuses duplicate keys, and texts with too many aliases or too deep
//! nesting. Other files interpret the values.

use std::fmt;

use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_yaml::{DuplicateKeyPolicy, Spanned};

use super::budget::{REPEATS_TOO_MUCH, budget, is_beyond_budget};
use crate::error::{Error, Place};
use gate::suggestion::did_you_mean;

/// A value of the YAML text with its line and column.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub line: usize,
    pub column: usize,
    pub content: NodeValue,
}

#[derive(Clone, Debug)]
pub(super) enum NodeValue {
    Null,
    Bool(bool),
    Number(f64),
    Text(String),
    List(Vec<Node>),
    Map(Vec<(Key, Node)>),
}

#[derive(Clone, Debug)]
pub(super) struct Key {
    pub line: usize,
    pub column: usize,
    pub text: String,
}

/// The file that is being read. Its name appears in errors.
#[derive(Clone, Copy, Debug)]
pub(super) struct DescriptionFile<'a> {
    pub file: &'a str,
}

impl DescriptionFile<'_> {
    pub(super) fn error(self, line: usize, column: usize, message: impl Into<String>) -> Error {
        Error { place: Place { file: self.file.into(), line, column }, message: message.into() }
    }

    pub(super) fn place(self, at: (usize, usize), message: impl Into<String>) -> Error {
        self.error(at.0, at.1, message)
    }

    /// An error that concerns the whole file; it has no line.
    pub(super) fn whole(self, message: impl Into<String>) -> Error {
        self.error(0, 0, message)
    }

    pub(super) fn at(self, node: &Node, message: impl Into<String>) -> Error {
        self.error(node.line, node.column, message)
    }

    pub(super) fn at_key(self, key: &Key, message: impl Into<String>) -> Error {
        self.error(key.line, key.column, message)
    }

    /// Parses a YAML text into a tree.
    pub(super) fn parse(self, text: &str) -> Result<Node, Error> {
        self.parse_with(text, DuplicateKeyPolicy::Error).map_err(|(_, error)| error)
    }

    /// Parses a YAML text into a tree. If a key occurs twice in a map, the last value counts, as in PyYAML. Also returns a
    /// sentence on the first such key.
    pub(super) fn parse_last_key(self, text: &str) -> Result<(Node, Option<String>), Error> {
        match self.parse_with(text, DuplicateKeyPolicy::Error) {
            Err((true, error)) => {
                let node = self.parse_with(text, DuplicateKeyPolicy::LastWins).map_err(|(_, error)| error)?;
                Ok((node, Some(format!("{} (line {})", error.message, error.place.line))))
            }
            Err((false, error)) => Err(error),
            Ok(node) => Ok((node, None)),
        }
    }

    /// Parses a YAML text. An error says whether a key stands twice.
    fn parse_with(self, text: &str, duplicate_keys: DuplicateKeyPolicy) -> Result<Node, (bool, Error)> {
        let options = serde_yaml::options! {
            budget: budget(text),
            duplicate_keys: duplicate_keys,
            strict_booleans: true,
            with_snippet: false,
            // A number that is not finite is accepted here. It is refused later, when the message can say which quantity it is.
            non_finite_float_policy: serde_yaml::NonFiniteFloatPolicy::PassThrough,
        };
        serde_yaml::from_str_with_options(text, options).map_err(|e| {
            let (line, column) = e.location().map_or((0, 0), |l| (place(l.line()), place(l.column())));
            let message = match &e {
                serde_yaml::Error::DuplicateMappingKey { key: Some(key), .. } => {
                    format!("the key `{key}` stands twice")
                }
                e if is_beyond_budget(e) => REPEATS_TOO_MUCH.into(),
                e => format!("not valid YAML: {}", without_place(&e.to_string())),
            };
            (matches!(e, serde_yaml::Error::DuplicateMappingKey { .. }), self.error(line, column, message))
        })
    }
}

fn place(n: u64) -> usize {
    usize::try_from(n).unwrap_or(0)
}

/// Removes the place that the library adds at the end of a message, because our messages start with the place.
fn without_place(message: &str) -> &str {
    let first = message.lines().next().unwrap_or("");
    first.find(" at line ").map_or(first, |at| &first[..at])
}

/// A hint for a key that is not valid in our table of Denavit-Hartenberg parameters, but is common in other such tables.
fn way_out(key: &str, valid: &[&str]) -> &'static str {
    match key {
        _ if !valid.contains(&"alpha") => "",
        "a" => " (`a` is of `convention: craig` or `convention: denavit-hartenberg`)",
        _ if key.ends_with("_deg") => " (degrees are read with `angles: deg`)",
        _ if key.ends_with("_mm") => " (millimetres are read with `lengths: mm`)",
        _ => "",
    }
}

impl Node {
    /// A description of the value for an error message.
    pub(super) fn kind(&self) -> String {
        match &self.content {
            NodeValue::Null => "nothing".into(),
            NodeValue::Bool(b) => format!("`{b}`"),
            NodeValue::Number(x) => format!("the number {x}"),
            NodeValue::Text(t) if t.chars().count() > 40 => "a long text".into(),
            NodeValue::Text(t) => format!("`{t}`"),
            NodeValue::List(items) => format!("a list of {}", items.len()),
            NodeValue::Map(_) => "a map".into(),
        }
    }

    /// The entries of a map. Fails if a key is not in `valid`. `what`: name of the map in errors.
    pub(super) fn fields<'a>(
        &'a self,
        source: DescriptionFile<'a>,
        what: &'a str,
        valid: &[&str],
    ) -> Result<Fields<'a>, Error> {
        let entries = self.map(source, what)?;
        for (key, _) in entries {
            if !valid.contains(&key.text.as_str()) {
                let meant = did_you_mean(&key.text, valid.iter().copied());
                let shown: String = key.text.chars().take(40).collect();
                let meant = if meant.is_empty() { way_out(&key.text, valid).into() } else { meant };
                let message = format!("unknown key `{shown}` in {what}{meant}; the keys are {}", valid.join(", "));
                return Err(source.at_key(key, message));
            }
        }
        Ok(Fields { source, what, node: self, entries })
    }

    pub(super) fn map<'a>(&'a self, source: DescriptionFile, what: &str) -> Result<&'a [(Key, Node)], Error> {
        match &self.content {
            NodeValue::Map(entries) => Ok(entries),
            _ => Err(source.at(self, format!("{what} must be a map of keys to values, found {}", self.kind()))),
        }
    }

    pub(super) fn list<'a>(&'a self, source: DescriptionFile, what: &str) -> Result<&'a [Node], Error> {
        match &self.content {
            NodeValue::List(items) => Ok(items),
            _ => Err(source.at(self, format!("{what} must be a list, found {}", self.kind()))),
        }
    }

    /// The value as text. A number is converted to its text. Fails for other values.
    pub(super) fn word(&self, source: DescriptionFile, what: &str) -> Result<String, Error> {
        match &self.content {
            NodeValue::Text(t) if !t.trim().is_empty() => Ok(t.clone()),
            NodeValue::Number(x) => Ok(x.to_string()),
            _ => Err(source.at(self, format!("{what} must be a name, found {}", self.kind()))),
        }
    }

    /// The index of the value in `words`. Fails if the value is none of them.
    pub(super) fn choice(&self, source: DescriptionFile, what: &str, words: &[&str]) -> Result<usize, Error> {
        let found = words.iter().position(|w| matches!(&self.content, NodeValue::Text(t) if t == w));
        found.ok_or_else(|| {
            let meant = match &self.content {
                NodeValue::Text(t) => did_you_mean(t, words.iter().copied()),
                _ => String::new(),
            };
            source.at(self, format!("{what} is {}, found {}{meant}", words.join(" or "), self.kind()))
        })
    }
}

/// A map of the YAML text. Its keys were checked and are all valid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fields<'a> {
    source: DescriptionFile<'a>,
    what: &'a str,
    node: &'a Node,
    entries: &'a [(Key, Node)],
}

impl<'a> Fields<'a> {
    pub(super) fn get(&self, key: &str) -> Option<&'a Node> {
        self.entries.iter().find(|(k, _)| k.text == key).map(|(_, v)| v)
    }

    pub(super) fn require(&self, key: &str) -> Result<&'a Node, Error> {
        self.get(key).ok_or_else(|| self.source.at(self.node, format!("`{key}` is missing in {}", self.what)))
    }
}

impl<'de> Deserialize<'de> for Node {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Node, D::Error> {
        let spanned = Spanned::<NodeValue>::deserialize(deserializer)?;
        let at = spanned.referenced;
        Ok(Node { line: place(at.line()), column: place(at.column()), content: spanned.value })
    }
}

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Key, D::Error> {
        let spanned = Spanned::<String>::deserialize(deserializer)?;
        let at = spanned.referenced;
        Ok(Key { line: place(at.line()), column: place(at.column()), text: spanned.value })
    }
}

impl<'de> Deserialize<'de> for NodeValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<NodeValue, D::Error> {
        deserializer.deserialize_any(ContentVisitor)
    }
}

struct ContentVisitor;

impl<'de> Visitor<'de> for ContentVisitor {
    type Value = NodeValue;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_unit<E>(self) -> Result<NodeValue, E> {
        Ok(NodeValue::Null)
    }

    fn visit_none<E>(self) -> Result<NodeValue, E> {
        Ok(NodeValue::Null)
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<NodeValue, D::Error> {
        NodeValue::deserialize(deserializer)
    }

    fn visit_bool<E>(self, b: bool) -> Result<NodeValue, E> {
        Ok(NodeValue::Bool(b))
    }

    fn visit_i64<E>(self, x: i64) -> Result<NodeValue, E> {
        Ok(NodeValue::Number(x as f64))
    }

    fn visit_u64<E>(self, x: u64) -> Result<NodeValue, E> {
        Ok(NodeValue::Number(x as f64))
    }

    fn visit_i128<E>(self, x: i128) -> Result<NodeValue, E> {
        Ok(NodeValue::Number(x as f64))
    }

    fn visit_u128<E>(self, x: u128) -> Result<NodeValue, E> {
        Ok(NodeValue::Number(x as f64))
    }

    fn visit_f64<E>(self, x: f64) -> Result<NodeValue, E> {
        Ok(NodeValue::Number(x))
    }

    fn visit_str<E>(self, text: &str) -> Result<NodeValue, E> {
        Ok(NodeValue::Text(text.to_string()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<NodeValue, A::Error> {
        let mut list = Vec::new();
        while let Some(item) = items.next_element()? {
            list.push(item);
        }
        Ok(NodeValue::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<NodeValue, A::Error> {
        let mut map = Vec::new();
        while let Some(entry) = entries.next_entry()? {
            map.push(entry);
        }
        Ok(NodeValue::Map(map))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: DescriptionFile = DescriptionFile { file: "f" };

    #[test]
    fn values_know_their_place() {
        let root = SOURCE.parse("a: 1\nb:\n  - x/2\n  - {c: .5}\n").unwrap();
        let fields = root.fields(SOURCE, "it", &["a", "b"]).unwrap();
        let list = fields.require("b").unwrap().list(SOURCE, "b").unwrap();
        assert_eq!((list[0].line, list[0].column), (3, 5));
        let (key, value) = &list[1].map(SOURCE, "c").unwrap()[0];
        assert_eq!((key.line, key.column, value.column), (4, 6, 9));
    }

    #[test]
    fn what_is_not_a_tree_is_refused() {
        let deep = "[".repeat(20_000);
        let laughs = "a: &a [1]\nb: &b [*a, *a]\na: 2\n";
        for (text, part) in [("a: 1\na: 2", "f:2:1: the key `a` stands twice"), (&deep, "f:"), (laughs, "f:3:1")] {
            let message = SOURCE.parse(text).unwrap_err().to_string();
            assert!(message.contains(part) && message.len() < 200, "{message}");
        }
    }
}
