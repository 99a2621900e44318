//! Reads arrays of a MATLAB file (.mat, version 5, the default of `save`, plain or compressed) as a table of named columns.
//!
//! A file has a head of 128 bytes and then elements. An element has a type and a length (four bytes each), data, and zeros up to
//! a multiple of eight bytes. A short element has type and length in two bytes each, and four bytes of data. A matrix is an
//! element that contains elements: flags with its class, dimensions, name, and numbers column by column. A field of a 1 x 1
//! structure is an array whose name is its path, for example `log.q`; a first component that all paths have in common is omitted.
//! `arrays` defines the columns of an array; an array of shape (joints, samples) is transposed. Elements without plain numbers
//! get a note. All decompressed bytes are taken from the [`Budget`].

use std::io::Read;

use flate2::read::ZlibDecoder;
use gate::budget::Budget;

use logs::Array;
use logs::Error;
use logs::Table;
use logs::reading::MAX_CELLS;

/// Number of bytes before the first element.
const HEAD_BYTES: usize = 128;
/// Largest depth of nested structures.
const MAX_DEPTH: usize = 8;
/// Largest number of arrays in a file.
const MAX_ARRAYS: usize = 10_000;

/// The type of an element that is a matrix. `COMPRESSED`: type of a compressed element.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// Reads the arrays of a file. The memory of decompressed bytes is taken from `budget`.
pub(crate) fn read(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
    let at = |message: String| Error::at(file, 0, message);
    match bytes.get(HEAD_BYTES - 2..HEAD_BYTES) {
        Some(b"IM") => {}
        Some(b"MI") => {
            return Err(at("it was written by a machine of the other byte order: load and save it again".into()));
        }
        _ => return Err(at("the head of a .mat of version 5 is cut short: copy it again".into())),
    }
    let mut found = Arrays { arrays: vec![], notes: vec![], numbers: 0, budget };
    let mut rest = &bytes[HEAD_BYTES..];
    while !rest.is_empty() {
        let (kind, data, next) = element(rest).map_err(at)?;
        found.top(kind, data).map_err(at)?;
        rest = next;
    }
    let Arrays { arrays, notes, .. } = found;
    let mut table = Table::from_arrays(file, turned(without_shared_path(arrays))).map_err(|e| {
        if notes.is_empty() { e } else { Error::at(file, 0, format!("{}; {}", e.message(), notes.join("; "))) }
    })?;
    table.notes.extend(notes);
    Ok(table)
}

/// The type and the data of the first element, and the bytes after the element.
fn element(bytes: &[u8]) -> Result<(u32, &[u8], &[u8]), String> {
    let cut = || "an element is cut short: the file is damaged or incomplete".to_string();
    let word =
        |at: usize| bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes).ok_or_else(cut);
    let kind = word(0)?;
    let (kind, start, length): (u32, usize, usize) = match kind >> 16 {
        0 => (kind, 8, word(4)? as usize),
        length => (kind & 0xffff, 4, length as usize),
    };
    let end = start.checked_add(length).filter(|end| *end <= bytes.len()).ok_or_else(cut)?;
    // A short element (type and length in two bytes each) ends after eight bytes. Compressed elements have no padding.
    let next = match kind {
        COMPRESSED => end,
        _ => end.next_multiple_of(8).min(bytes.len()),
    };
    Ok((kind, &bytes[start..end], &bytes[next..]))
}

struct Arrays<'a> {
    arrays: Vec<(String, Array)>,
    notes: Vec<String>,
    numbers: usize,
    budget: &'a mut Budget,
}

