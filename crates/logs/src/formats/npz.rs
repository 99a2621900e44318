//! Reads NumPy arrays (.npz) as a table of named columns.
//!
//! `arrays` defines the columns of an array. A .npz is a zip of .npy files, stored or deflated. Only the variants that NumPy
//! writes are read. Arrays are decompressed block by block. The sizes that the zip states are not trusted: its files must not
//! overlap, and all arrays together must stay within the [`Budget`] of the file and have at most [`MAX_CELLS`] numbers. An array
//! with numbers of an unknown type gets a note.

use std::io::Read;

use gate::budget::Budget;

use crate::Error;
use crate::formats::arrays::Array;
use crate::formats::registered::{self, LogReader};
use crate::table::{MAX_CELLS, Table};

/// Largest size of all decompressed arrays together, bytes.
const MAX_ARRAY_BYTES: usize = 8 * MAX_CELLS;

/// Number of bytes of an array that are decompressed at a time.
const BYTES_PER_BLOCK: usize = 1 << 16;

/// Largest size of the head of an array, bytes. NumPy writes some hundred bytes.
const MAX_HEAD_BYTES: usize = 1 << 16;

/// Reads the arrays of a file within a budget. The columns of a single .npy are c1, c2, ..
pub(crate) fn read(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
    let at = |message: String| Error::at(file, 0, message);
    let (mut arrays, mut notes) = (Vec::new(), Vec::new());
    let mut numbers = 0;
    let entries = entries(bytes).map_err(at)?;
    let members: Vec<&str> = entries.iter().map(|entry| entry.name.as_str()).collect();
    match registered::of_members(&members) {
        Some(LogReader::Whole(read)) => return read(file, bytes, budget),
        Some(LogReader::Absent { what, .. }) => return Err(at(what.into())),
        _ => {}
    }
    for entry in entries {
        let Some(key) = entry.name.strip_suffix(".npy") else { continue };
        let found = content(&entry).and_then(|content| array(content, budget));
        let found = match found.map_err(|e| at(format!("array `{key}`: {e}")))? {
            ArrayContent::Numbers(array) => Some(array),
            ArrayContent::Nothing => None,
            ArrayContent::Unread(kind) => {
                notes.push(format!("array `{key}` holds `{kind}`, which is not read: save it as float64"));
                None
            }
        };
        // The limit holds for all arrays together, and is checked before they become columns.
        if let Some(array) = found {
            numbers += array.values.len();
            if numbers > MAX_CELLS {
                return Err(at(format!(
                    "more than {MAX_CELLS} numbers with array `{key}`; keep the signals of the robot"
                )));
            }
            arrays.push((key.to_string(), array));
        }
    }
    let mut table = Table::from_arrays(file, arrays).map_err(|e| {
        if notes.is_empty() { e } else { Error::at(file, 0, format!("{}; {}", e.message(), notes.join("; "))) }
    })?;
    table.notes.extend(notes);
    Ok(table)
}

fn number(bytes: &[u8], at: usize, len: usize) -> Result<usize, String> {
    let end = at.checked_add(len).ok_or("a length is damaged")?;
    let bytes = bytes.get(at..end).ok_or("the zip ends too early")?;
    Ok(bytes.iter().rev().fold(0, |n, &b| n << 8 | usize::from(b)))
}

/// A file in the zip.
struct ZipEntry<'a> {
    name: String,
    method: usize,
    packed: &'a [u8],
    /// Decompressed size that the zip states, bytes.
    size: usize,
}

