//! Stores blocks of rows for a triangle (R of a QR decomposition), eight rows in SIMD lanes: entry k of the eight rows 8 g .. 8
//! g + 7 is one [`Eight`], stored at the index g stride + k.
//!
//! A block stays in the first-level cache while it is folded into a triangle. The stride is odd, so that the entries of a column
//! are not all in one set of the cache.

use generated::Eight;

/// Maximum number of rows of a block. A triangle is updated after each full block.
pub const BLOCK_ROWS: usize = 128;

/// Up to [`BLOCK_ROWS`] rows with an equal number of entries.
#[derive(Clone, Debug)]
pub struct RowBlock {
    stride: usize,
    numbers: Vec<Eight>,
    /// Number of filled rows. Other rows of the last group of eight are zero.
    pub rows: usize,
}

impl RowBlock {
    /// Makes a block without rows, with `entries` numbers per row.
    pub fn new(entries: usize) -> RowBlock {
        let stride = entries | 1;
        RowBlock { stride, numbers: vec![Eight::default(); stride * BLOCK_ROWS / 8], rows: 0 }
    }

    /// Number of groups of eight that contain filled rows.
    #[inline]
    pub fn groups(&self) -> usize {
        self.rows.div_ceil(8)
    }

    /// Number of [`Eight`]s from one group of rows to the next.
    #[inline]
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// The entries of the rows 8 g .. 8 g + 7.
    #[inline]
    pub fn group(&mut self, g: usize) -> &mut [Eight] {
        &mut self.numbers[g * self.stride..(g + 1) * self.stride]
    }

    /// The entries of eight rows, from row number `row` on. `row` must be a multiple of eight.
    #[inline]
    pub fn rows_from(&self, row: usize) -> &[Eight] {
        &self.numbers[row / 8 * self.stride..][..self.stride]
    }

    /// The entries of all groups that contain filled rows, group by group.
    #[inline]
    pub fn numbers(&mut self) -> &mut [Eight] {
        let groups = self.groups();
        &mut self.numbers[..groups * self.stride]
    }

    /// Appends one row from its entries. The block must not be full.
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

    /// Appends eight rows and returns their entries to be filled. The block must not be full, and its number of rows must be a
    /// multiple of eight.
    #[inline]
    pub fn push_eight(&mut self) -> &mut [Eight] {
        self.rows += 8;
        self.group(self.rows / 8 - 1)
    }

    /// Whether the block has no room for a further row.
    #[inline]
    pub fn is_full(&self) -> bool {
        self.rows == BLOCK_ROWS
    }
}
