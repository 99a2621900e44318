//! Finds the ends of the cells of plain rows, before the cells are read.
//!
//! If both ends of a cell are known, the cell can be read before the previous cell is finished. So the processor works on
//! several cells in parallel [Langdale, Lemire 2019]. In plain rows, every delimiter ends a cell and every line feed ends a
//! row.

use wide::u8x16;

/// Number of bytes that one bit mask describes.
const BYTES_PER_MASK: usize = u64::BITS as usize;

/// Number of bytes that are searched at a time. The positions of their cell ends fit into the cache.
const BYTES_PER_SEARCH: usize = 64 * BYTES_PER_MASK;

/// Finds the ends of cells, row by row.
pub(super) struct CellEnds<'a> {
    bytes: &'a [u8],
    delimiter: u8,
    /// Number of bytes that were already searched.
    searched: usize,
    /// Positions of delimiters and line feeds.
    cells: Places,
    /// Positions of line feeds.
    rows: Places,
}

impl<'a> CellEnds<'a> {
    /// Starts at the first byte. `bytes` may have at most 4 GiB.
    pub(super) fn new(bytes: &'a [u8], delimiter: u8) -> CellEnds<'a> {
        CellEnds { bytes, delimiter, searched: 0, cells: Places::default(), rows: Places::default() }
    }

    /// The ends of the cells of the row that begins at byte `at`. `None` if the row has not exactly `width` cells, or no line
    /// feed. Rows must be requested in ascending order; some may be skipped.
    #[inline(always)]
    pub(super) fn of_row(&mut self, at: usize, width: usize) -> Option<&[u32]> {
        loop {
            self.cells.pass(at);
            self.rows.pass(at);
            if self.cells.next().len() >= width && !self.rows.next().is_empty() {
                break;
            }
            if self.searched >= self.bytes.len() {
                return None;
            }
            self.search();
        }
        let (ends, end) = (&self.cells.next()[..width], self.rows.next()[0]);
        // The first line feed must be the end of the last cell. Otherwise the line feed is inside the row.
        if ends.last() != Some(&end) {
            return None;
        }
        let first = self.cells.first;
        self.cells.first += width;
        self.rows.first += 1;
        Some(&self.cells.places[first..first + width])
    }

    /// Finds the cell ends in the next bytes.
    #[inline(always)]
    fn search(&mut self) {
        let end = self.bytes.len().min(self.searched + BYTES_PER_SEARCH);
        let (chunks, rest) = self.bytes[self.searched..end].as_chunks::<BYTES_PER_MASK>();
        let mut last = [0; BYTES_PER_MASK];
        last[..rest.len()].copy_from_slice(rest);
        self.cells.forget();
        self.rows.forget();
        for (k, chunk) in chunks.iter().chain([&last]).enumerate() {
            let first = (self.searched + k * BYTES_PER_MASK) as u32;
            // The zeros that fill the last mask are not counted as ends.
            let there = if k < chunks.len() { u64::MAX } else { (1 << rest.len()) - 1 };
            let rows = mask(chunk, b'\n') & there;
            self.cells.add(first, mask(chunk, self.delimiter) & there | rows);
            self.rows.add(first, rows);
        }
        self.searched = end;
    }
}

/// Positions in a text, in ascending order. Positions before `first` were used already; entries from `found` on are not valid
/// yet.
#[derive(Default)]
struct Places {
    places: Vec<u32>,
    first: usize,
    found: usize,
}

impl Places {
    #[inline(always)]
    fn next(&self) -> &[u32] {
        &self.places[self.first..self.found]
    }

    /// Skips the positions before `at`.
    #[inline(always)]
    fn pass(&mut self, at: usize) {
        self.first += self.next().iter().take_while(|place| (**place as usize) < at).count();
    }

    /// Removes the used positions, and reserves space for the next search.
    #[inline(always)]
    fn forget(&mut self) {
        // Positions are moved only if some were used, because a long row needs many searches before its end is found.
        if self.first > 0 {
            self.places.copy_within(self.first..self.found, 0);
            (self.first, self.found) = (0, self.found - self.first);
        }
        self.places.resize(self.found + BYTES_PER_SEARCH + BYTES_PER_MASK, 0);
    }

    /// Adds the positions of the set bits, relative to `first`.
    #[inline(always)]
    fn add(&mut self, first: u32, mut mask: u64) {
        let room = &mut self.places[self.found..][..BYTES_PER_MASK];
        self.found += mask.count_ones() as usize;
        // Always writes eight positions at once, because a loop over one or two would cause branch mispredictions.
        for eight in room.as_chunks_mut::<8>().0 {
            if mask == 0 {
                break;
            }
            for place in eight {
                *place = first + mask.trailing_zeros();
                mask &= mask.wrapping_sub(1);
            }
        }
    }
}

/// A bit mask that is one at each byte that equals `byte`.
#[inline(always)]
fn mask(bytes: &[u8; BYTES_PER_MASK], byte: u8) -> u64 {
    let part = |bytes: &[u8; 16]| u64::from(u8x16::new(*bytes).simd_eq(u8x16::splat(byte)).to_bitmask());
    bytes.as_chunks::<16>().0.iter().rev().fold(0, |mask, bytes| mask << 16 | part(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_in_turn() {
        for (width, length) in [(1, 1), (1, 64), (2, 5), (3, 31), (19, 1), (19, 9), (100, 7), (700, 12)] {
            let cell = "7".repeat(length);
            let row = |cells: usize| format!("{}\n", vec![cell.as_str(); cells].join(","));
            let rows: Vec<String> = (0..400).map(|i| row(if i % 7 == 3 { width + 1 } else { width })).collect();
            let text = rows.concat() + &row(width)[..width * (length + 1) - 1];
            for left_out in [0, 2, 5] {
                let (mut ends, mut at) = (CellEnds::new(text.as_bytes(), b','), 0);
                for (i, row) in rows.iter().enumerate() {
                    if left_out == 0 || i % left_out > 0 {
                        let expected: Vec<u32> = (1..=width).map(|k| (at + k * (length + 1) - 1) as u32).collect();
                        let expected = (i % 7 != 3).then_some(&expected[..]);
                        assert_eq!(ends.of_row(at, width), expected, "row {i} of {width} cells of {length}");
                    }
                    at += row.len();
                }
                assert_eq!(ends.of_row(at, width), None, "a row without its end");
            }
        }
    }
}