/// All files in a zip, from its central directory.
///
/// Fails if files overlap, or if their sizes exceed [`MAX_ARRAY_BYTES`] in total.
fn entries(bytes: &[u8]) -> Result<Vec<ZipEntry<'_>>, String> {
    // The record at the end of the directory has the number of files, and the position of their records.
    let end = bytes.windows(4).rposition(|w| w == b"PK\x05\x06").ok_or("the zip has no directory: cut short?")?;
    let count = number(bytes, end + 10, 2)?;
    let mut at = number(bytes, end + 16, 4)?;
    let (mut out, mut places, mut all) = (Vec::new(), Vec::new(), 0usize);
    for _ in 0..count {
        if bytes.get(at..at.saturating_add(4)) != Some(b"PK\x01\x02") {
            return Err("the directory of the zip is damaged".into());
        }
        let method = number(bytes, at + 10, 2)?;
        let (packed, size) = (number(bytes, at + 20, 4)?, number(bytes, at + 24, 4)?);
        let (name, extra, comment) =
            (number(bytes, at + 28, 2)?, number(bytes, at + 30, 2)?, number(bytes, at + 32, 2)?);
        let local = number(bytes, at + 42, 4)?;
        // Each record is followed by name, extra field and comment. The file itself is after its local head.
        let text = bytes.get(at + 46..at + 46 + name).ok_or("the zip ends too early")?;
        let text = String::from_utf8_lossy(text).into_owned();
        let start = local + 30 + number(bytes, local + 26, 2)? + number(bytes, local + 28, 2)?;
        let content =
            start.checked_add(packed).and_then(|end| bytes.get(start..end)).ok_or("the zip ends too early")?;
        all = all.saturating_add(size);
        if all > MAX_ARRAY_BYTES {
            return Err(format!("with `{text}` its arrays claim {all} bytes; at most {MAX_ARRAY_BYTES} are read"));
        }
        places.push((local, start + packed));
        out.push(ZipEntry { name: text, method, packed: content, size });
        at += 46 + name + extra + comment;
    }
    // If files overlap, the same bytes could be decompressed many times.
    places.sort_unstable();
    if places.windows(2).any(|pair| pair[1].0 < pair[0].1) {
        return Err("the files in the zip overlap: it is damaged, or made to unpack without end".into());
    }
    Ok(out)
}

/// A reader that decompresses a file in the zip.
fn content<'a>(entry: &ZipEntry<'a>) -> Result<Box<dyn Read + 'a>, String> {
    match entry.method {
        0 => Ok(Box::new(entry.packed)),
        8 => Ok(Box::new(flate2::read::DeflateDecoder::new(entry.packed).take(entry.size as u64))),
        other => Err(format!("compression method {other} of zip is not read; save with numpy.savez")),
    }
}

/// The content of a .npy.
pub(super) enum ArrayContent {
    Numbers(Array),
    /// Texts, booleans, or an empty array.
    Nothing,
    /// Numbers or objects of a type that cannot be read: the name of the type.
    Unread(String),
}

/// The number types that can be read.
const NUMBER_TYPES: [&str; 8] = ["<f8", "<f4", "<i8", "<u8", "<i4", "<i2", ">f8", ">f4"];

/// Number of copies of the numbers in memory at the same time: the array and the columns.
const COPIES_OF_AN_ARRAY: usize = 2;

/// Reads bytes until `out` is full or the data ends. Returns the number of bytes.
fn filled(reader: &mut dyn Read, out: &mut [u8]) -> Result<usize, String> {
    let mut count = 0;
    while count < out.len() {
        match reader.read(&mut out[count..]).map_err(|e| format!("the zip is damaged: {e}"))? {
            0 => break,
            read => count += read,
        }
    }
    Ok(count)
}

