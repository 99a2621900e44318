//! Checks the size of the schema of a Parquet file, before the library builds a tree of it.
//!
//! The crate `parquet` (60.1) reads the schema recursively and allocates the stated number of children of each element. A footer
//! of 100 kB with deep nesting overflows the stack, and 2^31 stated children need 16 GiB. Neither error can be caught. So this
//! module first reads only the number of children of every element, in Thrift's compact protocol: FileMetaData {2: list of
//! SchemaElement {5: num_children}}.

use crate::table::MAX_COLUMNS;

/// Largest depth of a schema. The schema of a robot's log is less deep.
const MAX_SCHEMA_DEPTH: usize = 16;

/// Largest nesting depth of fields that are skipped.
const MAX_SKIPPED_DEPTH: usize = 16;

/// The message if the index ends too early.
const INDEX_ENDS_EARLY: &str = "the index of the file is damaged: it ends too early";

/// Fails if the schema in a footer is nested too deeply, or states more elements than it has.
pub(crate) fn check(footer: &[u8]) -> Result<(), String> {
    let mut bytes = Bytes(footer);
    let mut children = Vec::new();
    bytes.fields(&mut |bytes, id, kind| match (id, kind) {
        (2, 9) => {
            let (count, _) = bytes.list()?;
            // A schema has at most as many groups as columns, so at most two elements per column.
            if count > 2 * MAX_COLUMNS {
                return Err(format!("its schema claims {count} elements; at most {MAX_COLUMNS} columns are expected"));
            }
            for _ in 0..count {
                let mut below = 0;
                bytes.fields(&mut |bytes, id, kind| match (id, kind) {
                    (5, 5) => bytes.varint().map(|n| below = n >> 1),
                    _ => bytes.pass(kind, MAX_SKIPPED_DEPTH),
                })?;
                children.push(below);
            }
            Ok(())
        }
        _ => bytes.pass(kind, MAX_SKIPPED_DEPTH),
    })?;
    // For each element whose children are not complete: the number of missing children.
    let mut open: Vec<u64> = Vec::new();
    for (place, &below) in children.iter().enumerate() {
        if below > (children.len() - place) as u64 {
            return Err(format!("an element of its schema claims {below} parts of {}", children.len()));
        }
        open.iter_mut().rev().take(1).for_each(|left| *left -= 1);
        if below > 0 {
            open.push(below);
        }
        if open.len() > MAX_SCHEMA_DEPTH {
            return Err("the schema is nested too deeply".into());
        }
        while open.last() == Some(&0) {
            open.pop();
        }
    }
    Ok(())
}

/// Bytes that are read one after the other.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn byte(&mut self) -> Result<u8, String> {
        let (byte, rest) = self.0.split_first().ok_or(INDEX_ENDS_EARLY)?;
        self.0 = rest;
        Ok(*byte)
    }

    fn skip(&mut self, count: u64) -> Result<(), String> {
        self.0 = usize::try_from(count).ok().and_then(|n| self.0.get(n..)).ok_or(INDEX_ENDS_EARLY)?;
        Ok(())
    }

    /// Reads an integer with seven bits per byte; the lowest bits are first.
    fn varint(&mut self) -> Result<u64, String> {
        let mut value = 0;
        for k in 0..10 {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << (7 * k);
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(INDEX_ENDS_EARLY.into())
    }

    /// Reads the head of a list: its number of elements and their type. Each element needs at least one byte.
    fn list(&mut self) -> Result<(usize, u8), String> {
        let head = self.byte()?;
        let count = if head >> 4 == 15 { self.varint()? } else { u64::from(head >> 4) };
        if count > self.0.len() as u64 {
            return Err(format!("the metadata claim {count} elements where {} bytes are left", self.0.len()));
        }
        Ok((count as usize, head & 15))
    }

    /// Passes each field of a struct to `each`: its number and its type.
    fn fields(&mut self, each: &mut dyn FnMut(&mut Self, i64, u8) -> Result<(), String>) -> Result<(), String> {
        let mut id = 0i64;
        loop {
            let head = self.byte()?;
            if head == 0 {
                return Ok(());
            }
            id = match head >> 4 {
                0 => {
                    let n = self.varint()?;
                    (n >> 1) as i64 ^ -((n & 1) as i64)
                }
                step => id.wrapping_add(i64::from(step)),
            };
            each(self, id, head & 15)?;
        }
    }

    /// Skips a field.
    fn pass(&mut self, kind: u8, depth: usize) -> Result<(), String> {
        let depth = depth.checked_sub(1).ok_or("the metadata are nested too deeply")?;
        match kind {
            1 | 2 => Ok(()),
            3 => self.skip(1),
            4..=6 => self.varint().map(|_| ()),
            7 => self.skip(8),
            8 => {
                let length = self.varint()?;
                self.skip(length)
            }
            9 | 10 => {
                let (count, kind) = self.list()?;
                // In a list, a boolean needs a byte.
                (0..count).try_for_each(|_| if kind <= 2 { self.skip(1) } else { self.pass(kind, depth) })
            }
            12 => self.fields(&mut |bytes, _, kind| bytes.pass(kind, depth)),
            other => Err(format!("the metadata hold a field of kind {other}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A footer of version 1. `children`: number of children of each element.
    fn footer(children: &[u32]) -> Vec<u8> {
        let varint = |mut n: u32| {
            let mut out = Vec::new();
            while n > 127 {
                out.push(n as u8 | 128);
                n >>= 7;
            }
            out.push(n as u8);
            out
        };
        let mut out = [&[0x15, 2, 0x19, 0xfc][..], &varint(children.len() as u32)].concat();
        for n in children {
            // The element {4: "a", 5: n} in Thrift's compact protocol.
            out.extend([&[0x48, 1, b'a', 0x15][..], &varint(n << 1), &[0]].concat());
        }
        out.push(0);
        out
    }

    #[test]
    fn schemas_within_their_bounds() {
        assert_eq!(check(&footer(&[2, 1, 0, 0])), Ok(()));
        let nested = |depth: usize| [vec![1; depth], vec![0]].concat();
        assert_eq!(check(&footer(&nested(16))), Ok(()));
        assert!(check(&footer(&nested(17))).unwrap_err().contains("nested too deeply"));
        assert!(check(&footer(&nested(15_000))).unwrap_err().contains("nested too deeply"));
        assert!(check(&footer(&[1 << 30, 0])).unwrap_err().contains("claims 1073741824 parts of 2"));
        assert!(check(&[0x19, 0xfc, 0xff, 0xff, 0xff, 0xff, 0x0f]).unwrap_err().contains("claim 4294967295 elements"));
        for cut in 0..footer(&[2, 0, 0]).len() {
            assert!(check(&footer(&[2, 0, 0])[..cut]).is_err(), "{cut}");
        }
    }
}
