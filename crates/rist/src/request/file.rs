//! Fields whose value is a file. A command line gives a path; Python gives a path or the content.
//!
//! A field is one option of a request (a struct with all options of a command).

use std::path::{Path, PathBuf};

use experiments::excitation::limits::LimitsFile;
use identification::estimate::artefact::Estimate;
use identification::estimate::options::Options;
use linear_model::known_load::KnownLoad;
use serde_json::{Value, json};

use super::shape::{Flag, ValueShape};
use super::types::{FieldType, every_text, last};
use crate::error::Error;

/// A type that is read from a YAML file.
pub trait FileType: Sized {
    /// Parses a text; `file` is named in messages.
    fn parse(file: &str, text: &str) -> Result<Self, Error>;

    /// Reads a file.
    fn read(path: &Path) -> Result<Self, Error> {
        Self::parse(&path.display().to_string(), &robot::format::read_text(path)?)
    }
}

/// The form of a field whose value is a file. `what`: the name that messages use for the content of the file.
pub fn shape(what: &str) -> ValueShape {
    let json = json!({"anyOf": [{"type": "string"}, {"type": "object"}, {"type": "null"}]});
    let expected = format!("the path of {what}, or its content");
    let shape = ValueShape::plain(&expected, "Path | Mapping[str, Any] | None", json, Flag::One, every_text);
    ValueShape { is_file: true, ..shape }
}

/// Reads a value that is either the path of a file or the content itself. A text with a colon or a line break is content in YAML,
/// unless a file with this path exists.
pub fn of_value<T: FileType>(name: &str, value: &Value) -> Result<Option<T>, Error> {
    match value {
        // JSON is valid YAML, so the YAML parser reads it.
        Value::Object(_) => T::parse(name, &value.to_string()).map(Some),
        Value::String(text) if text.contains([':', '\n']) && !Path::new(text).exists() => {
            T::parse(name, text).map(Some)
        }
        Value::String(path) => T::read(Path::new(path)).map(Some),
        _ => Ok(None),
    }
}

/// Reads the file at the last path of `texts`: if a flag is repeated, only its last value counts.
pub fn of_texts<T: FileType>(texts: &[String]) -> Result<T, Error> {
    T::read(Path::new(last(texts)))
}

/// Makes a type usable for a field that is a file. Arguments: the type, the name of its content in messages, and a function
/// that parses it from a file's name and text.
#[macro_export]
macro_rules! file_type {
    ($type:ty, $what:literal, $parse:expr) => {
        impl $crate::request::file::FileType for $type {
            fn parse(file: &str, text: &str) -> Result<$type, $crate::Error> {
                let parse: fn(&str, &str) -> Result<$type, logs::Error> = $parse;
                Ok(parse(file, text)?)
            }
        }

        impl $crate::request::FieldType for $type {
            fn shape() -> $crate::request::ValueShape {
                $crate::request::file::shape($what)
            }

            fn of_texts(texts: &[String]) -> Result<$type, $crate::Error> {
                $crate::request::file::of_texts(texts)
            }

            fn of_value(value: &serde_json::Value) -> Result<Option<$type>, $crate::Error> {
                $crate::request::file::of_value($what, value)
            }

            fn to_value(&self) -> serde_json::Value {
                serde_json::Value::Null
            }
        }
    };
}

file_type!(LimitsFile, "limits", LimitsFile::from_yaml);
file_type!(Options, "options", Options::parse);
file_type!(Estimate, "an estimate", Estimate::from_yaml);

/// A known load, and the path of its file.
impl FieldType for (PathBuf, KnownLoad) {
    fn shape() -> ValueShape {
        shape("a load")
    }

    fn of_texts(texts: &[String]) -> Result<(PathBuf, KnownLoad), Error> {
        Ok((last(texts).into(), KnownLoad::read(Path::new(last(texts)))?))
    }

    fn of_value(value: &Value) -> Result<Option<(PathBuf, KnownLoad)>, Error> {
        let file = PathBuf::from(value.as_str().unwrap_or("load"));
        Ok(of_value("load", value)?.map(|load| (file, load)))
    }

    fn to_value(&self) -> Value {
        Value::Null
    }
}

impl FileType for KnownLoad {
    fn parse(file: &str, text: &str) -> Result<KnownLoad, Error> {
        Ok(KnownLoad::from_yaml(file, text)?)
    }
}
