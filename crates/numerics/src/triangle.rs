//! Streaming least squares: rows are folded into a triangle (QR decomposition) and not stored.
//!
//! [W y] = Q [R z; 0 rho] for all rows so far. Householder reflections annihilate a block of rows below R
//! ([`reflection`](crate::reflection)). To merge two triangles, the rows of one triangle are folded into the other triangle.
//! [Golub, Van Loan 2013]
//!
//! | symbol | code | shape | |
//! |---|---|---|---|
//! | R, z, rho | `entries` | upper, column by column; of m columns m x m | the unit of y per unit of the parameter |
//!
//! In a robot with many limbs, the torque of a joint depends on few parameters, so most columns are zero. A column that has
//! held only zeros so far takes neither time nor memory. Weights are not stored here: the whole triangle of a joint is scaled
//! when it is merged.

use std::ops::Range;

use crate::reflection::{ColumnPlaces, reflect};
use crate::row_block::RowBlock;

/// The triangle R, z, rho of p columns and one right-hand side.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangle {
    p: usize,
    /// Columns that have had a non-zero entry, ascending. Column number p is the right-hand side.
    live: Vec<usize>,
    /// For each column, its index among the columns in `live`, or [`NOT_LIVE`].
    places: Vec<u32>,
    /// Entry (a, b), a <= b < m, of the triangle of the m columns in `live` is at b m + a.
    entries: Vec<f64>,
    /// Number of rows that were folded into the triangle.
    pub rows: usize,
    /// The difference |measured signal|^2 - |y|^2, y: right-hand side. The difference is not 0 if a known torque was subtracted
    /// from the measured signal to give y.
    pub taken_out: f64,
}

/// Marks a column that has had only zeros.
const NOT_LIVE: u32 = u32::MAX;

/// If the pivot of a column is below this share of the column's norm, the pivot is rounding error, and the column depends on
/// the earlier columns.
const DEPENDENT_COLUMN_SHARE: f64 = 1e-10;

/// Collects rows in a block, and updates a triangle (R of a QR decomposition) with each full block.
#[derive(Clone, Debug)]
pub struct TriangleBuilder {
    triangle: Triangle,
    block: RowBlock,
}

impl TriangleBuilder {
    /// Makes a builder without rows, for `p` columns and a right-hand side.
    pub fn new(p: usize) -> TriangleBuilder {
        TriangleBuilder { triangle: Triangle::new(p), block: RowBlock::new(p + 1) }
    }

    /// Appends a row of p coefficients and its right-hand side `y`.
    ///
    /// # Panics
    /// If `row` does not have p entries.
    #[inline]
    pub fn push(&mut self, row: &[f64], y: f64) {
        assert!(row.len() == self.triangle.p);
        if self.block.is_full() {
            self.triangle.fold(&mut self.block);
        }
        self.block.push(row.iter().copied().chain(std::iter::once(y)));
    }

    /// The triangle of all appended rows.
    pub fn finish(mut self) -> Triangle {
        self.triangle.fold(&mut self.block);
        self.triangle
    }
}

/// The triangle of some of p columns, such as the columns of one joint. The rows of the folded blocks also have entries of
/// other columns, which are not used.
#[derive(Clone, Debug)]
pub struct ColumnTriangle {
    /// The numbers of the triangle's columns among all p columns, ascending.
    columns: Vec<usize>,
    /// The indices of the triangle's columns in a row of a block, then the index of the right-hand side.
    places: Vec<usize>,
    index: Vec<usize>,
    entries: Vec<f64>,
    rows: usize,
}

impl ColumnTriangle {
    /// Makes a triangle without rows. `columns`: ascending; `places`: indices of these columns in a row, then of the right-hand
    /// side.
    pub fn new(columns: &[usize], places: &[usize]) -> ColumnTriangle {
        let m = places.len();
        let (columns, places, index) = (columns.to_vec(), places.to_vec(), (0..m).collect());
        ColumnTriangle { columns, places, index, entries: vec![0.0; m * m], rows: 0 }
    }