impl Arrays<'_> {
    /// Reads one element at the top level of the file.
    fn top(&mut self, kind: u32, data: &[u8]) -> Result<(), String> {
        match kind {
            MATRIX => self.matrix(data, "", 0),
            COMPRESSED => {
                let mut unpacked = Vec::new();
                // One byte more than the budget is read, so that too much data is noticed.
                let room = self.budget.left() as u64 + 1;
                let read = ZlibDecoder::new(data).take(room).read_to_end(&mut unpacked);
                read.map_err(|e| format!("a packed array cannot be unpacked: {e}"))?;
                self.budget.draw(unpacked.len())?;
                let (kind, data, _) = element(&unpacked)?;
                if kind == MATRIX { self.matrix(data, "", 0) } else { Ok(()) }
            }
            _ => Ok(()),
        }
    }

    /// Reads an array or a structure. `path`: names of the structures around it.
    fn matrix(&mut self, data: &[u8], path: &str, depth: usize) -> Result<(), String> {
        if data.is_empty() {
            return Ok(()); // an empty field
        }
        let (_, flags, rest) = element(data)?;
        let (_, dimensions, rest) = element(rest)?;
        let (_, name, rest) = element(rest)?;
        let class = flags.first().copied().unwrap_or(0);
        let shape: Vec<usize> = words(dimensions).map(|n| n as usize).collect();
        let own = String::from_utf8_lossy(name).into_owned();
        let path = if path.is_empty() { own } else { path.to_string() };
        match class {
            6..=15 => self.array(&path, shape, flags.get(1).copied().unwrap_or(0), rest),
            2 => self.structure(&path, &shape, rest, depth),
            _ => {
                let kind = match class {
                    1 => "cells",
                    3 | 17 => "an object, as a timeseries or a table",
                    4 => return Ok(()), // a text is no signal
                    5 => "a sparse matrix",
                    16 => "a function",
                    _ => "something unknown",
                };
                self.notes.push(format!("`{path}` holds {kind}, which is not read: save its numbers as arrays"));
                Ok(())
            }
        }
    }

    fn structure(&mut self, path: &str, shape: &[usize], rest: &[u8], depth: usize) -> Result<(), String> {
        if shape.iter().product::<usize>() != 1 {
            self.notes.push(format!("`{path}` is an array of structures, which is not read: save one of them"));
            return Ok(());
        }
        if depth == MAX_DEPTH {
            return Err(format!("more than {MAX_DEPTH} structures stand in one another at `{path}`"));
        }
        let (_, length, rest) = element(rest)?;
        let (_, names, mut rest) = element(rest)?;
        let length = words(length).next().unwrap_or(0) as usize;
        if length == 0 {
            return Err(format!("the names of the fields of `{path}` have no length"));
        }
        for name in names.chunks(length) {
            let name = String::from_utf8_lossy(name.split(|b| *b == 0).next().unwrap_or(name)).into_owned();
            let (kind, data, next) = element(rest)?;
            if kind == MATRIX {
                self.matrix(data, &format!("{path}.{name}"), depth + 1)?;
            }
            rest = next;
        }
        Ok(())
    }

    fn array(&mut self, path: &str, shape: Vec<usize>, flags: u8, rest: &[u8]) -> Result<(), String> {
        const COMPLEX: u8 = 0x08;
        let (kind, data, _) = element(rest)?;
        if flags & COMPLEX != 0 {
            self.notes.push(format!("array `{path}` is complex: it is not used"));
            return Ok(());
        }
        let count = shape.iter().try_fold(1usize, |all, n| all.checked_mul(*n)).unwrap_or(usize::MAX);
        self.numbers = self.numbers.saturating_add(count);
        if self.numbers > MAX_CELLS || self.arrays.len() == MAX_ARRAYS {
            return Err(format!("more than {MAX_CELLS} numbers with array `{path}`; keep the signals of the robot"));
        }
        // The numbers are in memory three times: as stored (by columns), transposed to rows, and as columns of the table.
        self.budget.draw(count.saturating_mul(3 * size_of::<f64>()))?;
        let values = numbers(kind, data).filter(|values| values.len() == count);
        let values =
            values.ok_or_else(|| format!("array `{path}` does not hold the {count} numbers that it claims"))?;
        self.arrays.push((path.to_string(), Array { shape, values }));
        Ok(())
    }
}

fn words(bytes: &[u8]) -> impl Iterator<Item = u32> {
    bytes.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b))
}

/// The numbers of an element. MATLAB may store them in a smaller type than the class of the array.
fn numbers(kind: u32, data: &[u8]) -> Option<Vec<f64>> {
    fn of<const N: usize>(data: &[u8], number: impl Fn([u8; N]) -> f64) -> Vec<f64> {
        data.as_chunks::<N>().0.iter().map(|b| number(*b)).collect()
    }
    Some(match kind {
        1 => of(data, |b| f64::from(i8::from_le_bytes(b))),
        2 => of(data, |b| f64::from(u8::from_le_bytes(b))),
        3 => of(data, |b| f64::from(i16::from_le_bytes(b))),
        4 => of(data, |b| f64::from(u16::from_le_bytes(b))),
        5 => of(data, |b| f64::from(i32::from_le_bytes(b))),
        6 => of(data, |b| f64::from(u32::from_le_bytes(b))),
        7 => of(data, |b| f64::from(f32::from_le_bytes(b))),
        9 => of(data, f64::from_le_bytes),
        12 => of(data, |b| i64::from_le_bytes(b) as f64),
        13 => of(data, |b| u64::from_le_bytes(b) as f64),
        _ => return None,
    })
}

/// Removes the first component of all names as long as all names have the same one.
fn without_shared_path(mut arrays: Vec<(String, Array)>) -> Vec<(String, Array)> {
    while let Some((start, _)) = arrays.first().and_then(|(name, _)| name.split_once('.')) {
        let start = format!("{start}.");
        if !arrays.iter().all(|(name, _)| name.starts_with(&start)) {
            break;
        }
        arrays.iter_mut().for_each(|(name, _)| *name = name[start.len()..].to_string());
    }
    arrays
}

