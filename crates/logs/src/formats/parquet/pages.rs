//! The pages of one column chunk of a Parquet file: levels and numbers.
//!
//! Encodings: PLAIN, dictionaries, DELTA_BINARY_PACKED and BYTE_STREAM_SPLIT, which is what the known writers use
//! for numbers; levels in the RLE / bit-packed hybrid. Data pages of version 1 and 2. No count of the
//! file is believed: every loop ends with its bytes or at the number of values the caller allows.

use crate::formats::compression::Compression;
use crate::formats::parquet::thrift::{Thrift, varint, zigzag};

/// What the schema says of a column of numbers.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Bytes of a number, 4 or 8.
    pub width: usize,
    pub max_definition: u32,
    /// 1 for lists.
    pub max_repetition: u32,
    /// The definition level from which on an element of a list exists.
    pub element: u32,
}

/// One number, or the place where there is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// The bits of a number of the column's width.
    Number(u64),
    Null,
    /// A row whose list is empty or null.
    NoElement,
}

/// The cells of a chunk, and for lists which of them begin a row.
#[derive(Debug, Default)]
pub struct Cells {
    pub cells: Vec<Cell>,
    pub starts: Vec<bool>,
}

/// Reads the chunk that `metadata` (ColumnMetaData) describes.
pub fn read(file: &[u8], metadata: &Thrift, shape: Shape) -> Result<Cells, String> {
    let codec = compression(metadata.integer(4).unwrap_or(0))?;
    let missing = "the metadata of the column are incomplete";
    let (count, length) = (metadata.size(5).ok_or(missing)?, metadata.size(7).ok_or(missing)?);
    let data = metadata.size(9).ok_or(missing)?;
    let start = metadata.size(11).filter(|&d| d > 0 && d < data).unwrap_or(data);
    let end = start.checked_add(length).filter(|&end| end <= file.len());
    let end = end.ok_or_else(|| format!("its data reach beyond the {} bytes of the file", file.len()))?;
    let (mut bytes, mut dictionary, mut out) = (&file[start..end], Vec::new(), Cells::default());
    while out.cells.len() < count {
        let (header, taken) = Thrift::read(bytes)?;
        let (packed, size) = header.size(3).zip(header.size(2)).ok_or("a page has no length")?;
        let body = bytes.get(taken..).and_then(|b| b.get(..packed)).ok_or("a page reaches beyond its column")?;
        bytes = &bytes[taken + packed..];
        let page = Page { codec, shape, size, left: count - out.cells.len(), dictionary: &dictionary };
        match (header.integer(1), header.field(5), header.field(7), header.field(8)) {
            (Some(0), Some(head), ..) => page.version_1(head, body, &mut out)?,
            (Some(3), .., Some(head)) => page.version_2(head, body, &mut out)?,
            (Some(2), _, Some(head), _) => {
                let values = head.size(1).ok_or("a dictionary has no length")?;
                dictionary = plain(&codec.unpack(body, size)?, values, shape.width)?;
            }
            _ => {}
        }
    }
    Ok(out)
}

fn compression(codec: i64) -> Result<Compression, String> {
    let name = match codec {
        0 => return Ok(Compression::None),
        1 => return Ok(Compression::Snappy),
        2 => return Ok(Compression::Gzip),
        6 => return Ok(Compression::Zstd),
        7 => return Ok(Compression::Lz4Block),
        3 => "LZO".to_string(),
        4 => "BROTLI".to_string(),
        5 => "LZ4 of Hadoop".to_string(),
        other => format!("the unknown codec {other}"),
    };
    Err(format!("it is compressed with {name}; write it with snappy, zstd, gzip, lz4_raw or uncompressed"))
}

struct Page<'a> {
    codec: Compression,
    shape: Shape,
    /// Bytes of the page unpacked.
    size: usize,
    /// Values the chunk still has to give.
    left: usize,
    dictionary: &'a [u64],
}

