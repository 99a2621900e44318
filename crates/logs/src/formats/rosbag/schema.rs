//! Parses the definition of a message type in a recording (`ros2msg`, `ros1msg`).
//!
//! A definition has lines `type name`, and for each nested type a line of `=` and a line `MSG: package/Name`. A type is a number,
//! a text or another definition; `[]`, `[n]` and `[<=n]` mean arrays. Constants (`NAME=1`), defaults and comments have no effect
//! on the layout of a message.

use std::collections::BTreeMap;

/// Largest length of a definition, bytes. Definitions of common robots have at most some thousand bytes.
const MAX_SCHEMA_BYTES: usize = 1 << 18;

/// Largest length of a field name, bytes.
pub(crate) const MAX_NAME_BYTES: usize = 200;

/// The type of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FieldType {
    /// The types `bool`, `byte`, `uint8` and `char`.
    U8,
    I8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
    Text,
    /// Two integers: s and ns.
    Time,
    /// A nested definition: its index in the schema.
    Record(usize),
}

/// The number of elements of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Count {
    One,
    Fixed(usize),
    Many,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SchemaField {
    pub name: String,
    pub kind: FieldType,
    pub count: Count,
}

/// The definitions of a message type and of its nested types. The first one is the message type itself.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Schema {
    pub records: Vec<Vec<SchemaField>>,
}

impl Schema {
    /// Parses the definition of the message type `name`.
    ///
    /// Fails if the text is too long, or if it uses an unknown type.
    pub(crate) fn of(name: &str, text: &str) -> Result<Schema, String> {
        if text.len() > MAX_SCHEMA_BYTES {
            return Err(format!("its definition has {} bytes; at most {MAX_SCHEMA_BYTES} are read", text.len()));
        }
        let name = short(name);
        let mut parts: Vec<(String, Vec<&str>)> = vec![(name, Vec::new())];
        for line in text.lines().map(|line| line.split('#').next().unwrap_or("").trim()) {
            if let Some(name) = line.strip_prefix("MSG:") {
                parts.push((short(name.trim()), Vec::new()));
            } else if !line.is_empty()
                && !line.starts_with("===")
                && let Some(part) = parts.last_mut()
            {
                part.1.push(line);
            }
        }
        let places: BTreeMap<&str, usize> = parts.iter().enumerate().rev().map(|(k, p)| (p.0.as_str(), k)).collect();
        let record = |(name, lines): &(String, Vec<&str>)| -> Result<Vec<SchemaField>, String> {
            let package = name.split('/').next().unwrap_or("");
            let fields = lines.iter().filter_map(|line| field(line, package, &places).transpose());
            fields.collect::<Result<_, _>>().map_err(|e| format!("the definition of {name}: {e}"))
        };
        Ok(Schema { records: parts.iter().map(record).collect::<Result<_, _>>()? })
    }
}

/// Converts `package/msg/Name` to `package/Name`.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// Parses the field on a line; `None` if the line defines a constant.
fn field(line: &str, package: &str, places: &BTreeMap<&str, usize>) -> Result<Option<SchemaField>, String> {
    let (kind, rest) = line.split_once(char::is_whitespace).ok_or_else(|| format!("`{line}` names no field"))?;
    let rest = rest.trim();
    let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    if name.is_empty() || name.len() > MAX_NAME_BYTES {
        return Err(format!("`{line}` names no field"));
    }
    // A constant has `=` after its name. A default has no `=`. In `[<=n]`, the `=` is before the name.
    if rest[name.len()..].trim_start().starts_with('=') {
        return Ok(None);
    }
    let (kind, count) = match kind.split_once('[') {
        None => (kind, Count::One),
        Some((kind, size)) => match size.trim_end_matches(']') {
            "" => (kind, Count::Many),
            bounded if bounded.starts_with("<=") => (kind, Count::Many),
            size => match size.parse() {
                Ok(0) | Err(_) => return Err(format!("`{line}`: `{size}` is no size of an array")),
                Ok(size) => (kind, Count::Fixed(size)),
            },
        },
    };
    let kind = match kind.split("<=").next().unwrap_or(kind) {
        "bool" | "byte" | "octet" | "uint8" | "char" => FieldType::U8,
        "int8" => FieldType::I8,
        "int16" => FieldType::I16,
        "uint16" => FieldType::U16,
        "int32" => FieldType::I32,
        "uint32" => FieldType::U32,
        "int64" => FieldType::I64,
        "uint64" => FieldType::U64,
        "float32" => FieldType::F32,
        "float64" => FieldType::F64,
        "string" => FieldType::Text,
        "time" | "duration" => FieldType::Time,
        other => {
            let other = short(other);
            let candidates = [other.clone(), format!("{package}/{other}"), format!("std_msgs/{other}")];
            if matches!(other.as_str(), "builtin_interfaces/Time" | "builtin_interfaces/Duration") {
                FieldType::Time
            } else {
                let place = candidates.iter().find_map(|name| places.get(name.as_str()));
                FieldType::Record(*place.ok_or_else(|| format!("`{other}` of `{line}` is not defined"))?)
            }
        }
    };
    Ok(Some(SchemaField { name, kind, count }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition_with_what_stands_in_it() {
        let text = "# state\nstd_msgs/Header header\nuint8 MODE=3\nuint8[2] head\nfloat64[<=4] q # rad\nMotor[] motors\n\
                    float32 gain 1.5\nstring<=8 name\n=====\nMSG: a/Motor\nfloat32 q\n=====\nMSG: std_msgs/Header\n\
                    builtin_interfaces/Time stamp\nstring frame_id\n";
        let schema = Schema::of("a/msg/State", text).unwrap();
        let shown: Vec<String> =
            schema.records[0].iter().map(|f| format!("{} {:?} {:?}", f.name, f.kind, f.count)).collect();
        let expected = [
            "header Record(2) One",
            "head U8 Fixed(2)",
            "q F64 Many",
            "motors Record(1) Many",
            "gain F32 One",
            "name Text One",
        ];
        assert_eq!(shown, expected);
        assert_eq!(
            schema.records[2][0],
            SchemaField { name: "stamp".into(), kind: FieldType::Time, count: Count::One }
        );
    }

    #[test]
    fn what_is_no_definition_is_refused() {
        for (text, wanted) in [
            ("float64", "`float64` names no field"),
            ("Motor m", "`Motor` of `Motor m` is not defined"),
            ("float64[0] q", "no size of an array"),
            ("float64[-1] q", "no size of an array"),
        ] {
            let message = Schema::of("a/State", text).unwrap_err();
            assert!(message.contains(wanted) && message.contains("the definition of a/State"), "{message}");
        }
        assert!(Schema::of("a/State", &"#".repeat(MAX_SCHEMA_BYTES + 1)).unwrap_err().contains("bytes"));
    }
}
