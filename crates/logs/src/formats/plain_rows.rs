//! Reads a row of text if the ends of its cells are known.
//!
//! In a plain row, every delimiter ends a cell: there are no quotation marks. `cell_ends` finds the ends of the cells.

use crate::formats::number::{leading, short};
use crate::formats::rows::{Block, Dialect};

impl Dialect {
    /// Reads the row that begins at `at`. `ends`: positions of the ends of all its cells. Returns the start of the next line.
    #[inline(always)]
    pub(super) fn read_plain_row(
        &self,
        bytes: &[u8],
        at: usize,
        ends: &[u32],
        places: &[Option<usize>],
        block: &mut Block,
    ) -> usize {
        let mut start = at;
        for (column, (end, place)) in ends.iter().zip(places).enumerate() {
            let end = *end as usize;
            if let Some(place) = place {
                block.data[place + block.rows] = match short(bytes, start, end) {
                    Some(x) => x,
                    None => self.long(&bytes[start..], end - start, block.ends, &mut block.texts[column]),
                };
            }
            start = end + 1;
        }
        block.lines.push(block.ends);
        block.rows += 1;
        block.ends += 1;
        start
    }

    /// The number in the cell with this `length` at the start of the bytes.
    #[inline(never)]
    fn long(&self, bytes: &[u8], length: usize, line: usize, text: &mut Option<(usize, String)>) -> f64 {
        let cell = bytes[..length].trim_ascii();
        let plain = leading(bytes.trim_ascii_start()).filter(|(_, length)| *length == cell.len());
        plain.map_or_else(|| self.number(cell, line, text), |(x, _)| x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::rows::WholeRows;

    #[test]
    fn plain_rows_are_as_any() {
        let cells = [
            "0",
            "-0",
            "1.5",
            "-2.25",
            "12345678",
            "123456789",
            "0.1234567890123456",
            "1e-3",
            "",
            " 3",
            "4 ",
            "  -5.5  ",
            "nan",
            "na",
            "word",
            "+6",
            "1.2.3",
            ".",
            "-",
            "2026-11-21 07:49:04.25",
            "\u{663}",
            "1,5",
        ];
        let mut state = 1_u32;
        let mut any = |count: usize| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as usize % count
        };
        for (delimiter, width) in [(b',', 1), (b',', 2), (b';', 3), (b'\t', 19)] {
            let (mut text, mut count) = (String::new(), 0);
            while count < 500 {
                match any(40) {
                    0 => text.push_str("# a comment; with, cells\n"),
                    1 => text.push_str("\r\n"),
                    short => {
                        // Some rows have one cell too few or too many.
                        let width = if short < 5 { width + short - 3 } else { width };
                        let some = (0..width.max(1)).map(|_| cells[any(cells.len())]);
                        let row: Vec<&str> = some.filter(|cell| delimiter != b',' || !cell.contains(',')).collect();
                        text.push_str(&row.join(&char::from(delimiter).to_string()));
                        text.push_str(["\n", "\r\n"][any(2)]);
                        count += 1;
                    }
                }
            }
            text.push('7');
            let wanted = (0..width).map(|k| k % 3 != 1).collect();
            let dialect = Dialect { delimiter: Some(delimiter), wanted };
            let rows = dialect.whole_rows(text.as_bytes(), 1000, true);
            assert!(rows.are_plain && rows.bytes == text.len());
            let plain = dialect.read(text.as_bytes(), rows);
            let other = dialect.read(text.as_bytes(), WholeRows { are_plain: false, ..rows });
            let bits = |block: &Block| block.data.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
            assert_eq!(bits(&plain), bits(&other));
            let rest =
                |b: Block| (b.rows, b.texts, b.ragged, b.ends, (0..b.rows).map(|i| b.lines.get(i)).collect::<Vec<_>>());
            assert_eq!(rest(plain), rest(other));
        }
    }
}