    /// Updates the triangle with the rows of a block. `rows`: number of rows that are not zero. In the block, the entries of
    /// the triangle's columns are overwritten.
    #[inline]
    pub fn fold(&mut self, block: &mut RowBlock, rows: usize) {
        self.rows += rows;
        let columns = ColumnPlaces { index: &self.index, places: &self.places };
        reflect(&mut self.entries, self.places.len(), columns, block);
    }

    /// The triangle of all p columns. `least`: for each column, the rms up to which the column counts as zero. Columns beyond
    /// the end of `least` are kept.
    pub fn finish(self, p: usize, least: &[f64]) -> Triangle {
        let m = self.places.len();
        let all = |k: usize| self.columns.get(k).copied().unwrap_or(p);
        let is_small = |j: usize| {
            let square = self.entries[j * m..=j * m + j].iter().map(|x| x * x).sum::<f64>();
            let least = least.get(all(j)).copied().unwrap_or(0.0);
            square > 0.0 && square <= self.rows as f64 * least * least
        };
        if (0..m).any(is_small) {
            // A removed column has a row in R with entries of the other columns. So all rows of R are folded into a new triangle
            // without the removed columns.
            let mut others = TriangleBuilder::new(p);
            for i in 0..m {
                let mut row = vec![0.0; p + 1];
                (i..m).filter(|&j| !is_small(j)).for_each(|j| row[all(j)] = self.entries[j * m + i]);
                others.push(&row[..p], row[p]);
            }
            return Triangle { rows: self.rows, ..others.finish() };
        }
        let is_kept = |&j: &usize| (0..=j).any(|i| self.entries[j * m + i] != 0.0);
        let kept: Vec<usize> = (0..m).filter(is_kept).collect();
        let mut triangle = Triangle::new(p);
        triangle.set_live(kept.iter().map(|&k| all(k)).collect());
        for (b, &j) in kept.iter().enumerate() {
            for (a, &i) in kept[..=b].iter().enumerate() {
                triangle.entries[b * kept.len() + a] = self.entries[j * m + i];
            }
        }
        triangle.rows = self.rows;
        triangle
    }
}

impl Triangle {
    /// Makes a triangle without rows, for `p` columns and a right-hand side.
    pub fn new(p: usize) -> Triangle {
        Triangle { p, live: Vec::new(), places: vec![NOT_LIVE; p + 1], entries: Vec::new(), rows: 0, taken_out: 0.0 }
    }

    /// The memory of a triangle with `p` columns and a right-hand side, bytes. `live`: number of columns that are not zero, the
    /// right-hand side included.
    pub fn bytes(p: usize, live: usize) -> usize {
        let entries = live.saturating_mul(live).saturating_add(live).saturating_mul(size_of::<f64>());
        entries.saturating_add((p + 1).saturating_mul(size_of::<u32>()))
    }

    /// Changes the stored columns to `live`, ascending. `live` must contain the columns that are stored now. New columns
    /// contain zeros.
    fn set_live(&mut self, live: Vec<usize>) {
        let m = live.len();
        let before = std::mem::replace(&mut self.live, live);
        let of_before = std::mem::replace(&mut self.entries, vec![0.0; m * m]);
        for (place, &c) in self.live.iter().enumerate() {
            self.places[c] = place as u32;
        }
        for (b, &j) in before.iter().enumerate() {
            for (a, &i) in before[..=b].iter().enumerate() {
                let place = self.places[j] as usize * m + self.places[i] as usize;
                self.entries[place] = of_before[b * before.len() + a];
            }
        }
    }

    /// Sets `taken_out`: |measured signal|^2 minus |y|^2, where y is the measured signal minus a known torque.
    pub fn with_taken_out(self, taken_out: f64) -> Triangle {
        Triangle { taken_out, ..self }
    }

    /// Number p of columns, without the right-hand side.
    #[inline]
    pub fn columns(&self) -> usize {
        self.p
    }

