//! Values of properties and of expressions, as Python has them.

use std::collections::BTreeMap;
use std::rc::Rc;

use crate::format::node::{Content, Node};

/// Longest text, in bytes.
pub(super) const MAX_TEXT_BYTES: usize = 1 << 20;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    None,
    Bool(bool),
    Int(i64),
    Number(f64),
    Text(String),
    List(Rc<Vec<Value>>),
    /// By the texts of its keys.
    Map(Rc<BTreeMap<String, Value>>),
}

/// Where names and files come from.
pub(super) trait Names {
    fn value(&mut self, name: &str) -> Result<Value, String>;
    fn yaml(&mut self, file: &str) -> Result<Value, String>;
}

impl Value {
    /// The value of a text that stands alone: a number, a truth, or the text.
    pub(super) fn literal(text: &str) -> Value {
        if let Some(quoted) = text.strip_prefix('\'').and_then(|rest| rest.strip_suffix('\'')) {
            return Value::Text(quoted.into());
        }
        let trimmed = text.trim();
        // Underscores make no numbers here.
        let number =
            || trimmed.parse().ok().filter(|_| trimmed.bytes().any(|b| b.is_ascii_digit()) && !text.contains('_'));
        match trimmed {
            "true" | "True" => Value::Bool(true),
            "false" | "False" => Value::Bool(false),
            _ => match trimmed.parse().ok().filter(|_| !text.contains('_')) {
                Some(whole) => Value::Int(whole),
                None => number().map_or_else(|| Value::Text(text.into()), Value::Number),
            },
        }
    }

    pub(super) fn number(&self) -> Option<f64> {
        match *self {
            Value::Bool(b) => Some(f64::from(u8::from(b))),
            Value::Int(i) => Some(i as f64),
            Value::Number(x) => Some(x),
            _ => None,
        }
    }

    /// Whether it counts as true in a condition of an expression.
    pub(super) fn holds(&self) -> bool {
        match self {
            Value::None => false,
            Value::Text(text) => !text.is_empty(),
            Value::List(items) => !items.is_empty(),
            Value::Map(entries) => !entries.is_empty(),
            other => other.number() != Some(0.0),
        }
    }

    /// As `value` of an `if` reads it; `None` where it is no truth.
    pub(super) fn truth(&self) -> Option<bool> {
        match self {
            Value::Text(text) => match text.trim() {
                "true" | "True" => Some(true),
                "false" | "False" => Some(false),
                other => other.parse::<i64>().ok().map(|i| i != 0),
            },
            other => other.number().map(|x| x != 0.0),
        }
    }

    pub(super) fn kind(&self) -> &'static str {
        match self {
            Value::None => "nothing",
            Value::Bool(_) => "a truth",
            Value::Int(_) | Value::Number(_) => "a number",
            Value::Text(_) => "a text",
            Value::List(_) => "a list",
            Value::Map(_) => "a map",
        }
    }

    /// As text within other text.
    pub(super) fn text(&self) -> String {
        match self {
            Value::None => "None".into(),
            Value::Bool(b) => if *b { "True" } else { "False" }.into(),
            Value::Int(i) => i.to_string(),
            Value::Number(x) => format!("{x:?}"),
            Value::Text(text) => text.clone(),
            Value::List(items) => format!("[{}]", items.iter().map(Value::text).collect::<Vec<_>>().join(", ")),
            Value::Map(_) => "{..}".into(),
        }
    }

    /// The element of a list, or the entry of a map.
    pub(super) fn entry(&self, key: &Value) -> Option<Value> {
        match (self, key) {
            (Value::List(items), Value::Int(i)) => {
                let at = if *i < 0 { items.len().checked_sub(i.unsigned_abs() as usize)? } else { *i as usize };
                items.get(at).cloned()
            }
            (Value::Map(entries), key) => entries.get(&key.text()).cloned(),
            _ => None,
        }
    }

    /// Of a YAML text.
    pub(super) fn of_yaml(node: &Node) -> Value {
        match &node.content {
            Content::Null => Value::None,
            Content::Bool(b) => Value::Bool(*b),
            Content::Number(x) if x.fract() == 0.0 && x.abs() < 1e15 => Value::Int(*x as i64),
            Content::Number(x) => Value::Number(*x),
            Content::Text(text) => Value::Text(text.clone()),
            Content::List(items) => Value::List(Rc::new(items.iter().map(Value::of_yaml).collect())),
            Content::Map(entries) => {
                let entries = entries.iter().map(|(key, node)| (key.text.clone(), Value::of_yaml(node)));
                Value::Map(Rc::new(entries.collect()))
            }
        }
    }
}

/// A YAML text with the numbers behind `!degrees` and the like in SI.
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
