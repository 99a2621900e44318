//! The types of fields: how each is read from texts of a command line and from a value.

use std::path::PathBuf;
use std::str::FromStr;

use serde_json::{Value, json};

use super::shape::{Flag, Shape};
use crate::error::Error;

/// A type that a field can have.
pub trait FieldType: Sized {
    /// How its values are written.
    fn shape() -> Shape;

    /// Of the texts of a flag, in their order.
    ///
    /// Fails, saying what is expected, where they are none.
    fn of_texts(texts: &[String]) -> Result<Self, Error>;

    /// Of a value; `None` where it is not as [`Shape::expected`] says.
    ///
    /// Fails where it is, and cannot be.
    fn of_value(value: &Value) -> Result<Option<Self>, Error>;

    /// As a value: `of_value` finds it again; null where nothing is asked for.
    fn to_value(&self) -> Value;

    /// The numbers that have to lie in the range of the field.
    fn numbers(&self) -> Vec<f64> {
        Vec::new()
    }
}

/// A flag takes every text; what is wrong with one is found later.
pub(super) fn every_text(_: &str) -> Result<(), String> {
    Ok(())
}

/// The last text, as a later flag wins over an earlier one.
pub(super) fn last(texts: &[String]) -> &str {
    texts.last().map_or("", String::as_str)
}

fn parses<T: FromStr<Err: ToString>>(text: &str) -> Result<(), String> {
    text.parse::<T>().map(drop).map_err(|e| e.to_string())
}

fn parsed<T: FromStr<Err: ToString>>(texts: &[String]) -> Result<T, Error> {
    last(texts).parse().map_err(|e: T::Err| Error::new(format_args!("`{}`: {}", last(texts), e.to_string())))
}

impl FieldType for usize {
    fn shape() -> Shape {
        let json = json!({"type": "integer", "minimum": 0});
        Shape::plain("a whole number", "int", json, Flag::Number, parses::<usize>)
    }

    fn of_texts(texts: &[String]) -> Result<usize, Error> {
        parsed(texts)
    }

    fn of_value(value: &Value) -> Result<Option<usize>, Error> {
        Ok(value.as_u64().and_then(|x| usize::try_from(x).ok()))
    }

    fn to_value(&self) -> Value {
        json!(self)
    }

    fn numbers(&self) -> Vec<f64> {
        vec![*self as f64]
    }
}

impl FieldType for u64 {
    fn shape() -> Shape {
        usize::shape()
    }

    fn of_texts(texts: &[String]) -> Result<u64, Error> {
        parsed(texts)
    }

    fn of_value(value: &Value) -> Result<Option<u64>, Error> {
        Ok(value.as_u64())
    }

    fn to_value(&self) -> Value {
        json!(self)
    }

    fn numbers(&self) -> Vec<f64> {
        vec![*self as f64]
    }
}

impl FieldType for f64 {
    fn shape() -> Shape {
        Shape::plain("a number", "float", json!({"type": "number"}), Flag::Number, parses::<f64>)
    }

    fn of_texts(texts: &[String]) -> Result<f64, Error> {
        parsed(texts)
    }

    fn of_value(value: &Value) -> Result<Option<f64>, Error> {
        Ok(value.as_f64())
    }

    fn to_value(&self) -> Value {
        json!(self)
    }

    fn numbers(&self) -> Vec<f64> {
        vec![*self]
    }
}

impl FieldType for bool {
    fn shape() -> Shape {
        Shape::plain("true or false", "bool", json!({"type": "boolean"}), Flag::Switch, every_text)
    }

    /// A flag that is there.
    fn of_texts(_: &[String]) -> Result<bool, Error> {
        Ok(true)
    }

    fn of_value(value: &Value) -> Result<Option<bool>, Error> {
        Ok(value.as_bool())
    }

    fn to_value(&self) -> Value {
        json!(self)
    }
}

impl FieldType for String {
    fn shape() -> Shape {
        Shape::plain("a text", "str", json!({"type": "string"}), Flag::One, every_text)
    }

    fn of_texts(texts: &[String]) -> Result<String, Error> {
        Ok(last(texts).into())
    }

    fn of_value(value: &Value) -> Result<Option<String>, Error> {
        Ok(value.as_str().map(String::from))
    }

    fn to_value(&self) -> Value {
        json!(self)
    }
}

impl FieldType for PathBuf {
    fn shape() -> Shape {
        Shape { expected: "a path".into(), python: "Path".into(), ..String::shape() }
    }

    fn of_texts(texts: &[String]) -> Result<PathBuf, Error> {
        Ok(last(texts).into())
    }

    fn of_value(value: &Value) -> Result<Option<PathBuf>, Error> {
        Ok(value.as_str().map(PathBuf::from))
    }

    fn to_value(&self) -> Value {
        json!(self)
    }
}

impl FieldType for Vec<PathBuf> {
    fn shape() -> Shape {
        let shape = Vec::<String>::shape();
        Shape { expected: "a list of paths".into(), python: "Sequence[Path]".into(), flag: Flag::Repeated, ..shape }
    }

    fn of_texts(texts: &[String]) -> Result<Vec<PathBuf>, Error> {
        Ok(texts.iter().map(PathBuf::from).collect())
    }

    fn of_value(value: &Value) -> Result<Option<Vec<PathBuf>>, Error> {
        let path = |x: &Value| x.as_str().map(PathBuf::from);
        Ok(value.as_array().and_then(|list| list.iter().map(path).collect()))
    }

    fn to_value(&self) -> Value {
        json!(self)
    }
}

impl FieldType for Vec<String> {
    fn shape() -> Shape {
        let json = json!({"type": "array", "items": {"type": "string"}});
        Shape::plain("a list of texts", "Sequence[str]", json, Flag::List, every_text)
    }

    fn of_texts(texts: &[String]) -> Result<Vec<String>, Error> {
        Ok(texts.to_vec())
    }

    fn of_value(value: &Value) -> Result<Option<Vec<String>>, Error> {
        let text = |x: &Value| x.as_str().map(String::from);
        Ok(value.as_array().and_then(|list| list.iter().map(text).collect()))
    }

    fn to_value(&self) -> Value {
        json!(self)
    }
}

impl<T: FieldType> FieldType for Option<T> {
    fn shape() -> Shape {
        let shape = T::shape();
        let json = json!({"anyOf": [shape.json, {"type": "null"}]});
        let python = format!("{} | None", shape.python.trim_end_matches(" | None"));
        Shape { python, json, ..shape }
    }

    fn of_texts(texts: &[String]) -> Result<Option<T>, Error> {
        T::of_texts(texts).map(Some)
    }

    fn of_value(value: &Value) -> Result<Option<Option<T>>, Error> {
        if value.is_null() {
            return Ok(Some(None));
        }
        Ok(T::of_value(value)?.map(Some))
    }

    fn to_value(&self) -> Value {
        self.as_ref().map_or(Value::Null, T::to_value)
    }

    fn numbers(&self) -> Vec<f64> {
        self.iter().flat_map(T::numbers).collect()
    }
}
