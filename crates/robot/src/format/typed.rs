//! Reads a YAML text as a value of a given type, by serde.
//!
//! The reader of the YAML library would be compiled again for each type. This reader traverses the tree of [`node`](super::node)
//! instead, so a type needs little compiled code, and each error has its line and column. Functions that pass a serde visitor on
//! are marked `inline(never)`. Otherwise the compiler would copy the whole reader of a type into each serde function that calls
//! it; these copies would take a quarter of the compile time of `experiments`.

use std::fmt;

use serde::Deserializer;
use serde::de::value::StrDeserializer;
use serde::de::{
    self, DeserializeOwned, DeserializeSeed, EnumAccess, Expected, MapAccess, SeqAccess, VariantAccess, Visitor,
};

use super::node::{DescriptionFile, Key, Node, NodeValue};

/// Reads a YAML text as a value of type `T`.
///
/// A number that is not finite is refused here, except where `T` requests an f64: then `T` gets the number, and can name the
/// quantity in its own error. Fails, with line and column, at an unexpected value or a duplicate key, and if anchors repeat too
/// much.
pub fn read_as<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    let tree =
        DescriptionFile { file: "" }.parse(text).map_err(|e| said((e.place.line, e.place.column), &e.message))?;
    T::deserialize(TypedValue { node: &tree, text }).map_err(|e| said(e.place.unwrap_or_default(), &e.message))
}

fn said(place: (usize, usize), message: &str) -> String {
    match place {
        (0, _) => message.to_string(),
        (line, column) => format!("line {line} column {column}: {message}"),
    }
}

/// The error for an unexpected value, with the place of the innermost value that has a place.
#[derive(Debug)]
struct Unexpected {
    place: Option<(usize, usize)>,
    message: String,
}

impl Unexpected {
    fn at(mut self, line: usize, column: usize) -> Unexpected {
        self.place = self.place.or(Some((line, column)));
        self
    }
}

impl fmt::Display for Unexpected {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Unexpected {}

impl de::Error for Unexpected {
    fn custom<T: fmt::Display>(message: T) -> Unexpected {
        Unexpected { place: None, message: message.to_string() }
    }
}

/// A value of the tree, together with the YAML text. The text shows how scalars are spelled.
#[derive(Clone, Copy)]
struct TypedValue<'a> {
    node: &'a Node,
    text: &'a str,
}

/// 2^53: from this number on, f64 cannot represent every integer.
const MAX_WHOLE: f64 = 9_007_199_254_740_992.0;

impl<'a> TypedValue<'a> {
    /// A scalar as the text spells it, because a link may have the name `01`, `1e3` or `true`. An alias (`*name`) does not show
    /// the spelling, so the value is formatted.
    fn written(self) -> String {
        let line = self.text.lines().nth(self.node.line.saturating_sub(1)).unwrap_or("");
        let from = line.char_indices().nth(self.node.column.saturating_sub(1)).map_or("", |(at, _)| &line[at..]);
        let scalar = from.split([',', ']', '}']).next().unwrap_or("").split(" #").next().unwrap_or("").trim();
        match &self.node.content {
            NodeValue::Number(x) if scalar.starts_with('*') => x.to_string(),
            NodeValue::Bool(b) if scalar.starts_with('*') => b.to_string(),
            _ => scalar.to_string(),
        }
    }