pub(super) fn array(mut content: Box<dyn Read + '_>, budget: &mut Budget) -> Result<ArrayContent, String> {
    let mut start = [0; 12];
    filled(&mut content, &mut start[..10])?;
    if !start.starts_with(b"\x93NUMPY") {
        return Err("this is no array of NumPy".into());
    }
    let mut length = number(&start, 8, 2)?;
    if start[6] != 1 {
        filled(&mut content, &mut start[10..])?;
        length = number(&start, 8, 4)?;
    }
    let mut header = vec![0; length.min(MAX_HEAD_BYTES)];
    if filled(&mut content, &mut header)? < length {
        return Err("the header is cut short".into());
    }
    let header = String::from_utf8_lossy(&header);
    let field = |key: &str| header.split(key).nth(1).map(|rest| rest.trim_start_matches([' ', ':', '\'', '"']));
    let kind: String = field("descr").unwrap_or("").chars().take_while(|c| *c != '\'' && *c != '"').collect();
    let fortran = field("fortran_order").is_some_and(|t| t.starts_with("True"));
    let shape = field("shape").and_then(|t| t.strip_prefix('(')).and_then(|t| t.split(')').next()).unwrap_or("");
    let lengths = shape.split(',').map(str::trim).filter(|n| !n.is_empty());
    let shape: Vec<usize> =
        lengths.map(str::parse).collect::<Result<_, _>>().map_err(|_| format!("its shape is absurd: ({shape})"))?;
    let count = shape.iter().try_fold(1usize, |a, &b| a.checked_mul(b)).filter(|&n| n <= MAX_CELLS);
    let count = count.ok_or("its shape is absurd")?;
    if count == 0 {
        return Ok(ArrayContent::Nothing); // shapes such as (0,), (0, 7), also (10^12, 0)
    }
    if !NUMBER_TYPES.contains(&kind.as_str()) {
        // The type of a structured array is a list of fields.
        if kind.starts_with('[') || kind.contains('V') {
            return Ok(ArrayContent::Unread("records".into()));
        }
        // Texts and booleans are no signals.
        let is_number = kind.contains(['f', 'i', 'u', 'c', 'O', 'm', 'M']);
        return Ok(if is_number { ArrayContent::Unread(kind) } else { ArrayContent::Nothing });
    }
    budget.draw(count.saturating_mul(COPIES_OF_AN_ARRAY * size_of::<f64>()))?;
    let data = &mut content;
    let values = match kind.as_str() {
        "<f8" => take(data, count, f64::from_le_bytes)?,
        "<f4" => take(data, count, |b| f64::from(f32::from_le_bytes(b)))?,
        "<i8" => take(data, count, |b| i64::from_le_bytes(b) as f64)?,
        "<u8" => take(data, count, |b| u64::from_le_bytes(b) as f64)?,
        "<i4" => take(data, count, |b| f64::from(i32::from_le_bytes(b)))?,
        "<i2" => take(data, count, |b| f64::from(i16::from_le_bytes(b)))?,
        ">f8" => take(data, count, f64::from_be_bytes)?,
        _ => take(data, count, |b| f64::from(f32::from_be_bytes(b)))?,
    };
    let values = match shape[..] {
        [n, k] if fortran => (0..n * k).map(|i| values[i % k * n + i / k]).collect(),
        _ => values,
    };
    Ok(ArrayContent::Numbers(Array { shape, values }))
}

