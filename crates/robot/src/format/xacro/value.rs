//! Values of properties and expressions, with the types of Python.

use std::collections::BTreeMap;
use std::rc::Rc;

use crate::format::node::{Node, NodeValue};

/// Largest length of a text value, bytes.
pub(super) const MAX_TEXT_BYTES: usize = 1 << 20;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum XacroValue {
    None,
    Bool(bool),
    Int(i64),
    Number(f64),
    Text(String),
    List(Rc<Vec<XacroValue>>),
    /// A map from texts to values.
    Map(Rc<BTreeMap<String, XacroValue>>),
}

/// Supplies the values of names and arguments, and the content of YAML files.
pub(super) trait NameSource {
    fn value(&mut self, name: &str) -> Result<XacroValue, String>;
    fn yaml(&mut self, file: &str) -> Result<XacroValue, String>;
    fn argument(&mut self, name: &str) -> Result<XacroValue, String>;
}

impl XacroValue {
    /// The value that a text spells: a number, a boolean, or the text itself.
    pub(super) fn literal(text: &str) -> XacroValue {
        if let Some(quoted) = text.strip_prefix('\'').and_then(|rest| rest.strip_suffix('\'')) {
            return XacroValue::Text(quoted.into());
        }
        let trimmed = text.trim();
        // A text with underscores is not read as a number.
        let number =
            || trimmed.parse().ok().filter(|_| trimmed.bytes().any(|b| b.is_ascii_digit()) && !text.contains('_'));
        match trimmed {
            "true" | "True" => XacroValue::Bool(true),
            "false" | "False" => XacroValue::Bool(false),
            _ => match trimmed.parse().ok().filter(|_| !text.contains('_')) {
                Some(whole) => XacroValue::Int(whole),
                None => number().map_or_else(|| XacroValue::Text(text.into()), XacroValue::Number),
            },
        }
    }

    pub(super) fn number(&self) -> Option<f64> {
        match *self {
            XacroValue::Bool(b) => Some(f64::from(u8::from(b))),
            XacroValue::Int(i) => Some(i as f64),
            XacroValue::Number(x) => Some(x),
            _ => None,
        }
    }

    /// Whether the value counts as true in a condition of an expression.
    pub(super) fn holds(&self) -> bool {
        match self {
            XacroValue::None => false,
            XacroValue::Text(text) => !text.is_empty(),
            XacroValue::List(items) => !items.is_empty(),
            XacroValue::Map(entries) => !entries.is_empty(),
            other => other.number() != Some(0.0),
        }
    }

    /// The value of the attribute `value` of an `if` as a boolean; `None` if it is no boolean.
    pub(super) fn truth(&self) -> Option<bool> {
        match self {
            XacroValue::Text(text) => match text.trim() {
                "true" | "True" => Some(true),
                "false" | "False" => Some(false),
                other => other.parse::<i64>().ok().map(|i| i != 0),
            },
            other => other.number().map(|x| x != 0.0),
        }
    }

    pub(super) fn kind(&self) -> &'static str {
        match self {
            XacroValue::None => "nothing",
            XacroValue::Bool(_) => "a truth",
            XacroValue::Int(_) | XacroValue::Number(_) => "a number",
            XacroValue::Text(_) => "a text",
            XacroValue::List(_) => "a list",
            XacroValue::Map(_) => "a map",
        }
    }

    /// The value as text, for insertion into other text.
    pub(super) fn text(&self) -> String {
        match self {
            XacroValue::None => "None".into(),
            XacroValue::Bool(b) => if *b { "True" } else { "False" }.into(),
            XacroValue::Int(i) => i.to_string(),
            XacroValue::Number(x) => format!("{x:?}"),
            XacroValue::Text(text) => text.clone(),
            XacroValue::List(items) => {
                format!("[{}]", items.iter().map(XacroValue::text).collect::<Vec<_>>().join(", "))
            }
            XacroValue::Map(_) => "{..}".into(),
        }
    }

    /// The element of a list or a text at an index, or the entry of a map with a key; `None` if it does not exist.
    pub(super) fn entry(&self, key: &XacroValue) -> Option<XacroValue> {
        let place = |i: i64, length: usize| match i < 0 {
            true => length.checked_sub(i.unsigned_abs() as usize),
            false => Some(i as usize),
        };
        match (self, key) {
            (XacroValue::List(items), XacroValue::Int(i)) => items.get(place(*i, items.len())?).cloned(),
            (XacroValue::Text(text), XacroValue::Int(i)) => {
                let character = text.chars().nth(place(*i, text.chars().count())?)?;
                Some(XacroValue::Text(character.into()))
            }
            (XacroValue::Map(entries), key) => entries.get(&key.text()).cloned(),
            _ => None,
        }
    }

    /// Converts a YAML node to a value.
    pub(super) fn of_yaml(node: &Node) -> XacroValue {
        match &node.content {
            NodeValue::Null => XacroValue::None,
            NodeValue::Bool(b) => XacroValue::Bool(*b),
            NodeValue::Number(x) if x.fract() == 0.0 && x.abs() < 1e15 => XacroValue::Int(*x as i64),
            NodeValue::Number(x) => XacroValue::Number(*x),
            NodeValue::Text(text) => XacroValue::Text(text.clone()),
            NodeValue::List(items) => XacroValue::List(Rc::new(items.iter().map(XacroValue::of_yaml).collect())),
            NodeValue::Map(entries) => {
                let entries = entries.iter().map(|(key, node)| (key.text.clone(), XacroValue::of_yaml(node)));
                XacroValue::Map(Rc::new(entries.collect()))
            }
        }
    }
}

/// Converts numbers after `!degrees` and other unit tags in a YAML text to SI units.
pub(super) fn in_si(text: &str) -> String {
    const UNITS: [(&str, f64); 6] = [
        ("!degrees", std::f64::consts::PI / 180.0),
        ("!radians", 1.0),
        ("!meters", 1.0),
        ("!millimeters", 1e-3),
        ("!foot", 0.3048),
        ("!inches", 0.0254),
    ];
    let line = |line: &str| {
        for (unit, factor) in UNITS {
            let Some((before, behind)) = line.split_once(unit) else { continue };
            let number = behind.trim_start();
            let end = number.find(|c: char| c.is_whitespace() || matches!(c, ',' | '}' | ']')).unwrap_or(number.len());
            if let Ok(x) = number[..end].parse::<f64>() {
                return format!("{before}{:?}{}", factor * x, &number[end..]);
            }
        }
        line.to_string()
    };
    text.lines().map(|l| line(l) + "\n").collect()
}
