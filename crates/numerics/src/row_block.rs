//! Rows on their way into a triangle, eight abreast: entry k of rows 8 g .. 8 g + 7 is one [`Eight`], at g stride + k.
//!
//! A block stays in the first-level cache while a triangle takes it up. The stride is odd, so that the groups of a column
//! do not fall into one set of the cache.

use generated::Eight;

/// Rows of one block. A triangle is updated once a block.
pub const BLOCK_ROWS: usize = 128;

/// Up to [`BLOCK_ROWS`] rows of some entries.
#[derive(Clone, Debug)]
pub struct RowBlock {
    stride: usize,
    numbers: Vec<Eight>,
    /// Rows that are filled. Those beyond them in the last group of eight are zero.
    pub rows: usize,
}

impl RowBlock {
    /// No row yet, with this many entries a row.
    pub fn new(entries: usize) -> RowBlock {
        let stride = entries | 1;
        RowBlock { stride, numbers: vec![Eight::default(); stride * BLOCK_ROWS / 8], rows: 0 }
    }

    /// Groups of eight that hold rows.
    #[inline]
    pub fn groups(&self) -> usize {
        self.rows.div_ceil(8)
    }

    /// Distance between groups.
    #[inline]
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// The entries of the eight rows from 8 g on.
    #[inline]
    pub fn group(&mut self, g: usize) -> &mut [Eight] {
        &mut self.numbers[g * self.stride..(g + 1) * self.stride]
    }

    /// The entries of the eight rows from `row` on, a multiple of eight.
    #[inline]
    pub fn rows_from(&self, row: usize) -> &[Eight] {
        &self.numbers[row / 8 * self.stride..][..self.stride]
    }

    /// The groups that hold rows, one after the other.
    #[inline]
    pub fn numbers(&mut self) -> &mut [Eight] {
        let groups = self.groups();
        &mut self.numbers[..groups * self.stride]
    }

    /// Appends a row of entries; the block must not be full.
    #[inline]
    pub fn push(&mut self, row: impl Iterator<Item = f64>) {
        let (g, lane) = (self.rows / 8, self.rows % 8);
        let group = self.group(g);
        if lane == 0 {
            group.fill(Eight::default());
        }
        for (eight, x) in group.iter_mut().zip(row) {
            eight.0[lane] = x;
        }
        self.rows += 1;
    }

    /// Appends eight rows, whose entries are to be filled; the block must be of whole eights and not full.
    #[inline]
    pub fn push_eight(&mut self) -> &mut [Eight] {
        self.rows += 8;
        self.group(self.rows / 8 - 1)
    }

    /// Whether no further row has room.
    #[inline]
    pub fn is_full(&self) -> bool {
        self.rows == BLOCK_ROWS
    }
}
