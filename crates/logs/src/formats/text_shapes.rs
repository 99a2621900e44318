//! Reads texts that are not a plain table with one row per sample. Each is read as a whole into a table.
//!
//! | shape | first lines |
//! |---|---|
//! | UTF-16 | a byte order mark |
//! | a row per signal | `q1,0.1,0.2,..`: far more cells than rows |
//! | lines above the header, as oscilloscopes and PLCs write them | lines with fewer cells than the numbers below |
//!
//! Other packages register more shapes ([`LogReader::Text`](crate::reading::LogReader)). The first [`HEAD_BYTES`] of a text
//! determine its shape. A text without such a shape is read by `delimited`, some rows at a time.

use gate::budget::Budget;

use crate::Error;
use crate::formats::delimited::{TableReader, delimiter};
use crate::formats::number::number;
use crate::formats::registered::{ReadBytes, text_shapes};
use crate::formats::text_head::{HEAD_BYTES, HEAD_ROWS, IsShape, TextHead, rows};
use crate::table::{RowReader, Table, check_header};

/// If the first line has at least this number of cells with numbers, it may contain all samples of a signal.
const MIN_CELLS_OF_A_SIGNAL: usize = 256;
/// Number of successive rows of numbers that mark the start of a table.
const ROWS_OF_A_TABLE: usize = 3;

/// The function that reads a text with these first bytes. `None` if the text is a plain table with one row per sample.
pub(crate) fn reader(head: &[u8]) -> Option<ReadBytes> {
    let own: [(IsShape, ReadBytes); 3] =
        [(is_utf16, utf16), (is_row_per_signal, row_per_signal), (has_lines_above, below_lines)];
    let head = TextHead::of(head);
    text_shapes().chain(own).find(|(is_so, _)| is_so(&head)).map(|(_, read)| read)
}

fn is_number(cell: &str, delimiter: Option<u8>) -> bool {
    !cell.is_empty() && number(cell.as_bytes(), delimiter).is_some()
}

fn is_utf16(head: &TextHead) -> bool {
    head.bytes.starts_with(b"\xff\xfe") || head.bytes.starts_with(b"\xfe\xff")
}

/// The table of a text in UTF-16. Excel writes such a text as "Unicode text".
fn utf16(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
    let is_big = bytes.starts_with(b"\xfe\xff");
    // In UTF-8, a unit of two bytes needs at most three bytes.
    budget.draw(bytes.len().saturating_mul(3)).map_err(|e| Error::at(file, 0, e))?;
    let units = bytes[2..].as_chunks::<2>().0.iter();
    let units = units.map(|pair| if is_big { u16::from_be_bytes(*pair) } else { u16::from_le_bytes(*pair) });
    let text: Result<String, _> = char::decode_utf16(units).collect();
    let text = text.map_err(|_| Error::at(file, 0, "this text is damaged UTF-16; save it as UTF-8"))?;
    Table::of_text(file, text.as_bytes(), budget)
}

/// Whether the first row contains the samples of one signal: at least [`MIN_CELLS_OF_A_SIGNAL`] cells, all of them numbers. The
/// first cell may be a name.
fn is_row_per_signal(head: &TextHead) -> bool {
    let first = head.bytes.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let cells = rows(first, head.delimiter.or(delimiter(first))).next().map(|(_, cells)| cells).unwrap_or_default();
    cells.len() >= MIN_CELLS_OF_A_SIGNAL && cells[1..cells.len() - 1].iter().all(|cell| is_number(cell, head.delimiter))
}