impl Page<'_> {
    fn version_1(&self, head: &Thrift, body: &[u8], out: &mut Cells) -> Result<(), String> {
        let count = self.count(head)?;
        let body = self.codec.unpack(body, self.size)?;
        let mut rest = body.as_slice();
        let mut levels = |max: u32, encoding: i16| -> Result<Vec<u32>, String> {
            if max == 0 {
                return Ok(Vec::new());
            }
            if head.integer(encoding) != Some(3) {
                return Err("its levels are in the old encoding BIT_PACKED, which is not read".into());
            }
            let (length, behind) = rest.split_at_checked(4).ok_or("a page ends within its levels")?;
            let length = length.iter().rev().fold(0, |n, &b| n << 8 | usize::from(b));
            let (bytes, behind) = behind.split_at_checked(length).ok_or("a page ends within its levels")?;
            rest = behind;
            hybrid(bytes, bits(max), count)
        };
        let repetition = levels(self.shape.max_repetition, 4)?;
        let definition = levels(self.shape.max_definition, 3)?;
        self.push(head.integer(2), count, &repetition, &definition, rest, out)
    }

    fn version_2(&self, head: &Thrift, body: &[u8], out: &mut Cells) -> Result<(), String> {
        let count = self.count(head)?;
        let lengths = head.size(6).zip(head.size(5)).ok_or("a page has levels of no length")?;
        let short = "a page ends within its levels";
        let (repetition, rest) = body.split_at_checked(lengths.0).ok_or(short)?;
        let (definition, rest) = rest.split_at_checked(lengths.1).ok_or(short)?;
        let levels = |bytes: &[u8], max: u32| if max == 0 { Ok(Vec::new()) } else { hybrid(bytes, bits(max), count) };
        let (repetition, definition) =
            (levels(repetition, self.shape.max_repetition)?, levels(definition, self.shape.max_definition)?);
        let size = self.size.checked_sub(lengths.0 + lengths.1).ok_or("a page is shorter than its levels")?;
        let unpacked;
        let values = if head.bool(7) == Some(false) || rest.is_empty() {
            rest
        } else {
            unpacked = self.codec.unpack(rest, size)?;
            &unpacked
        };
        self.push(head.integer(4), count, &repetition, &definition, values, out)
    }

    fn count(&self, head: &Thrift) -> Result<usize, String> {
        let count = head.size(1).ok_or("a page has no length")?;
        let message = || format!("a page claims {count} values where its column has {} left", self.left);
        if count <= self.left { Ok(count) } else { Err(message()) }
    }

    fn push(
        &self,
        encoding: Option<i64>,
        count: usize,
        repetition: &[u32],
        definition: &[u32],
        bytes: &[u8],
        out: &mut Cells,
    ) -> Result<(), String> {
        let Shape { width, max_definition, element, .. } = self.shape;
        let present =
            if max_definition == 0 { count } else { definition.iter().filter(|&&d| d == max_definition).count() };
        let values = match encoding {
            Some(0) => plain(bytes, present, width)?,
            Some(2 | 8) => {
                // A page of nulls may hold not even the width.
                let (width, bytes) = bytes.split_first().map_or((0, bytes), |(w, rest)| (u32::from(*w), rest));
                let places = hybrid(bytes, width, present)?;
                let value = |&i: &u32| self.dictionary.get(i as usize).copied();
                let values: Option<Vec<u64>> = places.iter().map(value).collect();
                values.ok_or("a value is not in the dictionary of its column")?
            }
            Some(5) => delta(bytes, present)?,
            Some(9) => split(bytes, present, width)?,
            other => {
                let other = other.unwrap_or(-1);
                return Err(format!(
                    "its encoding, number {other}, is not read; write it with plain or dictionary pages"
                ));
            }
        };
        let mut values = values.into_iter();
        for k in 0..count {
            let level = definition.get(k).copied().unwrap_or(max_definition);
            out.cells.push(match values.as_slice() {
                [_, ..] if level == max_definition => Cell::Number(values.next().unwrap_or(0)),
                _ if level < element => Cell::NoElement,
                _ => Cell::Null,
            });
        }
        if self.shape.max_repetition > 0 {
            out.starts.extend(repetition.iter().map(|&r| r == 0));
        }
        Ok(())
    }
}

