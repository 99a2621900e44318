//! Reads JSON as a table: an object of arrays, an array of objects, or one object per line (JSON Lines).
//!
//! | file | meaning |
//! |---|---|
//! | `{"t": [0, 0.1], "q": [[1, 2], [3, 4]]}` | named arrays, as in a .npz |
//! | `[{"t": 0, "q": [1, 2]}, ..]` | one row per object |
//! | `{"t": 0, "q": [1, 2]}` on each line | one row per line |
//!
//! `records` names the columns of a row. A null is a missing number.

use std::fmt;

use gate::budget::Budget;
use serde::de::{DeserializeSeed, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use serde_json::Value;

use crate::Error;
use crate::formats::arrays::Array;
use crate::formats::records::{Records, named};
use crate::table::Table;

/// Largest memory of a parsed value, per byte of its text. The worst case is `1,`, which becomes one value.
const VALUE_BYTES_PER_BYTE: usize = size_of::<Value>() / 2;

/// An example of a row.
const EXPECTED: &str = "an object such as {\"t\": 0, \"q\": [1, 2]} in each row";

/// First bytes of a JSON file that can contain a table.
pub(crate) const HEADS: [&[u8]; 6] = [b"{", b"[{", b"[ {", b"[\n{", b"[\n ", b"[\r\n"];

/// Reads a JSON file. The memory is taken from `budget`.
///
/// Fails if the text is not JSON, or if it contains no rows of numbers.
pub(crate) fn read(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
    let broken = |e: serde_json::Error| Error::at(file, e.line(), format!("this is no JSON: {e}"));
    let mut rows = Records::new(budget);
    if bytes.starts_with(b"[") {
        let mut reader = serde_json::Deserializer::from_slice(bytes);
        (&mut reader).deserialize_seq(&mut rows).and_then(|()| reader.end()).map_err(broken)?;
        return rows.into_table(file, EXPECTED);
    }
    let all = bytes.split(|byte| *byte == b'\n').enumerate().filter(|(_, line)| !line.trim_ascii().is_empty());
    // In JSON Lines, the first two lines are both whole JSON values. Otherwise the file is a single object of arrays.
    let mut some = all.clone().take(2).map(|(_, line)| serde_json::from_slice::<serde::de::IgnoredAny>(line).is_ok());
    if (some.next(), some.next()) != (Some(true), Some(true)) {
        rows.budget.draw(VALUE_BYTES_PER_BYTE.saturating_mul(bytes.len())).map_err(|e| Error::at(file, 0, e))?;
        let value: Value = serde_json::from_slice(bytes).map_err(broken)?;
        let mut found = Vec::new();
        arrays(String::new(), &value, &mut found);
        return Table::from_arrays(file, found);
    }
    for (k, line) in all {
        let mut reader = serde_json::Deserializer::from_slice(line);
        let outcome = add_document(&mut rows, &mut reader);
        outcome.and_then(|()| reader.end()).map_err(|e| Error::at(file, k + 1, format!("this is no JSON: {e}")))?;
        rows.end_row(k + 1).map_err(|e| Error::at(file, k + 1, e))?;
    }
    rows.into_table(file, EXPECTED)
}

/// The arrays of numbers inside a value, with their names.
fn arrays(name: String, value: &Value, found: &mut Vec<(String, Array)>) {
    let numbers = |value: &Value| -> Option<Vec<f64>> {
        value.as_array()?.iter().map(|x| x.as_f64().or(x.is_null().then_some(f64::NAN))).collect()
    };
    match value {
        Value::Object(members) => {
            for (key, value) in members {
                arrays(if name.is_empty() { key.clone() } else { format!("{name}.{key}") }, value, found);
            }
        }
        Value::Number(x) => {
            found.extend(x.as_f64().map(|x| (name, Array { shape: Vec::new(), values: vec![x] })));
        }
        Value::Array(members) => {
            if let Some(values) = numbers(value) {
                found.push((name, Array { shape: vec![values.len()], values }));
            } else if let Some(rows) = members.iter().map(numbers).collect::<Option<Vec<Vec<f64>>>>()
                && rows.iter().all(|row| row.len() == rows[0].len())
            {
                found.push((name, Array { shape: vec![rows.len(), rows[0].len()], values: rows.concat() }));
            }
        }
        _ => {}
    }
}

/// The elements of an array at the top are rows.
impl<'de> Visitor<'de> for &mut Records<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an array of objects")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut members: A) -> Result<(), A::Error> {
        while members.next_element_seed(Place { rows: self, name: String::new() })?.is_some() {
            self.end_row(0).map_err(A::Error::custom)?;
        }
        Ok(())
    }
}

