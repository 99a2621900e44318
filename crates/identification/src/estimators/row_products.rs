//! Computes sums of products of the columns of rows with each other, W'W and W'e, for eight rows at a time (SIMD lanes). W:
//! rows of the regressor of one joint; e: residuals or torques, the last column.

use generated::Eight;
use numerics::reflection::add_products;
use numerics::row_block::RowBlock;

/// Sums of products of the columns of one joint. The columns are the regressor columns on which the torque of the joint can
/// depend and, as the last column, the residual or the torque.
#[derive(Clone)]
pub struct RowProducts {
    places: Vec<usize>,
    /// The sum of products of columns i <= j is at index j * (number of columns) + i.
    products: Vec<f64>,
    /// Rows whose products are not yet added.
    block: RowBlock,
}

impl RowProducts {
    /// Makes empty sums for `columns` columns and one more column (residual or torque).
    pub fn new(columns: usize) -> RowProducts {
        let entries = columns + 1;
        let places = (0..entries).collect();
        RowProducts { places, products: vec![0.0; entries * entries], block: RowBlock::new(entries) }
    }

    /// Adds eight rows: their entries at `places`, then `right` as the last column. Each row is multiplied by its weight.
    pub fn push(&mut self, places: &[usize], entries: &[Eight], right: &[f64; 8], weights: &[f64; 8]) {
        // A row of weight zero may contain NaN, and 0 * NaN is NaN. Such a row is therefore replaced by zeros.
        let weighted = |x: &[f64; 8]| {
            let mut row = Eight([0.0; 8]);
            for lane in 0..8 {
                row.0[lane] = if weights[lane] == 0.0 { 0.0 } else { weights[lane] * x[lane] };
            }
            row
        };
        let rows = self.block.push_eight();
        for (row, &place) in rows.iter_mut().zip(places) {
            *row = weighted(&entries[place].0);
        }
        rows[places.len()] = weighted(right);
        if self.block.is_full() {
            self.complete();
        }
    }

    /// Adds the sums of products of other rows with the same columns.
    pub fn append(&mut self, next: RowProducts) {
        let next = next.finish();
        self.products.iter_mut().zip(&next).for_each(|(sum, product)| *sum += product);
    }

    /// The sums over all rows. With m regressor columns and one last column, the product of columns i <= j is at index j (m +
    /// 1) + i.
    pub fn finish(mut self) -> Vec<f64> {
        self.complete();
        self.products
    }

    fn complete(&mut self) {
        add_products(&mut self.products, &self.places, &mut self.block);
        self.block.rows = 0;
    }
}
