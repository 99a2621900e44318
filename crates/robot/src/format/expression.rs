//! Reads the values of a description: numbers and expressions. Each error gives the place in the file.

use super::node::{DescriptionFile, Node, NodeValue};
use crate::error::Error;
use crate::value::{CoordinateId, Name, Symbol, SymbolId, Value, parse};
use gate::suggestion::did_you_mean;

/// Largest absolute value of a number, in SI units. In a sum with a larger number, the other terms would be lost by rounding.
pub(in crate::format) const LARGEST_NUMBER: f64 = 1e15;

/// Largest length of an expression. It also limits the depth of the recursion that evaluates an expression.
const MAX_EXPRESSION_CHARACTERS: usize = 1000;
/// Largest number of operations of a value with its symbols expanded. Without this limit, a short file could need almost
/// endless time: in a chain of symbols, each may contain the previous symbol twice.
const MAX_VALUE_OPERATIONS: usize = 4000;

/// The message if a value is given for a symbol that the description does not have.
pub(in crate::format) fn no_symbol(name: &str, known: &[&str]) -> String {
    let known = if known.is_empty() { "it has none".into() } else { format!("there are {}", known.join(", ")) };
    format!("the description has no symbol {name} to give a value to; {known}")
}

/// The names that an expression may use: symbols and coordinates.
#[derive(Clone, Debug, Default)]
pub(super) struct KnownNames {
    pub symbols: Vec<Symbol>,
    /// For each symbol: the number of operations of its value, with all symbols in this value expanded.
    costs: Vec<usize>,
    pub coordinates: Vec<String>,
}

impl KnownNames {
    /// Adds a symbol. Its value may contain the symbols that were added before.
    pub(super) fn define(&mut self, source: DescriptionFile, name: String, node: &Node) -> Result<(), Error> {
        let value = self.constant(source, &format!("the symbol `{name}`"), node)?;
        self.costs.push(self.cost(&value));
        self.symbols.push(Symbol { name, value, generic: false });
        Ok(())
    }

    /// Adds a symbol that has no value in the file; `value` is used until a value is set. Does nothing if the symbol exists
    /// already.
    pub(super) fn define_generic(&mut self, name: &str, value: f64) {
        if !self.symbols.iter().any(|s| s.name == name) {
            self.costs.push(1);
            self.symbols.push(Symbol { name: name.into(), value: Value::Number(value), generic: true });
        }
    }

    /// Replaces the values of symbols. Fails if a symbol does not exist, or if a value exceeds [`LARGEST_NUMBER`].
    pub(super) fn set_values(&mut self, source: DescriptionFile, values: &[(String, f64)]) -> Result<(), Error> {
        for (name, value) in values {
            let Some(symbol) = self.symbols.iter_mut().find(|s| s.name == *name) else {
                let known: Vec<&str> = self.symbols.iter().map(|s| s.name.as_str()).collect();
                return Err(source.whole(no_symbol(name, &known)));
            };
            if value.is_nan() || value.abs() > LARGEST_NUMBER {
                return Err(source.whole(format!(
                    "the value of {name} is {value}: no robot has a number beyond {LARGEST_NUMBER:e}"
                )));
            }
            (symbol.value, symbol.generic) = (Value::Number(*value), false);
        }
        Ok(())
    }

    /// Reads a value that must not contain coordinates. Fails if the value is not finite.
    pub(super) fn constant(&self, source: DescriptionFile, what: &str, node: &Node) -> Result<Value, Error> {
        let value = self.value(source, what, node, &[])?;
        self.finite(source, what, node, value.number(&self.symbols))?;
        Ok(value)
    }

    /// Reads a value that must not contain coordinates, and converts it to a number.
    pub(super) fn number(&self, source: DescriptionFile, what: &str, node: &Node) -> Result<f64, Error> {
        Ok(self.constant(source, what, node)?.number(&self.symbols))
    }

