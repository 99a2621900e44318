//! Rows for a triangle, eight in SIMD lanes: entry k of rows 8 g .. 8 g + 7 is one [`Eight`], at g stride + k.
//!
//! A block stays in the first-level cache while a triangle folds it in. The stride is odd, so that the groups of a column do not
//! fall into one set of the cache.

use generated::Eight;

/// Rows of one block. A triangle is updated once per block.
pub const BLOCK_ROWS: usize = 128;

/// Up to [`BLOCK_ROWS`] rows of some entries.
#[derive(Clone, Debug)]
pub struct RowBlock {
    stride: usize,
    numbers: Vec<Eight>,
    /// Filled rows. The rows beyond them in the last group of eight are zero.
    pub rows: usize,
}

impl RowBlock {
    /// A block without rows, with this number of entries per row.
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

    /// The entries of eight rows from row 8 g.
    #[inline]
    pub fn group(&mut self, g: usize) -> &mut [Eight] {
        &mut self.numbers[g * self.stride..(g + 1) * self.stride]
    }

    /// The entries of eight rows from `row`, a multiple of eight.
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

    /// Appends eight rows and returns their entries for filling; the rows must be a multiple of eight, and the block not full.
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