/// Bits that hold the numbers up to `max`.
fn bits(max: u32) -> u32 {
    u32::BITS - max.leading_zeros()
}

fn plain(bytes: &[u8], count: usize, width: usize) -> Result<Vec<u64>, String> {
    let bytes = count.checked_mul(width).and_then(|n| bytes.get(..n)).ok_or("a page ends within its numbers")?;
    Ok(bytes.chunks_exact(width).map(|c| c.iter().rev().fold(0, |n, &b| n << 8 | u64::from(b))).collect())
}

/// All first bytes, then all second bytes, ..
fn split(bytes: &[u8], count: usize, width: usize) -> Result<Vec<u64>, String> {
    let bytes = count.checked_mul(width).and_then(|n| bytes.get(..n)).ok_or("a page ends within its numbers")?;
    let number = |i: usize| (0..width).rev().fold(0, |n, k| n << 8 | u64::from(bytes[k * count + i]));
    Ok((0..count).map(number).collect())
}

/// Bit fields of one width, the lowest bits of a byte first.
fn packed(bytes: &[u8], width: u32, count: usize) -> impl Iterator<Item = u64> + '_ {
    let width = width as usize;
    let field = move |i: usize| {
        let (from, to) = (i * width, (i + 1) * width);
        let around = bytes[from / 8..to.div_ceil(8)].iter().rev().fold(0, |n, &b| n << 8 | u128::from(b));
        (around >> (from % 8) & ((1 << width) - 1)) as u64
    };
    (0..count).map(field)
}

/// Runs of one number and groups of eight bit fields, `count` numbers in all.
fn hybrid(mut bytes: &[u8], width: u32, count: usize) -> Result<Vec<u32>, String> {
    let short = "a page ends within its levels or places";
    if width > 32 {
        return Err(format!("places of {width} bits are claimed; at most 32 are possible"));
    }
    let mut out = Vec::new();
    while out.len() < count {
        let (head, length) = varint(bytes).ok_or(short)?;
        bytes = &bytes[length..];
        let left = count - out.len();
        let units = usize::try_from(head >> 1).unwrap_or(usize::MAX);
        if head & 1 == 1 {
            let length = units.saturating_mul(width as usize);
            // Some writers leave away what the last group does not need.
            let here = bytes.get(..length.min(bytes.len())).unwrap_or(bytes);
            let fields = units.saturating_mul(8).min(left);
            if (fields.saturating_mul(width as usize)).div_ceil(8) > here.len() {
                return Err(short.into());
            }
            out.extend(packed(here, width, fields).map(|n| n as u32));
            bytes = &bytes[here.len()..];
        } else {
            let (value, rest) = bytes.split_at_checked(width.div_ceil(8) as usize).ok_or(short)?;
            let value = value.iter().rev().fold(0u32, |n, &b| n << 8 | u32::from(b));
            out.resize(out.len() + units.min(left), value);
            bytes = rest;
        }
    }
    Ok(out)
}