/// Reads `count` numbers of N bytes each. The memory grows while the numbers are read.
fn take<const N: usize>(
    content: &mut dyn Read,
    count: usize,
    read: impl Fn([u8; N]) -> f64,
) -> Result<Vec<f64>, String> {
    let mut piece = [0; BYTES_PER_BLOCK];
    let mut values = Vec::new();
    while values.len() < count {
        let wanted = (N * (count - values.len())).min(BYTES_PER_BLOCK / N * N);
        let found = filled(content, &mut piece[..wanted])?;
        if found < wanted {
            return Err("the data are cut short".into());
        }
        if values.capacity() - values.len() < wanted / N {
            // Doubles the memory, up to the size of the array.
            values.reserve_exact(values.len().max(wanted / N).min(count - values.len()));
        }
        values.extend(piece[..wanted].as_chunks::<N>().0.iter().map(|number| read(*number)));
    }
    Ok(values)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::formats) fn npy(descr: &str, shape: &str, fortran: &str, data: &[u8]) -> Vec<u8> {
        let header = format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}\n");
        let mut out = b"\x93NUMPY\x01\x00".to_vec();
        out.extend((header.len() as u16).to_le_bytes());
        out.extend(header.as_bytes());
        out.extend(data);
        out
    }

    fn zip(files: &[(&str, Vec<u8>, bool)]) -> Vec<u8> {
        use std::io::Write;
        let (mut out, mut directory) = (Vec::new(), Vec::new());
        for (name, content, deflate) in files {
            let packed = if *deflate {
                let mut e = flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::fast());
                e.write_all(content).unwrap();
                e.finish().unwrap()
            } else {
                content.clone()
            };
            let offset = out.len() as u32;
            let mut common = vec![0u8; 22];
            common[4] = if *deflate { 8 } else { 0 };
            common[14..18].copy_from_slice(&(packed.len() as u32).to_le_bytes());
            common[18..22].copy_from_slice(&(content.len() as u32).to_le_bytes());
            let names = [(name.len() as u16).to_le_bytes(), [0, 0]].concat();
            out.extend(b"PK\x03\x04");
            out.extend(&common);
            out.extend(&names);
            out.extend(name.as_bytes());
            out.extend(&packed);
            directory.extend(b"PK\x01\x02\0\0");
            directory.extend(&common);
            directory.extend(&names);
            directory.extend([0; 10]);
            directory.extend(offset.to_le_bytes());
            directory.extend(name.as_bytes());
        }
        let start = out.len() as u32;
        out.extend(&directory);
        out.extend(b"PK\x05\x06\0\0\0\0");
        out.extend((files.len() as u16).to_le_bytes());
        out.extend((files.len() as u16).to_le_bytes());
        out.extend((directory.len() as u32).to_le_bytes());
        out.extend(start.to_le_bytes());
        out.extend([0, 0]);
        out
    }

    pub(in crate::formats) fn doubles(x: &[f64]) -> Vec<u8> {
        x.iter().flat_map(|x| x.to_le_bytes()).collect()
    }

    #[test]
    fn arrays_become_columns() {
        let q = npy("<f8", "(3, 2)", "False", &doubles(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
        let dq = npy("<f8", "(3, 2)", "True", &doubles(&[1.0, 3.0, 5.0, 2.0, 4.0, 6.0]));
        let fs = npy("<i8", "()", "False", &100i64.to_le_bytes());
        let name = npy("<U4", "()", "False", &[0; 16]);
        let file = zip(&[
            ("positions.npy", q, false),
            ("velocities.npy", dq, true),
            ("frequency.npy", fs, true),
            ("robot.npy", name, false),
        ]);
        let table = Table::from_bytes("log.npz", &file).unwrap();
        assert_eq!(table.header, ["positions_1", "positions_2", "velocities_1", "velocities_2", "t"]);
        assert_eq!(table.columns[1], [2.0, 4.0, 6.0]);
        assert_eq!(table.columns[3], table.columns[1]);
        assert_eq!(table.columns[4], [0.0, 0.01, 0.02]);
    }

    #[test]
    fn an_array_is_unpacked_within_the_budget_of_its_file() {
        let zeros = |rows: usize| npy("<f8", &format!("({rows}, 2)"), "False", &vec![0; 16 * rows]);
        let claim = npy("<f8", "(60000000, 2)", "False", &vec![0; 1 << 20]);
        let many: Vec<(String, Vec<u8>, bool)> = (0..40).map(|k| (format!("q{k}.npy"), zeros(100_000), true)).collect();
        let many: Vec<(&str, Vec<u8>, bool)> = many.iter().map(|(n, c, d)| (n.as_str(), c.clone(), *d)).collect();
        for file in [zip(&[("q.npy", claim, true)]), zip(&many)] {
            let message = Table::from_bytes("log.npz", &file).unwrap_err().to_string();
            assert!(message.contains("64 times the file"), "{message}");
        }
        let table = Table::from_bytes("log.npz", &zip(&[("q.npy", zeros(1_000_000), true)])).unwrap();
        assert_eq!(table.rows(), 1_000_000);
    }

    #[test]
    fn kinds_of_numbers_that_are_not_read_are_told() {
        let q = npy("<f8", "(2,)", "False", &doubles(&[1.0, 2.0]));
        let big = npy(">f8", "(2,)", "False", &[1.0f64.to_be_bytes(), 2.5f64.to_be_bytes()].concat());
        let half = npy("<f2", "(2,)", "False", &[0; 4]);
        let table = zip(&[("q1.npy", q, false), ("dq1.npy", big, false), ("tau1.npy", half, false)]);
        let table = Table::from_bytes("log.npz", &table).unwrap();
        assert_eq!(table.columns[1], [1.0, 2.5]);
        assert_eq!(table.notes, ["array `tau1` holds `<f2`, which is not read: save it as float64"]);
        // A structured array with named fields. NumPy writes its type as a list.
        let fields = npy("", "(2,)", "False", &[0; 32]);
        let text = String::from_utf8_lossy(&fields).replace("'',", "[('a', '<f8'), ('b', '<f8')],");
        let head = text.find('{').unwrap();
        let length = (text.rfind('\n').unwrap() + 1 - head) as u16;
        let fields = [b"\x93NUMPY\x01\0", &length.to_le_bytes()[..], &text.as_bytes()[head..]].concat();
        let q = npy("<f8", "(2,)", "False", &doubles(&[1.0, 2.0]));
        let table = Table::from_bytes("log.npz", &zip(&[("q1.npy", q, false), ("tau.npy", fields, false)])).unwrap();
        assert_eq!(table.notes, ["array `tau` holds `records`, which is not read: save it as float64"]);
    }

    #[test]
    fn refusals() {
        let file = zip(&[("q.npy", npy("<f8", "(30, 2)", "False", &doubles(&[1.0])), false)]);
        let message = |bytes: &[u8]| Table::from_bytes("log.npz", bytes).unwrap_err().to_string();
        assert!(message(&file).contains("array `q`: the data are cut short"), "{}", message(&file));
        assert!(message(&file[..file.len() - 30]).contains("no directory"));
        assert!(message(&npy("<f8", "(1,)", "False", &doubles(&[1.0]))).contains("one array without names"));
        for cut in 0..file.len() {
            let _ = Table::from_bytes("log.npz", &file[..cut]);
        }
    }

    #[test]
    fn claims_are_not_believed() {
        let dt = npy("<f8", "()", "False", &doubles(&[0.01]));
        let empty = npy("<f8", "(1000000000000, 0)", "False", &[]);
        let message = |bytes: &[u8]| Table::from_bytes("log.npz", bytes).unwrap_err().to_string();
        let file = zip(&[("q.npy", empty, false), ("dt.npy", dt.clone(), false)]);
        assert!(message(&file).contains("no array holds samples"), "{}", message(&file));
        let mut file = zip(&[("a.npy", dt.clone(), false), ("b.npy", dt, false)]);
        // The second entry of the directory refers to the first file, so the files overlap.
        let last = file.windows(4).rposition(|w| w == b"PK\x01\x02").unwrap();
        file[last + 42..last + 46].fill(0);
        assert!(message(&file).contains("overlap"), "{}", message(&file));
        let wide = npy("<i2", "(2, 10001)", "False", &[0; 2 * 2 * 10_001]);
        assert!(message(&zip(&[("q.npy", wide, true)])).contains("more than 10000 columns with array `q`"));
    }

    #[test]
    fn unequal_lengths_are_told() {
        let of = |n: usize| npy("<f8", &format!("({n},)"), "False", &doubles(&vec![1.0; n]));
        let file = zip(&[("t.npy", of(60), false), ("q1.npy", of(60), false), ("tau1.npy", of(59), false)]);
        let table = Table::from_bytes("log.npz", &file).unwrap();
        let note = "array `tau1` has 59 rows where `t` has 60: it is not used; signals of one run have one length";
        assert_eq!(table.notes, [note]);
        let error = crate::Columns::find(&table, &["q1".into()], &Default::default()).unwrap_err();
        assert!(error.message().contains(note), "{error}");
    }
}