/// The table of a text with one row per signal. If the text has at least as many rows as its first row has cells, it is read as
/// a table with one row per sample.
fn row_per_signal(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
    let first = bytes.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let delimiter = delimiter(first);
    let count = bytes.split(|byte| *byte == b'\n').filter(|line| !line.trim_ascii().is_empty()).count();
    if count >= rows(first, delimiter).next().map_or(0, |(_, cells)| cells.len()) {
        return TableReader::new(file, bytes)?.rows(usize::MAX);
    }
    // Upper bound of the memory of the table: each number takes at least one byte of the text.
    budget.draw(bytes.len().saturating_mul(size_of::<f64>())).map_err(|e| Error::at(file, 0, e))?;
    let mut table = Table { file: file.into(), ..Table::default() };
    for (line, mut cells) in rows(bytes, delimiter) {
        let is_named = !is_number(&cells[0], delimiter);
        let name = if is_named { cells.remove(0) } else { format!("c{}", table.header.len() + 1) };
        // A delimiter at the end of a line makes an empty last cell.
        if cells.last().is_some_and(String::is_empty) {
            cells.pop();
        }
        let values: Option<Vec<f64>> = cells.iter().map(|cell| number(cell.as_bytes(), delimiter)).collect();
        let values = values.ok_or_else(|| {
            Error::at(file, line, format!("text among the {} samples of the signal `{name}`", cells.len()))
        })?;
        if let Some(first) = table.columns.first().filter(|first| first.len() != values.len()) {
            let message = format!("{} samples where the first signal has {}", values.len(), first.len());
            return Err(Error::at(file, line, message));
        }
        table.header.push(name);
        table.columns.push(values);
    }
    table.texts = vec![None; table.header.len()];
    table.notes.push(format!("the file has a row per signal: {count} signals of {} samples", table.rows()));
    check_header(file, 0, &mut table.header)?;
    Ok(table)
}

/// The position of a table that is below other lines.
struct Below {
    /// The line of the header, if there is one.
    header: Option<usize>,
    /// The first line of the numbers.
    numbers: usize,
    /// Number of cells of the first row of the text.
    first_width: usize,
}

/// Finds the first successive rows that contain only numbers and have equal numbers of cells, and the header above them. A row
/// can be the header only if it has the same number of cells and no numbers. Of several such rows, the row with the most
/// different cells is the header; of equal ones, the first. `None` if all rows above have this number of cells, because then
/// they are a header and units.
fn below(text: &[u8]) -> Option<Below> {
    [Some(b';'), Some(b'\t'), Some(b','), None].into_iter().find_map(|delimiter| {
        let rows: Vec<(usize, Vec<String>)> = rows(text, delimiter).take(HEAD_ROWS).collect();
        let is_of_numbers = |row: &(usize, Vec<String>)| row.1.iter().all(|cell| is_number(cell, delimiter));
        let begin = rows
            .windows(ROWS_OF_A_TABLE)
            .position(|w| w[0].1.len() > 1 && w.iter().all(|row| row.1.len() == w[0].1.len() && is_of_numbers(row)))?;
        let width = rows[begin].1.len();
        if rows[..begin].iter().all(|row| row.1.len() == width) {
            return None;
        }
        let distinct = |cells: &[String]| cells.iter().collect::<std::collections::BTreeSet<_>>().len();
        let is_header = |row: &&(usize, Vec<String>)| {
            row.1.len() == width && !row.1.iter().any(|cell| cell.is_empty() || is_number(cell, delimiter))
        };
        let header = rows[..begin].iter().filter(is_header).rev().max_by_key(|row| distinct(&row.1));
        Some(Below { header: header.map(|row| row.0), numbers: rows[begin].0, first_width: rows[0].1.len() })
    })
}

fn has_lines_above(head: &TextHead) -> bool {
    // If the second line already contains numbers and the first line has several cells, the first line is a header with a
    // missing name. Then the table is not below other lines.
    below(head.lines.join("\n").as_bytes()).is_some_and(|below| below.numbers > 2 || below.first_width == 1)
}