    /// Reads a value that may contain coordinates.
    pub(super) fn variable(&self, source: DescriptionFile, what: &str, node: &Node) -> Result<Value, Error> {
        self.value(source, what, node, &self.coordinates)
    }

    pub(super) fn finite(&self, source: DescriptionFile, what: &str, node: &Node, x: f64) -> Result<(), Error> {
        if x.abs() <= LARGEST_NUMBER {
            return Ok(());
        }
        if x.is_finite() {
            return Err(source.at(node, format!("{what} is {x:e}: no robot has a number beyond {LARGEST_NUMBER:e}")));
        }
        let found = match node.content {
            NodeValue::Number(x) => x.to_string(),
            _ => format!("{} gives {x}", node.kind()),
        };
        Err(source.at(node, format!("{what} is not a finite number: {found}")))
    }

    fn value(&self, source: DescriptionFile, what: &str, node: &Node, coordinates: &[String]) -> Result<Value, Error> {
        let find = |word: &str| self.find(word, coordinates);
        let text = match &node.content {
            NodeValue::Number(x) => {
                self.finite(source, what, node, *x)?;
                return Ok(Value::Number(*x));
            }
            NodeValue::Text(text) => text,
            _ => {
                let message = format!("{what} must be a number or an expression, found {}", node.kind());
                return Err(source.at(node, message));
            }
        };
        if text.len() > MAX_EXPRESSION_CHARACTERS {
            return Err(
                source.at(node, format!("{what} is an expression of more than {MAX_EXPRESSION_CHARACTERS} characters"))
            );
        }
        // The error suggests the known name that is most similar. If the word is a coordinate, it says where coordinates are
        // allowed.
        let value = parse(text, &find).map_err(|e| {
            let refusal = match identifiers(text).find(|w| find(w).is_none()) {
                Some(w) if self.coordinates.iter().any(|c| c == w) => format!(
                    "`{w}` is a coordinate, and coordinates move the theta of a revolute joint or the r of a prismatic \
                     one, nothing else"
                ),
                Some(w) => {
                    let symbols = self.symbols.iter().map(|s| s.name.as_str());
                    e + &did_you_mean(w, symbols.chain(coordinates.iter().map(String::as_str)))
                }
                None => e,
            };
            source.at(node, format!("{what}: {refusal}"))
        })?;
        // Symbols may be expressions, so a short text can lead to a long computation.
        if self.cost(&value) > MAX_VALUE_OPERATIONS {
            let message =
                format!("{what} takes more than {MAX_VALUE_OPERATIONS} operations with its symbols written out");
            return Err(source.at(node, message));
        }
        Ok(value)
    }

    fn find(&self, word: &str, coordinates: &[String]) -> Option<Name> {
        let symbol = self.symbols.iter().position(|s| s.name == word).map(|k| Name::Symbol(SymbolId(k)));
        symbol.or_else(|| coordinates.iter().position(|c| c == word).map(|k| Name::Coordinate(CoordinateId(k))))
    }

    fn cost(&self, value: &Value) -> usize {
        let of_symbol = if let Value::Symbol(s) = value { self.costs[s.0] } else { 0 };
        1 + of_symbol + value.operands().map(|operand| self.cost(operand)).sum::<usize>()
    }
}

/// The names in an expression, except functions and pi.
pub(super) fn identifiers(text: &str) -> impl Iterator<Item = &str> {
    let words = text.split(|c: char| !(c.is_alphanumeric() || c == '_'));
    words.filter(|w| is_name(w))
}

/// Whether a word can be the name of a symbol or a coordinate.
pub(super) fn is_name(word: &str) -> bool {
    let starts = word.chars().next().is_some_and(|c| c.is_alphabetic() || c == '_');
    let continues = word.chars().all(|c| c.is_alphanumeric() || c == '_');
    starts && continues && !matches!(word, "pi" | "Pi" | "sqrt" | "sin" | "cos" | "atan2")
}
