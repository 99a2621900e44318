//! The products of the columns of some rows with one another, eight rows at a time.

use generated::Eight;
use numerics::reflection::add_products;
use numerics::row_block::RowBlock;

/// Rows of one joint: the columns that its torque can depend on, then one number more, a residual or a torque.
#[derive(Clone)]
pub struct RowProducts {
    places: Vec<usize>,
    /// Products (i, j), i <= j, column by column.
    products: Vec<f64>,
    /// Rows that are in no product yet.
    block: RowBlock,
}

impl RowProducts {
    /// Of `columns` columns, without rows.
    pub fn new(columns: usize) -> RowProducts {
        let entries = columns + 1;
        let places = (0..entries).collect();
        RowProducts { places, products: vec![0.0; entries * entries], block: RowBlock::new(entries) }
    }

    /// Takes in eight rows: their entries at `places`, then `right`, each multiplied by its weight.
    pub fn push(&mut self, places: &[usize], entries: &[Eight], right: &[f64; 8], weights: &[f64; 8]) {
        // A row that does not count may hold NaN, which a weight of zero does not remove.
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

    /// Adds the rows that follow.
    pub fn append(&mut self, next: RowProducts) {
        let next = next.finish();
        self.products.iter_mut().zip(&next).for_each(|(sum, product)| *sum += product);
    }

    /// The products of all rows. Product (i, j), i <= j, of m columns and the number behind them stands at j (m + 1) + i.
    pub fn finish(mut self) -> Vec<f64> {
        self.complete();
        self.products
    }

    fn complete(&mut self) {
        add_products(&mut self.products, &self.places, &mut self.block);
        self.block.rows = 0;
    }
}