/// Transposes arrays such that each row is a sample. The number of samples is assumed to be the largest dimension of all
/// matrices.
fn turned(arrays: Vec<(String, Array)>) -> Vec<(String, Array)> {
    let longest = arrays.iter().filter(|(_, a)| a.shape.len() == 2).filter_map(|(_, a)| a.shape.iter().max()).max();
    let samples = longest.copied().unwrap_or(0);
    let turn = |(name, Array { shape, values }): (String, Array)| {
        let array = match shape[..] {
            [1, 1] => Array { shape: vec![], values },
            [n, 1] | [1, n] => Array { shape: vec![n], values },
            // An array of shape (joints, samples) is stored by columns, so its numbers are already in the order of rows of
            // samples.
            [joints, n] if n == samples && joints != samples => Array { shape: vec![n, joints], values },
            [n, k] => {
                let turned = (0..n).flat_map(|r| (0..k).map(move |c| c * n + r)).map(|at| values[at]).collect();
                Array { shape: vec![n, k], values: turned }
            }
            _ => Array { shape, values },
        };
        (name, array)
    };
    arrays.into_iter().map(turn).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element_of(kind: u32, data: &[u8]) -> Vec<u8> {
        let mut all = [&kind.to_le_bytes()[..], &(data.len() as u32).to_le_bytes(), data].concat();
        all.resize(all.len().next_multiple_of(8), 0);
        all
    }

    fn words_of(numbers: &[u32]) -> Vec<u8> {
        numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
    }

    fn matrix_of(name: &str, class: u32, shape: [u32; 2], rest: &[u8]) -> Vec<u8> {
        let parts = [
            element_of(6, &words_of(&[class, 0])),
            element_of(5, &words_of(&shape)),
            element_of(1, name.as_bytes()),
            rest.to_vec(),
        ];
        element_of(MATRIX, &parts.concat())
    }

    fn doubles(name: &str, shape: [u32; 2], values: &[f64]) -> Vec<u8> {
        let data: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        matrix_of(name, 6, shape, &element_of(9, &data))
    }

    fn file(elements: &[Vec<u8>]) -> Vec<u8> {
        let mut head = b"MATLAB 5.0 MAT-file".to_vec();
        head.resize(HEAD_BYTES - 4, b' ');
        head.extend_from_slice(&[0, 1, b'I', b'M']);
        [head, elements.concat()].concat()
    }

    #[test]
    fn arrays_lie_as_they_may() {
        let upright = [doubles("t", [3, 1], &[0.0, 1.0, 2.0]), doubles("q", [3, 2], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])];
        let lying = [doubles("t", [1, 3], &[0.0, 1.0, 2.0]), doubles("q", [2, 3], &[1.0, 4.0, 2.0, 5.0, 3.0, 6.0])];
        for elements in [upright, lying] {
            let table = Table::from_bytes("log.mat", &file(&elements)).unwrap();
            assert_eq!(table.header, ["t", "q_1", "q_2"]);
            assert_eq!(table.columns, [[0.0, 1.0, 2.0], [1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        }
    }

    #[test]
    fn fields_packed_arrays_and_small_numbers() {
        use std::io::Write as _;
        let small = matrix_of("", 6, [3, 1], &element_of(2, &[7, 8, 9]));
        let names = [element_of(5, &words_of(&[8])), element_of(1, b"t\0\0\0\0\0\0\0q\0\0\0\0\0\0\0")].concat();
        let fields = [names, doubles("", [3, 1], &[0.0, 1.0, 2.0]), small].concat();
        let packed = {
            let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
            zlib.write_all(&matrix_of("log", 2, [1, 1], &fields)).unwrap();
            let data = zlib.finish().unwrap();
            [&COMPRESSED.to_le_bytes()[..], &(data.len() as u32).to_le_bytes(), &data].concat()
        };
        let whole = file(&[packed]);
        let table = Table::from_bytes("log.mat", &whole).unwrap();
        assert_eq!((table.header.join(" "), &table.columns[1]), ("t q".into(), &vec![7.0, 8.0, 9.0]));
        for cut in HEAD_BYTES..whole.len() {
            assert!(Table::from_bytes("log.mat", &whole[..cut]).is_err(), "{cut}");
        }
    }

    #[test]
    fn what_is_no_array_is_told() {
        let odd = [
            doubles("t", [2, 1], &[0.0, 1.0]),
            matrix_of("c", 1, [1, 1], &[]),
            matrix_of("o", 17, [1, 1], &[]),
            matrix_of("s", 2, [2, 1], &[]),
        ];
        let notes = Table::from_bytes("log.mat", &file(&odd)).unwrap().notes.join("\n");
        for wanted in ["`c` holds cells", "`o` holds an object, as a timeseries", "`s` is an array of structures"] {
            assert!(notes.contains(wanted), "{notes}");
        }
        let claims = [doubles("q", [1 << 20, 1 << 20], &[1.0])];
        assert!(
            Table::from_bytes("log.mat", &file(&claims)).unwrap_err().to_string().contains("numbers with array `q`")
        );
        let short = [doubles("q", [3, 1], &[1.0])];
        assert!(Table::from_bytes("log.mat", &file(&short)).unwrap_err().to_string().contains("does not hold the 3"));
    }
}