/// Adds a document of named values to the current row of records. Fails if the document is damaged or has too many values.
pub fn add_document<'de, D: Deserializer<'de>>(rows: &mut Records, document: D) -> Result<(), D::Error> {
    Place { rows, name: String::new() }.deserialize(document)
}

/// A value of a row, with the name that leads to it.
struct Place<'a, 'b> {
    rows: &'a mut Records<'b>,
    name: String,
}

impl<'de> DeserializeSeed<'de> for Place<'_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, reader: D) -> Result<(), D::Error> {
        reader.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Place<'_, '_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number, an array or an object")
    }

    fn visit_f64<E: serde::de::Error>(self, x: f64) -> Result<(), E> {
        self.rows.set(&self.name, x).map_err(E::custom)
    }

    fn visit_i64<E: serde::de::Error>(self, x: i64) -> Result<(), E> {
        self.visit_f64(x as f64)
    }

    fn visit_u64<E: serde::de::Error>(self, x: u64) -> Result<(), E> {
        self.visit_f64(x as f64)
    }

    fn visit_bool<E: serde::de::Error>(self, x: bool) -> Result<(), E> {
        self.visit_f64(f64::from(x))
    }

    fn visit_unit<E: serde::de::Error>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<(), E> {
        self.rows.set_text(&self.name, text).map_err(E::custom)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut members: A) -> Result<(), A::Error> {
        let mut number = 1;
        let name = |number: usize| named(&self.name, &number.to_string(), '_').map_err(A::Error::custom);
        while members.next_element_seed(Place { rows: self.rows, name: name(number)? })?.is_some() {
            number += 1;
        }
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<(), A::Error> {
        while let Some(key) = members.next_key::<String>()? {
            let name = named(&self.name, &key, '.').map_err(A::Error::custom)?;
            members.next_value_seed(Place { rows: self.rows, name })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<Table, String> {
        read("x.json", text.as_bytes(), &mut Budget::of(text.len())).map_err(|e| e.to_string())
    }

    #[test]
    fn all_forms_are_the_same_table() {
        let columns = "{\"t\": [0, 0.1],\n \"q\": [[1, 2], [3, 4]], \"state\": {\"tau\": [5, null]}}";
        let rows = "[{\"t\": 0, \"q\": [1, 2], \"state\": {\"tau\": 5}},\n{\"t\": 0.1, \"q\": [3, 4], \"state\": {\"tau\": null}}]";
        let lines = "{\"t\": 0, \"q\": [1, 2], \"state\": {\"tau\": 5}}\n\n{\"t\": 0.1, \"q\": [3, 4]}\n";
        for text in [columns, rows, lines] {
            let found = table(text).unwrap();
            let column = |name: &str| &found.columns[found.header.iter().position(|h| h == name).unwrap()];
            assert_eq!(
                (column("t"), column("q_1"), column("q_2")),
                (&vec![0.0, 0.1], &vec![1.0, 3.0], &vec![2.0, 4.0])
            );
            assert!(column("state.tau")[0] == 5.0 && column("state.tau")[1].is_nan(), "{text}");
        }
        let found = table(lines).unwrap();
        assert_eq!((found.line(0), found.line(1)), (1, 3));
        let named = table("{\"t\": 0, \"mode\": \"auto\"}\n{\"t\": 1, \"mode\": \"auto\"}\n").unwrap();
        assert_eq!(named.texts[1], Some((1, "auto".into())));
    }

    #[test]
    fn damage_is_refused() {
        for (text, said) in [
            ("{\"t\": 0}\n{\"t\": }\n", "no JSON"),
            ("{\"t\": 0}\n{\"t\": 1}\n{\"t\":\n", "x.json:3: this is no JSON"),
            ("[{\"t\": 0}, 3", "this is no JSON"),
            ("{}\n{}\n", "no row holds a number"),
            ("[]", "no row holds a number"),
            ("{\"t\": \"a\"}", "no array holds samples"),
        ] {
            let message = table(text).unwrap_err();
            assert!(message.contains(said), "{text}: {message}");
        }
        let long = format!("{{\"{}\": 1}}\n{{\"t\": 1}}\n", "n".repeat(300));
        assert!(table(&long).unwrap_err().contains("longer than 256 bytes"));
        // Each row has a new key. The table would contain far more missing numbers than the file has bytes.
        let sparse: String = (0..20_000).map(|k| format!("{{\"k{}\":1}}\n", k % 9999)).collect();
        assert!(table(&sparse).is_err());
        let whole = "[{\"t\": 0, \"q\": [1, {\"a\": 2}]}]";
        for end in 0..whole.len() {
            let _ = table(&whole[..end]);
        }
    }
}