    fn number<V: Visitor<'a>>(self, x: f64, visitor: V) -> Result<V::Value, Unexpected> {
        if !x.is_finite() {
            return Err(de::Error::custom(format_args!("`{}` is no finite number", self.written())));
        }
        let is_whole = x.fract() == 0.0 && x.abs() < MAX_WHOLE && (x != 0.0 || x.is_sign_positive());
        match is_whole {
            true if x < 0.0 => visitor.visit_i64(x as i64),
            true => visitor.visit_u64(x as u64),
            false => visitor.visit_f64(x),
        }
    }

    #[inline(never)]
    fn visited<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Unexpected> {
        match &self.node.content {
            NodeValue::Null => visitor.visit_unit(),
            NodeValue::Bool(b) => visitor.visit_bool(*b),
            NodeValue::Number(x) => self.number(*x, visitor),
            NodeValue::Text(text) => visitor.visit_borrowed_str(text),
            NodeValue::List(items) => visitor.visit_seq(Items { items: items.iter(), text: self.text }),
            NodeValue::Map(entries) => {
                visitor.visit_map(Entries { entries: entries.iter(), value: self.node, text: self.text })
            }
        }
    }

    /// Passes the value as a number to the visitor. A number in quotes is also accepted.
    #[inline(never)]
    fn asked_number<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Unexpected> {
        let quoted = match &self.node.content {
            NodeValue::Text(text) => text.trim().parse::<f64>().ok(),
            _ => None,
        };
        self.here(match quoted {
            Some(x) => self.number(x, visitor),
            None => self.visited(visitor),
        })
    }

    /// Deserializes the value. If the type reports an error without a place, the error gets the place of the value.
    fn seeded<T: DeserializeSeed<'a>>(self, seed: T) -> Result<T::Value, Unexpected> {
        self.here(seed.deserialize(self))
    }

    /// The error that the value has a different kind than `expected`.
    fn unexpected(self, expected: &dyn Expected) -> Unexpected {
        let found = match &self.node.content {
            NodeValue::Null => de::Unexpected::Unit,
            NodeValue::Bool(b) => de::Unexpected::Bool(*b),
            NodeValue::Number(x) if x.fract() == 0.0 && x.abs() < MAX_WHOLE => de::Unexpected::Signed(*x as i64),
            NodeValue::Number(x) => de::Unexpected::Float(*x),
            NodeValue::Text(text) => de::Unexpected::Str(text),
            NodeValue::List(_) => de::Unexpected::Seq,
            NodeValue::Map(_) => de::Unexpected::Map,
        };
        let error: Unexpected = de::Error::invalid_type(found, expected);
        error.at(self.node.line, self.node.column)
    }

    fn here<T>(self, result: Result<T, Unexpected>) -> Result<T, Unexpected> {
        result.map_err(|e| e.at(self.node.line, self.node.column))
    }
}

macro_rules! asked_numbers {
    ($($name:ident)*) => {
        $(fn $name<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unexpected> {
            self.asked_number(visitor)
        })*
    };
}

impl<'de> Deserializer<'de> for TypedValue<'de> {
    type Error = Unexpected;

    #[inline(never)]
    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unexpected> {
        self.here(self.visited(visitor))
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unexpected> {
        match self.node.content {
            NodeValue::Number(x) => self.here(visitor.visit_f64(x)),
            _ => self.asked_number(visitor),
        }
    }

    asked_numbers! { deserialize_i8 deserialize_i16 deserialize_i32 deserialize_i64 deserialize_u8 deserialize_u16 deserialize_u32 deserialize_u64 deserialize_f32 }

    /// Reads a boolean. The words of YAML 1.1 (yes, on, ..) are accepted too.
    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unexpected> {
        let word = match &self.node.content {
            NodeValue::Text(text) => text.to_lowercase(),
            _ => String::new(),
        };
        match word.as_str() {
            "yes" | "on" | "y" | "true" => self.here(visitor.visit_bool(true)),
            "no" | "off" | "n" | "false" => self.here(visitor.visit_bool(false)),
            _ => self.deserialize_any(visitor),
        }
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unexpected> {
        match self.node.content {
            NodeValue::Number(_) | NodeValue::Bool(_) => self.here(visitor.visit_string(self.written())),
            _ => self.deserialize_any(visitor),
        }
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unexpected> {
        self.deserialize_str(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unexpected> {
        match self.node.content {
            NodeValue::Null => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    /// Reads a list. A key without a value counts as an empty list.
    #[inline(never)]
    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unexpected> {
        let items: &[Node] = match &self.node.content {
            NodeValue::Null => &[],
            NodeValue::List(items) => items,
            _ => return Err(self.unexpected(&visitor)),
        };
        self.here(visitor.visit_seq(Items { items: items.iter(), text: self.text }))
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, _len: usize, visitor: V) -> Result<V::Value, Unexpected> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _len: usize,
        visitor: V,
    ) -> Result<V::Value, Unexpected> {
        self.deserialize_seq(visitor)
    }

    /// Reads a map. A key without a value counts as an empty map, because all its entries may be commented out.
    #[inline(never)]
    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unexpected> {
        let entries: &[(Key, Node)] = match &self.node.content {
            NodeValue::Null => &[],
            NodeValue::Map(entries) => entries,
            _ => return Err(self.unexpected(&visitor)),
        };
        self.here(visitor.visit_map(Entries { entries: entries.iter(), value: self.node, text: self.text }))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unexpected> {
        self.deserialize_map(visitor)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Unexpected> {
        self.here(visitor.visit_newtype_struct(self))
    }

    #[inline(never)]
    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unexpected> {
        let variant = match &self.node.content {
            NodeValue::Map(entries) => match entries.as_slice() {
                [(key, value)] => Variant { key, value: Some(TypedValue { node: value, text: self.text }) },
                _ => return self.here(Err(de::Error::custom("one word, or one key with its value, is expected"))),
            },
            NodeValue::Text(text) => {
                let key = Key { line: self.node.line, column: self.node.column, text: text.clone() };
                return self.here(visitor.visit_enum(Variant { key: &key, value: None }));
            }
            _ => return self.deserialize_any(visitor),
        };
        self.here(visitor.visit_enum(variant))
    }

    serde::forward_to_deserialize_any! {
        i128 u128 char bytes byte_buf unit unit_struct identifier ignored_any
    }
}

struct Items<'a> {
    items: std::slice::Iter<'a, Node>,
    text: &'a str,
}

impl<'a> SeqAccess<'a> for Items<'a> {
    type Error = Unexpected;

    fn next_element_seed<T: DeserializeSeed<'a>>(&mut self, seed: T) -> Result<Option<T::Value>, Unexpected> {
        self.items.next().map(|node| TypedValue { node, text: self.text }.seeded(seed)).transpose()
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.items.len())
    }
}

struct Entries<'a> {
    entries: std::slice::Iter<'a, (Key, Node)>,
    /// The value that belongs to the last key that was read.
    value: &'a Node,
    text: &'a str,
}

impl<'a> MapAccess<'a> for Entries<'a> {
    type Error = Unexpected;

    fn next_key_seed<K: DeserializeSeed<'a>>(&mut self, seed: K) -> Result<Option<K::Value>, Unexpected> {
        let Some((key, value)) = self.entries.next() else { return Ok(None) };
        self.value = value;
        named(key, seed).map(Some)
    }

    fn next_value_seed<T: DeserializeSeed<'a>>(&mut self, seed: T) -> Result<T::Value, Unexpected> {
        TypedValue { node: self.value, text: self.text }.seeded(seed)
    }
}