/// Reads a table that is below other lines. These lines become comments, so that the line numbers of the table do not change.
fn below_lines(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
    let head = &bytes[..bytes.len().min(HEAD_BYTES)];
    let Some(below) = below(head) else { return TableReader::new(file, bytes)?.rows(usize::MAX) };
    budget.draw(bytes.len()).map_err(|e| Error::at(file, 0, e))?;
    let mut text = Vec::with_capacity(bytes.len() + below.numbers);
    for (k, line) in bytes.split_inclusive(|byte| *byte == b'\n').enumerate() {
        if k + 1 < below.numbers && Some(k + 1) != below.header && !line.trim_ascii().is_empty() {
            text.push(b'#');
        }
        text.extend_from_slice(line);
    }
    let mut table = TableReader::new(file, &text[..])?.rows(usize::MAX)?;
    table.notes.push(format!(
        "the table begins at line {}: the other lines above the numbers are not read",
        below.header.unwrap_or(below.numbers)
    ));
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &[u8]) -> Table {
        Table::from_bytes("x.txt", text).unwrap()
    }

    #[test]
    fn a_table_with_a_row_per_sample_has_no_shape_of_its_own() {
        for text in [
            "t,q1\n0,1\n1,2\n",
            "t;q1\n0,5;1\n0,6;2\n0,7;2\n0,8;2\n",
            "# made by x\nt,q1\ns,deg\n0,1\n1,2\n2,3\n",
            "0 1\n1 2\n2 3\n3 4\n",
            "duration, q[0], q[1]\n0, 1, 2\n1, 1, 2\n",
            "t,name,q1\n0,run,1\n1,run,2\n2,run,3\n",
            "t,id,q1\n0,1,1\n1,2,2\n2,3,3\n3,4,3\n",
            "t,q1\n0,1,\n1,2,\n2,3,\n3,4,\n",
            "date,q1\n2024-01-01 10:00:00,1\n2024-01-01 10:00:01,1\n2024-01-01 10:00:02,1\n",
        ] {
            assert!(reader(text.as_bytes()).is_none(), "{text}");
        }
    }

    #[test]
    fn utf16_of_both_orders() {
        for (mark, of) in [(b"\xff\xfe", u16::to_le_bytes as fn(u16) -> [u8; 2]), (b"\xfe\xff", u16::to_be_bytes)] {
            let text: Vec<u8> = "t\tq1\r\n0\t1\r\n1\t2\r\n".encode_utf16().flat_map(of).collect();
            let table = table(&[&mark[..], &text].concat());
            assert_eq!((table.header.join(" "), &table.columns[1]), ("t q1".into(), &vec![1.0, 2.0]));
        }
        let half = Table::from_bytes("x.txt", b"\xff\xfet\0\x00\xd8,\0").unwrap_err().to_string();
        assert!(half.contains("damaged UTF-16"), "{half}");
    }

    #[test]
    fn rows_of_samples_become_columns() {
        let row = |name: &str, f: f64| {
            let cells: Vec<String> = (0..300).map(|k| (f * f64::from(k)).to_string()).collect();
            format!("{name}{}\n", cells.join(","))
        };
        let unnamed = table(format!("{}{}", row("", 0.5), row("", 2.0)).as_bytes());
        assert_eq!((unnamed.header.join(" "), unnamed.rows()), ("c1 c2".into(), 300));
        assert_eq!(unnamed.columns[1][7], 14.0);
        let named = table(format!("{}{}", row("t,", 0.5), row("q1,", 2.0)).as_bytes());
        assert_eq!((named.header.join(" "), named.columns[1][7]), ("t q1".into(), 14.0));
        let ragged = format!("{}1,2,3\n", row("", 0.5));
        let message = Table::from_bytes("x.txt", ragged.as_bytes()).unwrap_err().to_string();
        assert!(message.contains("x.txt:2: 3 samples where the first signal has 300"), "{message}");
        // The last line has no line end.
        let message = Table::from_bytes("x.txt", ragged.trim_end().as_bytes()).unwrap_err().to_string();
        assert!(message.contains("x.txt:2: 3 samples"), "{message}");
        // A text with as many rows as cells per row is read as one row per sample.
        let square: String = (0..300).map(|_| row("", 0.5)).collect();
        assert_eq!(table(square.as_bytes()).rows(), 300);
    }

    #[test]
    fn lines_above_the_header_keep_the_numbers_of_lines() {
        let scope = "Name;Project1\nFile;C:\\a.svdx\nStart;1;Monday\n\nName;Axis1.ActPos;Name;Axis1.ActTorque\n\
                     Data-Type;REAL64;Data-Type;REAL64\nSampleTime[ms];2;SampleTime[ms];2\n\
                     0;1,5;0;7\n2;1,6;2;8\n4;1,7;4;9\n6;1,8;6;9\n";
        let table = table(scope.as_bytes());
        assert_eq!(table.header, ["Name #1", "Axis1.ActPos", "Name #2", "Axis1.ActTorque"]);
        assert_eq!((&table.columns[1], table.line(0)), (&vec![1.5, 1.6, 1.7, 1.8], 8));
        assert!(table.notes[0].contains("begins at line 5"), "{:?}", table.notes);
        let titled = self::table(b"My log\n0,1\n1,2\n2,3\n3,4\n");
        assert_eq!((titled.header.join(" "), titled.rows(), titled.line(0)), ("c1 c2".into(), 4, 2));
    }
}