/// Differences in blocks: size of a block, miniblocks a block, count, first value; then a block each the least
/// difference, the widths of its miniblocks, and what the differences exceed the least by.
fn delta(bytes: &[u8], count: usize) -> Result<Vec<u64>, String> {
    let short = "a page ends within its differences";
    let mut rest = bytes;
    let number = |rest: &mut &[u8]| -> Result<u64, String> {
        let (value, length) = varint(rest).ok_or(short)?;
        *rest = &rest[length..];
        Ok(value)
    };
    let (block, miniblocks) = (number(&mut rest)?, number(&mut rest)?);
    let (claimed, first) = (number(&mut rest)?, zigzag(number(&mut rest)?));
    if block == 0
        || miniblocks == 0
        || miniblocks > 512
        || block % miniblocks != 0
        || block / miniblocks % 8 != 0
        || block > 1 << 20
    {
        return Err(format!("blocks of {block} differences in {miniblocks} parts are claimed"));
    }
    if claimed != count as u64 {
        return Err(format!("{claimed} differences are claimed for {count} numbers"));
    }
    let (miniblocks, each) = (miniblocks as usize, (block / miniblocks) as usize);
    let (mut out, mut last) = (Vec::new(), first);
    if count > 0 {
        out.push(last as u64);
    }
    while out.len() < count {
        let least = zigzag(number(&mut rest)?);
        let (widths, behind) = rest.split_at_checked(miniblocks).ok_or(short)?;
        rest = behind;
        for &width in widths {
            if out.len() == count {
                break; // what is not needed is not written
            }
            if width > 64 {
                return Err(format!("differences of {width} bits are claimed"));
            }
            let (here, behind) = rest.split_at_checked(each / 8 * usize::from(width)).ok_or(short)?;
            rest = behind;
            for excess in packed(here, u32::from(width), each.min(count - out.len())) {
                last = last.wrapping_add(least).wrapping_add(excess as i64);
                out.push(last as u64);
            }
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_and_groups_of_eight() {
        // Five times 3; then 0 1 2 3 0 1 2 3 in two bits each.
        let bytes = [5 << 1, 3, 3, 0b11_10_01_00, 0b11_10_01_00];
        assert_eq!(hybrid(&bytes, 2, 13).unwrap(), [3, 3, 3, 3, 3, 0, 1, 2, 3, 0, 1, 2, 3]);
        assert_eq!(hybrid(&bytes, 2, 7).unwrap().len(), 7);
        assert!(hybrid(&bytes, 2, 14).is_err());
        assert!(hybrid(&bytes, 33, 1).is_err());
        // A run as long as numbers go gives what is asked for, and no more.
        let endless = [0xfe, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 1, 1];
        assert_eq!(hybrid(&endless, 1, 3).unwrap(), [1, 1, 1]);
    }

    #[test]
    fn bit_fields_cross_bytes() {
        // 1, 2, .. in eleven bits each, by the sum of their places.
        let sum: u128 = (0..8).map(|i| (i + 1) << (11 * i)).sum();
        assert!(packed(&sum.to_le_bytes()[..11], 11, 8).eq(1..=8));
        let wide = [u64::MAX, 7].map(u64::to_le_bytes).concat();
        assert!(packed(&wide, 64, 2).eq([u64::MAX, 7]));
    }

    #[test]
    fn differences() {
        // 10 8 6 9: steps -2 -2 3, the least -2, above it 0 0 5 in three bits of 32 places.
        let head = [128, 1, 4, 4, 20];
        let block = [&[3, 3, 0, 0, 0][..], &[0b0100_0000, 1], &[0; 10]].concat();
        let bytes = [&head[..], &block].concat();
        assert_eq!(delta(&bytes, 4).unwrap(), [10, 8, 6, 9]);
        assert!(delta(&bytes[..bytes.len() - 1], 4).is_err());
        assert!(delta(&bytes, 5).unwrap_err().contains("4 differences are claimed for 5 numbers"));
        assert!(delta(&[0, 1, 4, 20], 4).unwrap_err().contains("blocks of 0 differences"));
        assert_eq!(delta(&[128, 1, 4, 0, 0], 0).unwrap(), []);
    }

    #[test]
    fn bytes_apart() {
        let numbers = [0x0403_0201, 0x1413_1211];
        assert_eq!(split(&[1, 0x11, 2, 0x12, 3, 0x13, 4, 0x14], 2, 4).unwrap(), numbers);
        assert_eq!(plain(&[1, 2, 3, 4, 0x11, 0x12, 0x13, 0x14], 2, 4).unwrap(), numbers);
        assert!(plain(&[0; 7], 1, 8).is_err() && split(&[0; 7], usize::MAX, 8).is_err());
    }
}