/// Deserializes a key from its text.
fn named<'a, K: DeserializeSeed<'a>>(key: &Key, seed: K) -> Result<K::Value, Unexpected> {
    seed.deserialize(StrDeserializer::new(&key.text)).map_err(|e: Unexpected| e.at(key.line, key.column))
}

/// A variant of an enum: its name, and its value if it has one.
struct Variant<'k, 'a> {
    key: &'k Key,
    value: Option<TypedValue<'a>>,
}

impl<'a> EnumAccess<'a> for Variant<'_, 'a> {
    type Error = Unexpected;
    type Variant = ValueAccess<'a>;

    fn variant_seed<K: DeserializeSeed<'a>>(self, seed: K) -> Result<(K::Value, ValueAccess<'a>), Unexpected> {
        Ok((named(self.key, seed)?, ValueAccess(self.value)))
    }
}

struct ValueAccess<'a>(Option<TypedValue<'a>>);

impl<'a> ValueAccess<'a> {
    fn value(self) -> Result<TypedValue<'a>, Unexpected> {
        self.0.ok_or_else(|| de::Error::custom("a value is expected behind this word"))
    }
}

impl<'a> VariantAccess<'a> for ValueAccess<'a> {
    type Error = Unexpected;

    fn unit_variant(self) -> Result<(), Unexpected> {
        match self.0 {
            None => Ok(()),
            Some(value) => value.here(Err(de::Error::custom("no value is expected behind this word"))),
        }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'a>>(self, seed: T) -> Result<T::Value, Unexpected> {
        self.value()?.seeded(seed)
    }

    fn tuple_variant<V: Visitor<'a>>(self, _len: usize, visitor: V) -> Result<V::Value, Unexpected> {
        self.value()?.deserialize_seq(visitor)
    }

    fn struct_variant<V: Visitor<'a>>(
        self,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unexpected> {
        self.value()?.deserialize_map(visitor)
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(rename_all = "lowercase")]
    enum Form {
        Plain,
        Pair(f64, f64),
        Named { height: f64 },
        One(usize),
    }

    /// A type for this test: its own deserializer checks the value.
    #[derive(Debug, PartialEq)]
    struct Small(f64);

    impl<'de> Deserialize<'de> for Small {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Small, D::Error> {
            let x = f64::deserialize(deserializer)?;
            if x < 10.0 { Ok(Small(x)) } else { Err(de::Error::custom("it is not small")) }
        }
    }

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(untagged)]
    enum Either {
        Count(usize),
        Number(f64),
        Word(String),
    }

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields)]
    struct WholeStruct {
        name: String,
        x: f64,
        #[serde(default)]
        count: Option<usize>,
        #[serde(default)]
        forms: Vec<Form>,
        #[serde(default)]
        small: Vec<Small>,
        #[serde(default)]
        either: Vec<Either>,
    }

    #[test]
    fn every_shape_of_value_is_read() {
        let text = "name: 01 # a link\nx: -0.0\ncount: ~\nforms: [plain, {pair: [1, 2.5]}, {named: {height: 3}}, {one: 4}]\n\
                    either: [3, 0.5, word]\n";
        let read: WholeStruct = read_as(text).unwrap();
        let forms = vec![Form::Plain, Form::Pair(1.0, 2.5), Form::Named { height: 3.0 }, Form::One(4)];
        let either = vec![Either::Count(3), Either::Number(0.5), Either::Word("word".into())];
        assert_eq!((read.name.as_str(), read.x.to_bits(), read.count), ("01", (-0.0_f64).to_bits(), None));
        assert_eq!((read.forms, read.either), (forms, either));
    }

    #[test]
    fn a_scalar_that_a_name_is_made_of_is_as_it_was_written() {
        let read: Vec<String> = read_as("[01, 1e3, true, '1.50', a b, 1.50]").unwrap();
        assert_eq!(read, ["01", "1e3", "true", "1.50", "a b", "1.50"]);
        assert_eq!(read_as::<Vec<f64>>(""), Ok(vec![]));
        assert!(read_as::<f64>(".inf").is_ok_and(f64::is_infinite));
        let read: Vec<String> = read_as("- &a 7\n- *a\n- |\n  x\n").unwrap();
        assert_eq!(read, ["7", "7", "x\n"]);
    }

    /// Values that the YAML library itself accepts: an empty value for a map or a list, numbers in quotes, yes and no.
    #[test]
    fn what_people_write_is_read() {
        #[derive(Debug, Default, Deserialize, PartialEq)]
        #[serde(default, deny_unknown_fields)]
        struct AskedFields {
            on: bool,
            x: Option<f64>,
            count: usize,
            list: Vec<f64>,
            inner: Option<Box<AskedFields>>,
        }
        #[derive(Debug, Deserialize, PartialEq)]
        struct Outer {
            all: AskedFields,
        }
        let empty: Outer = read_as("all:\n  # x: 1\n").unwrap();
        assert_eq!(empty.all, AskedFields::default());
        let text = "all: {on: Yes, x: '1.5', count: \"3\", list: , inner: }\n";
        let read: Outer = read_as(text).unwrap();
        assert_eq!(read.all, AskedFields { on: true, x: Some(1.5), count: 3, ..AskedFields::default() });
        assert!(read_as::<bool>("maybe").unwrap_err().contains("expected a boolean"));
        assert!(read_as::<usize>("'1.5'").unwrap_err().contains("expected usize"));
        // The YAML library merges the entries of the anchor `a` into the map `b`.
        let merged: std::collections::BTreeMap<String, std::collections::BTreeMap<String, f64>> =
            read_as("a: &a {x: 1}\nb: {<<: *a, y: 2}\n").unwrap();
        assert_eq!(merged["b"].len(), 2);
    }

    #[test]
    fn an_error_has_the_place_of_what_is_not_expected() {
        for (text, expected) in [
            ("name: a\nx: word\n", "line 2 column 4: invalid type: string \"word\", expected f64"),
            ("name: a\n", "line 1 column 1: missing field `x`"),
            ("[a, 1]\n", "line 1 column 1: invalid type: sequence, expected struct Whole"),
            ("name: a\nx: 1\nforms: 3\n", "line 3 column 8: invalid type: integer `3`, expected a sequence"),
            ("name: a\nx: 1\ny: 2\n", "line 3 column 1: unknown field `y`, expected one of"),
            ("name: a\nx: 1\nx: 2\n", "line 3 column 1: the key `x` stands twice"),
            ("name: a\nx: 1\neither: [.nan]\n", "line 3 column 10: `.nan` is no finite number"),
            ("name: a\nx: 1\ncount: 1.5\n", "line 3 column 8: invalid type: floating point `1.5`, expected usize"),
            ("name: a\nx: 1\ncount: 9007199254740993\n", "line 3 column 8: invalid type: floating point"),
            ("name: a\nx: 1\nforms:\n  - plane\n", "line 4 column 5: unknown variant `plane`, expected one of"),
            ("name: a\nx: 1\nforms: [pair]\n", "line 3 column 9: a value is expected behind this word"),
            ("name: a\nx: 1\nforms: [{plain: 1}]\n", "line 3 column 17: no value is expected behind this word"),
            ("name: a\nx: 1\nforms: [{plain: 1, one: 2}]\n", "line 3 column 9: one word, or one key"),
            ("name: a\nx: 1\nsmall:\n  - 1\n  - 10\n", "line 5 column 5: it is not small"),
            ("name: a\nx: [1\n", "line "),
        ] {
            let found = read_as::<WholeStruct>(text).unwrap_err();
            assert!(found.starts_with(expected) && found.lines().count() == 1, "{text}: {found}");
        }
    }
}
