//! Reads and writes requests by the names of their fields. The macro `request!` generates the table of fields.
//!
//! A request is a struct with all options of a command; each field is one option. `given` lists the fields that differ from
//! their defaults.

use gate::suggestion::nearest;
use serde_json::Value;

use super::field::Field;
use super::types::FieldType;
use crate::error::Error;

/// A set of options whose fields can be read and set by name, from the program, Python or JSON.
pub trait Request: Default {
    /// The fields of the request, in the order of the help.
    fn fields() -> Vec<Field>;

    /// Sets the field `name` from texts of the command line; a list has one text per entry.
    ///
    /// Fails if the field does not exist, or if its type does not accept the texts.
    fn set_texts(&mut self, name: &str, texts: &[String]) -> Result<(), Error>;

    /// Sets the field `name` from a value of Python or JSON.
    ///
    /// Fails like [`Request::set_texts`], and if a number is out of the range of its field.
    fn set_value(&mut self, name: &str, value: &Value) -> Result<(), Error>;

    /// Names and values of the fields that differ from their defaults.
    fn given(&self) -> Vec<(&'static str, Value)>;

    /// Fails if a number is out of the range of its field.
    fn check(&self) -> Result<(), Error>;
}

/// Makes a request from pairs of field name and value; other fields have their defaults.
///
/// Fails if a field does not exist, or does not accept its value.
pub fn of_values<'a, R: Request>(values: impl IntoIterator<Item = (&'a str, &'a Value)>) -> Result<R, Error> {
    let mut request = R::default();
    values.into_iter().try_for_each(|(name, value)| request.set_value(name, value))?;
    Ok(request)
}

/// The error for an unknown option `name`, with the most similar option and a list of all.
pub fn unknown<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Error {
    let known: Vec<&str> = known.into_iter().collect();
    let meant =
        nearest(name, known.iter().copied()).map_or(String::new(), |known| format!(" (did you mean [{known}]?)"));
    Error::new(format_args!("there is no option `{name}`{meant}; there are {}", known.join(", ")))
}

/// Whether the request `R`, which is a part of another request, has the field `name`.
pub fn has<R: Request>(name: &str) -> bool {
    R::fields().iter().any(|field| field.name == name)
}

/// Fails if a number of a field is out of its range.
pub fn in_range<T: FieldType>(field: &Field, value: &T) -> Result<(), Error> {
    match value.numbers().into_iter().find(|x| !field.range.holds(*x)) {
        Some(x) => Err(field.range.refusal(field.name, x)),
        None => Ok(()),
    }
}

/// Converts a value of Python or JSON to the type of the field.
///
/// Fails if the type does not accept the value, or if it is out of range.
pub fn value_of<T: FieldType>(field: &Field, value: &Value) -> Result<T, Error> {
    let found = T::of_value(value).map_err(|e| e.about(field.name))?;
    let found = found
        .ok_or_else(|| Error::new(format_args!("[{}] is {value}; expected is {}", field.name, field.shape.expected)))?;
    in_range(field, &found)?;
    Ok(found)
}

/// Generates a request: a struct, its default, and the table of its fields. Wings (optional packages) use it too.
#[macro_export]
macro_rules! request {
    (
        $(#[doc = $about:literal])*
        pub struct $name:ident {
            $(
                $(#[doc = $doc:literal])*
                $field:ident: $type:ty = $default:expr $(, $key:ident($($value:expr),*))*;
            )*
            $(.. $(#[doc = $part_doc:literal])* $part:ident: $part_type:ty;)?
        }
    ) => {
        $(#[doc = $about])*
        #[derive(Clone, Debug)]
        #[allow(rustdoc::broken_intra_doc_links)] // docs contain fields in brackets
        pub struct $name {
            $($(#[doc = $doc])* pub $field: $type,)*
            $($(#[doc = $part_doc])* pub $part: $part_type,)?
        }

        impl Default for $name {
            fn default() -> $name {
                $name { $($field: $default,)* $($part: <$part_type>::default(),)? }
            }
        }

        impl $crate::request::Request for $name {
            fn fields() -> Vec<$crate::request::Field> {
                let customary = $name::default();
                let own = vec![$(
                    $crate::request::Field::new(stringify!($field), &[$($doc),*], &customary.$field)
                        $(.$key($($value),*))*,
                )*];
                [own, $(<$part_type as $crate::request::Request>::fields(),)?].concat()
            }

            fn set_texts(&mut self, name: &str, texts: &[String]) -> Result<(), $crate::Error> {
                match name {
                    $(stringify!($field) => {
                        self.$field = $crate::request::FieldType::of_texts(texts).map_err(|e| e.about(name))?;
                    })*
                    $(_ if $crate::request::has::<$part_type>(name) => self.$part.set_texts(name, texts)?,)?
                    _ => return Err($crate::request::unknown(name, Self::fields().iter().map(|field| field.name))),
                }
                Ok(())
            }

            fn set_value(&mut self, name: &str, value: &serde_json::Value) -> Result<(), $crate::Error> {
                let fields = Self::fields();
                let Some(field) = fields.iter().find(|field| field.name == name) else {
                    return Err($crate::request::unknown(name, fields.iter().map(|field| field.name)));
                };
                match name {
                    $(stringify!($field) => self.$field = $crate::request::value_of(field, value)?,)*
                    $(_ if $crate::request::has::<$part_type>(name) => self.$part.set_value(name, value)?,)?
                    _ => {}
                }
                Ok(())
            }

            fn given(&self) -> Vec<(&'static str, serde_json::Value)> {
                let customary = $name::default();
                let all = [$((
                    stringify!($field),
                    $crate::request::FieldType::to_value(&self.$field),
                    $crate::request::FieldType::to_value(&customary.$field),
                )),*];
                let changed = all.into_iter().filter(|(_, value, default)| value != default);
                let own: Vec<(&'static str, serde_json::Value)> =
                    changed.map(|(name, value, _)| (name, value)).collect();
                [own, $(self.$part.given(),)?].concat()
            }

            fn check(&self) -> Result<(), $crate::Error> {
                let fields = Self::fields();
                let mut fields = fields.iter();
                $($crate::request::in_range(fields.next().expect("a field of the table"), &self.$field)?;)*
                $(self.$part.check()?;)?
                Ok(())
            }
        }
    };
}