    /// Entry (i, j) of the triangle, i <= j. Column j = p is the right-hand side; the absolute value of entry (p, p) is the norm
    /// of the residual.
    #[inline]
    pub fn at(&self, i: usize, j: usize) -> f64 {
        match (self.places[i], self.places[j]) {
            (NOT_LIVE, _) | (_, NOT_LIVE) => 0.0,
            (a, b) => self.entries[b as usize * self.live.len() + a as usize],
        }
    }

    /// The columns that have had a non-zero entry, ascending. Column number p is the right-hand side.
    pub fn live(&self) -> Vec<usize> {
        self.live.clone()
    }

    /// Makes a triangle from stored entries. `live`: non-zero columns, ascending, at most p; `rows`: number of rows folded in;
    /// `numbers`: entries of the live columns, the upper triangle column by column. `None` if there are too few numbers, or if
    /// `live` does not ascend or has a column beyond p.
    pub fn of_numbers(p: usize, live: &[usize], rows: usize, numbers: &[f64]) -> Option<Triangle> {
        let mut triangle = Triangle::new(p);
        let m = live.len();
        if live.iter().any(|&c| c > p) || !live.is_sorted_by(|a, b| a < b) || numbers.len() < m * (m + 1) / 2 {
            return None;
        }
        triangle.set_live(live.to_vec());
        let mut numbers = numbers.iter();
        for b in 0..m {
            triangle.entries[b * m..=b * m + b].iter_mut().zip(&mut numbers).for_each(|(entry, x)| *entry = *x);
        }
        triangle.rows = rows;
        Some(triangle)
    }

    /// Updates the triangle with the rows of a block, and empties the block. A row has the entries of all p columns, then the
    /// right-hand side.
    fn fold(&mut self, block: &mut RowBlock) {
        self.rows += block.rows;
        let stride = block.stride();
        let numbers = block.numbers();
        let holds = |c: usize| numbers.iter().skip(c).step_by(stride).any(|eight| eight.0 != [0.0; 8]);
        let live: Vec<usize> = (0..=self.p).filter(|&c| self.places[c] != NOT_LIVE || holds(c)).collect();
        if live.len() > self.live.len() {
            self.set_live(live);
        }
        let index: Vec<usize> = (0..self.live.len()).collect();
        reflect(&mut self.entries, self.live.len(), ColumnPlaces { index: &index, places: &self.live }, block);
        block.rows = 0;
    }

    /// The triangle of all rows that were folded into the triangles `parts`. Each triangle has `p` columns.
    pub fn sum<'a>(p: usize, parts: impl IntoIterator<Item = &'a Triangle>) -> Triangle {
        let mut sum = Triangle::new(p);
        parts.into_iter().for_each(|part| sum.merge(part, 1.0));
        sum
    }

    /// Updates the triangle with the rows of another triangle, each multiplied by `weight`.
    pub fn merge(&mut self, other: &Triangle, weight: f64) {
        let (m, rows) = (self.p + 1, self.rows + other.rows);
        self.taken_out += weight * weight * other.taken_out;
        if other.live.is_empty() {
            self.rows = rows;
            return;
        }
        let mut block = RowBlock::new(m);
        for i in 0..m {
            if block.is_full() {
                self.fold(&mut block);
            }
            block.push((0..m).map(|c| if i <= c { weight * other.at(i, c) } else { 0.0 }));
        }
        self.fold(&mut block);
        self.rows = rows;
    }

    /// Two sums over all rows: |measured signal|^2 and |W x - y|^2. y: right-hand side; |measured signal|^2 = |y|^2 +
    /// `taken_out`.
    pub fn squares(&self, x: &[f64]) -> (f64, f64) {
        let p = self.p;
        let mut total = self.taken_out;
        let mut residual = 0.0;
        for i in 0..=p {
            let z = self.at(i, p);
            let fit: f64 = (i..p).map(|j| self.at(i, j) * x[j]).sum();
            total += z * z;
            residual += (z - fit) * (z - fit);
        }
        (total, residual)
    }

    /// The least-squares solution x. The entry of a column that depends on the earlier columns is zero.
    pub fn solution(&self) -> Vec<f64> {
        let mut x = vec![0.0; self.p];
        for i in (0..self.p).rev().filter(|&i| self.has_information(i)) {
            let tail: f64 = (i + 1..self.p).map(|j| self.at(i, j) * x[j]).sum();
            x[i] = (self.at(i, self.p) - tail) / self.at(i, i);
        }
        x
    }

    /// Whether column c is linearly independent of the earlier columns.
    fn has_information(&self, c: usize) -> bool {
        self.at(c, c).abs() > DEPENDENT_COLUMN_SHARE * self.column_norm(c)
    }

    /// The diagonal entries (k, k) of (R'R)^-1 for k in `rows`: squared norms of rows of R^-1. A column that depends on earlier
    /// columns is left out; its entry is zero.
    pub fn inverse_products(&self, rows: Range<usize>) -> Vec<f64> {
        let informative: Vec<usize> = (rows.start..self.p).filter(|&c| self.has_information(c)).collect();
        let of_row = |k: usize| {
            let mut row = vec![0.0; self.p];
            for &j in informative.iter().skip_while(|&&j| j < k) {
                let before: f64 = (k..j).map(|i| row[i] * self.at(i, j)).sum();
                row[j] = (if j == k { 1.0 } else { 0.0 } - before) / self.at(j, j);
            }
            row.iter().map(|x| x * x).sum::<f64>()
        };
        rows.map(of_row).collect()
    }

    /// |W_c|, the norm of column c over all folded rows.
    pub fn column_norm(&self, c: usize) -> f64 {
        (0..=c).map(|i| self.at(i, c) * self.at(i, c)).sum::<f64>().sqrt()
    }
}

