//! Reads the fields of a flatbuffer (flatbuffers.dev, "Internals"), the format in which Arrow describes its messages.
//!
//! A table begins with 4 bytes: the distance back to its index (vtable). The index contains its own length and the length of the
//! table, 2 bytes each. Then it has an entry for every field: the distance from the start of the table to the field, or 0 if the
//! field has its default. If a field is a table, a text or a vector, it contains the distance to that object. Numbers are
//! little-endian. Every position is checked before it is read.

/// Largest number of elements of a vector of tables. A log never has more columns.
const MAX_TABLES: usize = 10_000;

/// A table of a flatbuffer.
#[derive(Clone, Copy)]
pub(crate) struct FlatTable<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Position and length of the index of the table, bytes.
    index: (usize, usize),
}

fn damaged<T>() -> Result<T, String> {
    Err("its description is damaged: a place in it is outside".into())
}

fn number<const N: usize>(bytes: &[u8], at: usize) -> Result<[u8; N], String> {
    let found = bytes.get(at..).and_then(|rest| rest.first_chunk());
    found.copied().map_or_else(damaged, Ok)
}

/// The position to which the 4-byte offset at position `at` points.
fn target(bytes: &[u8], at: usize) -> Result<usize, String> {
    let distance = u32::from_le_bytes(number(bytes, at)?) as usize;
    at.checked_add(distance).filter(|end| *end < bytes.len()).map_or_else(damaged, Ok)
}

impl<'a> FlatTable<'a> {
    /// The table at the start of a buffer.
    pub(crate) fn root(bytes: &'a [u8]) -> Result<FlatTable<'a>, String> {
        FlatTable::at(bytes, target(bytes, 0)?)
    }

    fn at(bytes: &'a [u8], at: usize) -> Result<FlatTable<'a>, String> {
        let back = i32::from_le_bytes(number(bytes, at)?);
        let index = i64::try_from(at).ok().and_then(|at| usize::try_from(at - i64::from(back)).ok());
        let index = index.map_or_else(damaged, Ok)?;
        let length = usize::from(u16::from_le_bytes(number(bytes, index)?));
        if bytes.len() - index < length {
            return damaged();
        }
        Ok(FlatTable { bytes, at, index: (index, length) })
    }

    /// The position of the field with the number `id`. `None` if the field has its default.
    fn field(&self, id: usize) -> Result<Option<usize>, String> {
        let (index, length) = self.index;
        let entry = 4 + 2 * id;
        if entry + 2 > length {
            return Ok(None);
        }
        let distance = usize::from(u16::from_le_bytes(number(self.bytes, index + entry)?));
        Ok((distance > 0).then_some(self.at + distance))
    }

    /// Reads the field `id` as a number of N bytes. `None` if the field has its default.
    pub(crate) fn number<const N: usize>(&self, id: usize) -> Result<Option<[u8; N]>, String> {
        self.field(id)?.map(|at| number(self.bytes, at)).transpose()
    }

    /// Reads the field `id` as a number of two bytes, or returns its default.
    pub(crate) fn short(&self, id: usize, default: i16) -> Result<i16, String> {
        Ok(self.number(id)?.map_or(default, i16::from_le_bytes))
    }

    /// Reads the field `id` as a number of four bytes, or returns its default.
    pub(crate) fn int(&self, id: usize, default: i32) -> Result<i32, String> {
        Ok(self.number(id)?.map_or(default, i32::from_le_bytes))
    }

    /// Reads the field `id` as a length or count of eight bytes; 0 by default.
    pub(crate) fn length(&self, id: usize) -> Result<usize, String> {
        let length = self.number(id)?.map_or(0, i64::from_le_bytes);
        usize::try_from(length).or_else(|_| damaged())
    }

    pub(crate) fn table(&self, id: usize) -> Result<Option<FlatTable<'a>>, String> {
        self.field(id)?.map(|at| FlatTable::at(self.bytes, target(self.bytes, at)?)).transpose()
    }

    /// Reads the field `id` as a vector: number of elements, and position of the first element.
    fn vector(&self, id: usize) -> Result<(usize, usize), String> {
        let Some(at) = self.field(id)? else { return Ok((0, 0)) };
        let at = target(self.bytes, at)?;
        Ok((u32::from_le_bytes(number(self.bytes, at)?) as usize, at + 4))
    }

    /// Reads the field `id` as a vector of elements with `size` bytes each: the bytes of all elements.
    pub(crate) fn elements(&self, id: usize, size: usize) -> Result<&'a [u8], String> {
        let (count, first) = self.vector(id)?;
        let end = count.checked_mul(size).and_then(|length| first.checked_add(length));
        end.and_then(|end| self.bytes.get(first..end)).map_or_else(damaged, Ok)
    }

    pub(crate) fn text(&self, id: usize) -> Result<&'a str, String> {
        std::str::from_utf8(self.elements(id, 1)?).map_err(|_| "a name in its description is no UTF-8".into())
    }

    pub(crate) fn tables(&self, id: usize) -> Result<Vec<FlatTable<'a>>, String> {
        let places = self.elements(id, 4)?;
        let (count, first) = (places.len() / 4, self.vector(id)?.1);
        if count > MAX_TABLES {
            return Err(format!("{count} columns; at most {MAX_TABLES} are expected"));
        }
        (0..count).map(|k| FlatTable::at(self.bytes, target(self.bytes, first + 4 * k)?)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A table with four fields: 0 is the number 7 in two bytes, 1 has its default, 2 is the text `ab`, 3 is a vector of the
    /// table itself.
    fn buffer() -> Vec<u8> {
        let mut bytes = vec![16, 0, 0, 0];
        // The index (vtable): its length, the length of the table, and the distances of the four fields from the start of the
        // table.
        bytes.extend([12u16, 16, 4, 0, 8, 12].iter().flat_map(|x| x.to_le_bytes()));
        // The table starts at position 16. The distance back to its index is 12 bytes.
        bytes.extend(12i32.to_le_bytes());
        bytes.extend([7, 0, 0, 0]);
        bytes.extend(8u32.to_le_bytes()); // at 24: to 32
        bytes.extend(12u32.to_le_bytes()); // at 28: to 40
        bytes.extend(2u32.to_le_bytes());
        bytes.extend(b"ab\0\0");
        bytes.extend(0u32.to_le_bytes());
        bytes
    }

    #[test]
    fn fields_and_defaults() {
        let bytes = buffer();
        let table = FlatTable::root(&bytes).unwrap();
        assert_eq!((table.short(0, 1), table.short(1, 1), table.short(9, 1)), (Ok(7), Ok(1), Ok(1)));
        assert_eq!((table.text(2), table.text(1)), (Ok("ab"), Ok("")));
        assert_eq!(table.tables(3).unwrap().len(), 0);
    }

    /// Any content of a buffer is read or refused; reading never panics.
    #[test]
    fn damage_is_no_panic() {
        let whole = buffer();
        for at in 0..whole.len() {
            for byte in [0, 1, 127, 128, 255] {
                let mut bytes = whole.clone();
                bytes[at] = byte;
                for bytes in [&bytes[..], &bytes[..at]] {
                    if let Ok(table) = FlatTable::root(bytes) {
                        let _read_or_refused = (
                            table.number::<8>(0),
                            table.length(1),
                            table.text(2),
                            table.tables(3).is_ok(),
                            table.table(2).is_ok(),
                        );
                    }
                }
            }
        }
    }
}
