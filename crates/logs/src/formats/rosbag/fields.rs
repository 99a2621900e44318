//! Extracts the numbers of a message of any type, each with the path of its field.
//!
//! Examples of paths: `motor_state[3].q`, `measured_joint_position[0]`. If an array of texts with the same length precedes an
//! array, its texts name the elements: `position[elbow]`, `interface_values[elbow].values[effort]`.

use crate::formats::rosbag::cdr::{Cursor, Encoding};
use crate::formats::rosbag::schema::{Count, FieldType, MAX_NAME_BYTES, Schema, SchemaField};

/// Longer arrays, for example images, are no signals and are skipped.
const MAX_ELEMENTS: usize = 256;
/// Largest depth of nested definitions.
const MAX_DEPTH: usize = 16;

/// The content of a message: its numbers and their paths.
#[derive(Debug, Default)]
pub(crate) struct MessageFields {
    /// The numbers, in the order of the fields.
    pub values: Vec<f64>,
    /// Lengths and texts of the arrays as bytes. Two messages with equal bytes have the same paths.
    pub form: Vec<u8>,
    /// Time in the header, ns; zero if there is none.
    pub stamp: i64,
    /// The paths of the values; `None` unless they were requested.
    pub paths: Option<Vec<String>>,
}

/// Decodes a message. `with_paths`: whether the paths of the values are computed.
pub(crate) fn decode(
    data: &[u8],
    encoding: Encoding,
    schema: &Schema,
    with_paths: bool,
) -> Result<MessageFields, String> {
    let cursor = Cursor::new(data, encoding, "message of its definition")?;
    let found = MessageFields { paths: with_paths.then(Vec::new), ..MessageFields::default() };
    let mut walk = FieldWalk { cursor, schema, found, path: String::new(), depth: 0, is_present: true };
    walk.record(0)?;
    Ok(walk.found)
}

struct FieldWalk<'a> {
    cursor: Cursor<'a>,
    schema: &'a Schema,
    found: MessageFields,
    path: String,
    depth: usize,
    /// Whether the numbers are stored; otherwise they are skipped.
    is_present: bool,
}

impl<'a> FieldWalk<'a> {
    fn record(&mut self, place: usize) -> Result<(), String> {
        let schema = self.schema;
        let fields = &schema.records[place];
        if self.depth == MAX_DEPTH {
            return Err(format!("more than {MAX_DEPTH} definitions stand in one another"));
        }
        self.depth += 1;
        // A type without fields is stored as one byte. So each record consumes bytes, and the loop over a message ends.
        if fields.is_empty() {
            self.cursor.bytes(1)?;
        }
        let mut names: Vec<&'a str> = Vec::new();
        for field in fields {
            let before = self.path.len();
            if !self.path.is_empty() {
                self.path.push('.');
            }
            self.path.push_str(&field.name);
            self.field(field, &mut names)?;
            self.path.truncate(before);
        }
        self.depth -= 1;
        Ok(())
    }

    fn field(&mut self, field: &SchemaField, names: &mut Vec<&'a str>) -> Result<(), String> {
        let count = match field.count {
            Count::One => return self.element(field.kind),
            Count::Fixed(count) => count,
            Count::Many => {
                let count = self.cursor.u32()?;
                self.found.form.extend_from_slice(&count.to_le_bytes());
                count as usize
            }
        };
        if field.kind == FieldType::Text {
            let mut texts = Vec::new();
            for _ in 0..count {
                texts.push(self.cursor.text()?);
            }
            let are_short = texts.iter().all(|text| text.len() <= MAX_NAME_BYTES);
            let are_names = texts.len() <= MAX_ELEMENTS && are_short && {
                let mut sorted = texts.clone();
                sorted.sort_unstable();
                sorted.windows(2).all(|w| w[0] != w[1])
            };
            if are_names && self.is_present {
                texts.iter().for_each(|text| {
                    self.found.form.extend_from_slice(text.as_bytes());
                    self.found.form.push(0);
                });
                *names = texts;
            }
            return Ok(());
        }
        // A long array of bytes is skipped in one step.
        if matches!(field.kind, FieldType::U8 | FieldType::I8) && count > MAX_ELEMENTS {
            return self.cursor.bytes(count).map(drop);
        }
        if count > self.cursor.left() {
            return self.cursor.bytes(count).map(drop);
        }
        let was_stored = self.is_present;
        self.is_present &= count <= MAX_ELEMENTS;
        for k in 0..count {
            let before = self.path.len();
            if self.found.paths.is_some() && self.is_present {
                let number = k.to_string();
                let label = if names.len() == count { names[k] } else { number.as_str() };
                self.path.push('[');
                self.path.push_str(label);
                self.path.push(']');
            }
            self.element(field.kind)?;
            self.path.truncate(before);
        }
        self.is_present = was_stored;
        Ok(())
    }