/// The triangle of the given columns of a triangle, in this order.
pub fn select(triangle: &Triangle, columns: &[usize]) -> Triangle {
    let p = triangle.columns();
    let mut out = TriangleBuilder::new(columns.len());
    let entry = |i: usize, j: usize| if i <= j { triangle.at(i, j) } else { 0.0 };
    for i in 0..=p {
        let row: Vec<f64> = columns.iter().map(|&c| entry(i, c)).collect();
        out.push(&row, entry(i, p));
    }
    let mut out = out.finish();
    (out.rows, out.taken_out) = (triangle.rows, triangle.taken_out);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    fn rows(seed: u64, n: usize, p: usize) -> Vec<Vec<f64>> {
        let mut random = Random::new(seed);
        (0..n).map(|_| (0..=p).map(|c| if c == 2 { 0.0 } else { random.normal() }).collect()).collect()
    }

    fn triangle(rows: &[Vec<f64>], p: usize) -> Triangle {
        let mut all = TriangleBuilder::new(p);
        rows.iter().for_each(|row| all.push(&row[..p], row[p]));
        all.finish()
    }

    #[test]
    fn numbers_make_the_triangle_again() {
        let found = triangle(&rows(3, 300, 5), 5);
        let live = found.live();
        assert_eq!(live, [0, 1, 3, 4, 5]);
        let numbers: Vec<f64> = live
            .iter()
            .enumerate()
            .flat_map(|(k, &j)| live[..=k].iter().map(move |&i| (i, j)))
            .map(|(i, j)| found.at(i, j))
            .collect();
        assert_eq!(Triangle::of_numbers(5, &live, 300, &numbers), Some(found));
        assert_eq!(Triangle::of_numbers(5, &live, 300, &numbers[1..]), None);
        assert_eq!(Triangle::of_numbers(5, &[6], 300, &numbers), None);
    }

    #[test]
    fn numbers_whose_squares_vanish_are_zero() {
        let mut rows = rows(7, 300, 4);
        rows.iter_mut().for_each(|row| row[1] *= 1e-160);
        let found = triangle(&rows, 4);
        assert!(found.entries.iter().all(|x| x.is_finite()));
        assert!(found.column_norm(1) < 1e-150 && found.column_norm(0) > 1.0);
    }

    #[test]
    fn a_negligible_column_takes_nothing_along() {
        let mut rows = rows(11, 300, 4);
        rows.iter_mut().for_each(|row| row[1] *= 1e-14);
        let mut found = ColumnTriangle::new(&[0, 1, 2, 3], &[0, 1, 2, 3, 4]);
        for rows in rows.chunks(8) {
            let mut block = RowBlock::new(5);
            rows.iter().for_each(|row| block.push(row.iter().copied()));
            found.fold(&mut block, rows.len());
        }
        let found = found.finish(4, &[1e-8; 4]);
        rows.iter_mut().for_each(|row| row[1] = 0.0);
        let without = triangle(&rows, 4);
        assert_eq!((found.rows, found.live()), (300, without.live()));
        let products = |t: &Triangle, a: usize, b: usize| (0..5).map(|i| t.at(i, a) * t.at(i, b)).sum::<f64>();
        for (a, b) in [(0, 0), (0, 3), (3, 3), (3, 4), (4, 4)] {
            // Allowed error: rounding of two sums of 300 products of order one.
            assert!((products(&found, a, b) - products(&without, a, b)).abs() < 1e-11 * 300.0, "{a} {b}");
        }
    }

    /// R'R = W'W, with the right-hand side as a column: the triangle keeps the whole least-squares problem.
    #[test]
    fn the_triangle_has_the_products_of_the_rows() {
        let p = 7;
        let rows = rows(1, 1500, p);
        let t = triangle(&rows, p);
        assert_eq!(t.rows, 1500);
        for i in 0..=p {
            for j in 0..=p {
                let rows: f64 = rows.iter().map(|r| r[i] * r[j]).sum();
                let triangle: f64 = (0..=i.min(j)).map(|k| t.at(k, i) * t.at(k, j)).sum();
                // Allowed error: rounding of sums of 1500 products of unit size, 1500 eps.
                assert!((rows - triangle).abs() < 1e-11, "{i} {j}: {rows} {triangle}");
            }
        }
    }

    #[test]
    fn parts_merge_and_weigh() {
        let p = 5;
        let rows = rows(2, 900, p);
        let whole = triangle(&rows, p);
        let mut merged = triangle(&rows[..400], p);
        merged.merge(&triangle(&rows[400..], p), 1.0);
        let scaled: Vec<Vec<f64>> = rows.iter().map(|r| r.iter().map(|x| 0.5 * x).collect()).collect();
        let mut weighed = Triangle::new(p);
        weighed.merge(&whole, 0.5);
        for (a, b) in [(&whole, &merged), (&triangle(&scaled, p), &weighed)] {
            for j in 0..=p {
                for i in 0..=j {
                    // The rows of a triangle are unique up to a sign, so absolute values are compared.
                    assert!((a.at(i, j).abs() - b.at(i, j).abs()).abs() < 1e-11);
                }
            }
        }
        let x = [1.0, -1.0, 0.5, 2.0, 0.0];
        let (total, residual) = whole.squares(&x);
        let direct: f64 = rows.iter().map(|r| (r[p] - (0..p).map(|c| r[c] * x[c]).sum::<f64>()).powi(2)).sum();
        assert!((residual - direct).abs() < 1e-9 * direct);
        assert!((total - rows.iter().map(|r| r[p] * r[p]).sum::<f64>()).abs() < 1e-9 * total);
        assert_eq!(whole.column_norm(2), 0.0);
    }

    /// `inverse_products` equals the diagonal of the inverse of the normal equations. The zero column is left out.
    #[test]
    fn products_of_the_inverse_are_those_of_the_normal_equations() {
        let found = triangle(&rows(4, 300, 6), 6);
        let determined = [0, 1, 3, 4, 5];
        let product = |a: usize, b: usize| {
            (0..=determined[a].min(determined[b]))
                .map(|k| found.at(k, determined[a]) * found.at(k, determined[b]))
                .sum()
        };
        let inverse: nalgebra::DMatrix<f64> = nalgebra::DMatrix::from_fn(5, 5, product).try_inverse().unwrap();
        assert_eq!(found.inverse_products(2..3), [0.0]);
        for (a, &c) in determined.iter().enumerate() {
            // Allowed error: a few eps, because the condition number of 300 random rows is below ten.
            assert!((found.inverse_products(c..6)[0] / inverse[(a, a)] - 1.0).abs() < 1e-12);
        }
    }
}
