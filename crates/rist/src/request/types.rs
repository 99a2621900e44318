//! Types that fields can have. Each is read from texts of a command line, and from a value of Python or JSON.
//!
//! A field is one option of a request (a struct with all options of a command).

use std::path::PathBuf;
use std::str::FromStr;

use serde_json::{Value, json};

use super::shape::{Flag, ValueShape};
use crate::error::Error;

/// A type that the field of a request can have.
pub trait FieldType: Sized {
    /// The form of the values of this type.
    fn shape() -> ValueShape;

    /// Parses the texts of a flag, in their order.
    ///
    /// Fails with the expected form if the texts are no values of this type.
    fn of_texts(texts: &[String]) -> Result<Self, Error>;

    /// Converts a value of Python or JSON; `None` if it does not have the form in [`ValueShape::expected`].
    ///
    /// Fails if the value has this form, but its content is invalid.
    fn of_value(value: &Value) -> Result<Option<Self>, Error>;

    /// Converts to a JSON value that `of_value` reads. The value `None` of an `Option` becomes null.
    fn to_value(&self) -> Value;

    /// The numbers in this value, which must all be in the field's range; empty for a type without numbers.
    fn numbers(&self) -> Vec<f64> {
        Vec::new()
    }
}

/// Accepts every text, because errors are found later, when the text is parsed.
pub(super) fn every_text(_: &str) -> Result<(), String> {
    Ok(())
}

/// Returns the last text, because a later flag replaces an earlier one.
pub(super) fn last(texts: &[String]) -> &str {
    texts.last().map_or("", String::as_str)
}

fn parses<T: FromStr<Err: ToString>>(text: &str) -> Result<(), String> {
    text.parse::<T>().map(drop).map_err(|e| e.to_string())
}

fn parsed<T: FromStr<Err: ToString>>(texts: &[String]) -> Result<T, Error> {
    last(texts).parse().map_err(|e: T::Err| Error::new(format_args!("`{}`: {}", last(texts), e.to_string())))
}

/// Implements `FieldType` for a type that serde supports. Arguments: the form of the values, a parser of texts and, for a type
/// with a range, a function that returns the numbers of a value.
macro_rules! plain_type {
    ($type:ty, $shape:expr, $of_texts:expr $(, |$x:ident| $numbers:expr)?) => {
        impl FieldType for $type {
            fn shape() -> ValueShape {
                $shape
            }

            fn of_texts(texts: &[String]) -> Result<$type, Error> {
                let read: fn(&[String]) -> Result<$type, Error> = $of_texts;
                read(texts)
            }

            fn of_value(value: &Value) -> Result<Option<$type>, Error> {
                Ok(serde_json::from_value(value.clone()).ok())
            }

            fn to_value(&self) -> Value {
                json!(self)
            }

            $(fn numbers(&self) -> Vec<f64> {
                let $x = *self;
                $numbers
            })?
        }
    };
}
pub(super) use plain_type;

/// The form of a type that exists in JSON, for example a boolean.
fn json_type(
    expected: &str,
    python: &str,
    name: &str,
    flag: Flag,
    check: fn(&str) -> Result<(), String>,
) -> ValueShape {
    ValueShape::plain(expected, python, json!({"type": name}), flag, check)
}

fn whole_number() -> ValueShape {
    let json = json!({"type": "integer", "minimum": 0});
    ValueShape::plain("a whole number", "int", json, Flag::Number, parses::<usize>)
}

fn list_of_texts() -> ValueShape {
    let json = json!({"type": "array", "items": {"type": "string"}});
    ValueShape::plain("a list of texts", "Sequence[str]", json, Flag::List, every_text)
}

fn list_of_paths() -> ValueShape {
    let (expected, python) = ("a list of paths".into(), "Sequence[Path]".into());
    ValueShape { expected, python, flag: Flag::Repeated, ..list_of_texts() }
}

plain_type!(usize, whole_number(), parsed, |x| vec![x as f64]);
plain_type!(u64, whole_number(), parsed, |x| vec![x as f64]);
plain_type!(f64, json_type("a number", "float", "number", Flag::Number, parses::<f64>), parsed, |x| vec![x]);
// The flag of a boolean has no value on the command line: if it is present, it means `true`.
plain_type!(bool, json_type("true or false", "bool", "boolean", Flag::Switch, every_text), |_| Ok(true));
plain_type!(String, json_type("a text", "str", "string", Flag::One, every_text), |texts| Ok(last(texts).into()));
plain_type!(PathBuf, json_type("a path", "Path", "string", Flag::One, every_text), |texts| Ok(last(texts).into()));
plain_type!(Vec<PathBuf>, list_of_paths(), |texts| Ok(texts.iter().map(PathBuf::from).collect()));
plain_type!(Vec<String>, list_of_texts(), |texts| Ok(texts.to_vec()));

impl<T: FieldType> FieldType for Option<T> {
    fn shape() -> ValueShape {
        let shape = T::shape();
        let json = json!({"anyOf": [shape.json, {"type": "null"}]});
        let python = format!("{} | None", shape.python.trim_end_matches(" | None"));
        ValueShape { python, json, ..shape }
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