    fn element(&mut self, kind: FieldType) -> Result<(), String> {
        let cursor = &mut self.cursor;
        let value = match kind {
            FieldType::U8 => f64::from(cursor.number::<1>()?[0]),
            FieldType::I8 => f64::from(i8::from_le_bytes(cursor.number()?)),
            FieldType::I16 => f64::from(i16::from_le_bytes(cursor.number()?)),
            FieldType::U16 => f64::from(u16::from_le_bytes(cursor.number()?)),
            FieldType::I32 => f64::from(i32::from_le_bytes(cursor.number()?)),
            FieldType::U32 => f64::from(cursor.u32()?),
            FieldType::I64 => i64::from_le_bytes(cursor.number()?) as f64,
            FieldType::U64 => u64::from_le_bytes(cursor.number()?) as f64,
            FieldType::F32 => f64::from(f32::from_le_bytes(cursor.number()?)),
            FieldType::F64 => f64::from_le_bytes(cursor.number()?),
            FieldType::Text => return cursor.text().map(drop),
            FieldType::Record(place) => return self.record(place),
            FieldType::Time => return self.time(),
        };
        self.store(value);
        Ok(())
    }

    fn store(&mut self, value: f64) {
        if self.is_present {
            self.found.values.push(value);
            if let Some(paths) = &mut self.found.paths {
                paths.push(self.path.clone());
            }
        }
    }

    /// Reads a time. The time in the header becomes the time of the message.
    fn time(&mut self) -> Result<(), String> {
        let (seconds, nanoseconds) = (self.cursor.u32()?, self.cursor.u32()?);
        // ROS 2 counts seconds as int32, ROS 1 as uint32.
        let seconds = if self.cursor.aligned { i64::from(seconds as i32) } else { i64::from(seconds) };
        let stamp = seconds * 1_000_000_000 + i64::from(nanoseconds);
        if self.path == "header.stamp" || self.path == "stamp" {
            self.found.stamp = stamp;
        } else {
            self.store(stamp as f64 / 1e9);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(numbers: &[u32]) -> Vec<u8> {
        [&[0, 1, 0, 0][..], &numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>()].concat()
    }

    #[test]
    fn numbers_have_the_paths_of_their_fields() {
        let schema =
            Schema::of("a/S", "uint8[2] head\nM[2] motor\nuint32 tick\n====\nMSG: a/M\nfloat32 q\nint16 tau").unwrap();
        let one = 1f32.to_bits();
        // The bytes: head 7 8, alignment; q 1.0, tau 5, alignment; q 1.0, tau -1.
        let data = words(&[0x0807, one, 5, one, 0xffff, 9]);
        let found = decode(&data, Encoding::Cdr, &schema, true).unwrap();
        assert_eq!(found.values, [7.0, 8.0, 1.0, 5.0, 1.0, -1.0, 9.0]);
        let paths = found.paths.unwrap();
        assert_eq!(paths, ["head[0]", "head[1]", "motor[0].q", "motor[0].tau", "motor[1].q", "motor[1].tau", "tick"]);
        for cut in 0..data.len() {
            assert!(decode(&data[..cut], Encoding::Cdr, &schema, true).is_err(), "{cut}");
        }
    }

    #[test]
    fn texts_name_the_elements_behind_them() {
        let schema = Schema::of("a/S", "string[] name\nfloat32[] position\nfloat32[] other").unwrap();
        let data = words(&[2, 2, 0x0061, 2, 0x0062, 2, 1f32.to_bits(), 2f32.to_bits(), 1, 3f32.to_bits()]);
        let found = decode(&data, Encoding::Cdr, &schema, true).unwrap();
        assert_eq!(found.paths.unwrap(), ["position[a]", "position[b]", "other[0]"]);
        assert_eq!(found.values, [1.0, 2.0, 3.0]);
    }

    #[test]
    fn nothing_that_a_message_claims_is_without_end() {
        let own = Schema::of("a/S", "S[] s").unwrap();
        let deep = words(&[1; 100]);
        assert!(decode(&deep, Encoding::Cdr, &own, false).unwrap_err().contains("stand in one another"));
        let empty = Schema::of("a/S", "E[] e\n===\nMSG: a/E").unwrap();
        assert!(decode(&words(&[u32::MAX]), Encoding::Cdr, &empty, false).is_err());
        let many = Schema::of("a/S", "float64[4000000000] q").unwrap();
        assert!(decode(&words(&[0; 20]), Encoding::Cdr, &many, false).is_err());
        // A long array is skipped.
        let image = Schema::of("a/S", "uint32[] image\nuint32 tick").unwrap();
        let data = words(&[&[300][..], &[5; 300], &[7]].concat());
        assert_eq!(decode(&data, Encoding::Cdr, &image, true).unwrap().values, [7.0]);
    }
}
