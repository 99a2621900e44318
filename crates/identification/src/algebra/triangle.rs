//! Streaming least squares: rows go into a triangle and are forgotten.
//!
//! [W y] = Q [R z; 0 rho] for all rows seen so far. A block B of rows is folded in by Householder
//! reflections that annihilate B below R: v = [e_k; B_k / (R_kk - beta)], beta = -sign(R_kk)
//! sqrt(R_kk^2 + |B_k|^2). Triangles of parts merge by folding the rows of one into the other.
//! [Golub, Van Loan 2013, 5.2 and 12.5 for updating]
//!
//! | symbol | code | shape | |
//! |---|---|---|---|
//! | R, z, rho | `entries` | (p + 1) x (p + 1), upper, column by column | the unit of y per unit of the parameter |
//!
//! A column that has held only zeros costs nothing. Weights are not here: the triangle of a joint is scaled as a
//! whole when it is merged.

/// The triangle of p columns and one right-hand side.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangle {
    p: usize,
    /// Entry (i, j) of the triangle, i <= j <= p, at j (p + 1) + i.
    entries: Vec<f64>,
    /// Columns that have held something other than zeros.
    live: Vec<bool>,
    /// Rows folded in.
    pub rows: usize,
}

/// Rows on their way into a triangle.
#[derive(Clone, Debug)]
pub struct Accumulator {
    triangle: Triangle,
    block: Block,
}

impl Accumulator {
    /// No row yet, with `p` columns and a right-hand side.
    pub fn new(p: usize) -> Accumulator {
        Accumulator { triangle: Triangle::new(p), block: Block::new(p) }
    }

    /// Appends a row of coefficients and its right-hand side.
    ///
    /// # Panics
    /// When `row` is not p long.
    pub fn push(&mut self, row: &[f64], y: f64) {
        if self.block.is_full() {
            self.triangle.fold(&mut self.block);
        }
        self.block.push(row, y);
    }

    /// The triangle of all rows.
    pub fn finish(mut self) -> Triangle {
        self.triangle.fold(&mut self.block);
        self.triangle
    }
}

/// Rows side by side, column by column.
#[derive(Clone, Debug)]
struct Block {
    columns: usize,
    capacity: usize,
    rows: usize,
    /// Column c at `c * capacity`; p parameters, then the right-hand side.
    entries: Vec<f64>,
}

/// Rows in a block: with a hundred columns it stays in the second-level cache.
const BLOCK_ROWS: usize = 512;

impl Block {
    fn new(p: usize) -> Block {
        let capacity = BLOCK_ROWS;
        Block { columns: p + 1, capacity, rows: 0, entries: vec![0.0; (p + 1) * capacity] }
    }

    fn is_full(&self) -> bool {
        self.rows == self.capacity
    }

    fn push(&mut self, row: &[f64], y: f64) {
        assert!(!self.is_full() && row.len() + 1 == self.columns);
        for (c, &x) in row.iter().chain(std::iter::once(&y)).enumerate() {
            self.entries[c * self.capacity + self.rows] = x;
        }
        self.rows += 1;
    }
}

impl Triangle {
    /// The triangle of no rows with `p` columns and a right-hand side.
    pub fn new(p: usize) -> Triangle {
        Triangle { p, entries: vec![0.0; (p + 1) * (p + 1)], live: vec![false; p + 1], rows: 0 }
    }

    /// Number of columns without the right-hand side.
    pub fn columns(&self) -> usize {
        self.p
    }

    /// Entry (i, j), i <= j; j = p is the right-hand side, (p, p) the norm of the residual.
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.entries[j * (self.p + 1) + i]
    }

    /// Folds the rows of a block in and empties it.
    fn fold(&mut self, block: &mut Block) {
        self.rows += block.rows;
        self.reflect(&mut block.entries, block.capacity, block.rows);
        block.rows = 0;
    }

    /// Adds the rows behind another triangle, each multiplied by `weight`.
    pub fn merge(&mut self, other: &Triangle, weight: f64) {
        let m = self.p + 1;
        let mut rows: Vec<f64> = other.entries.iter().map(|x| weight * x).collect();
        self.reflect(&mut rows, m, m);
        self.rows += other.rows;
    }

    /// Annihilates `b` (column c at `c * stride`, `rows` long) under the triangle.
    fn reflect(&mut self, b: &mut [f64], stride: usize, rows: usize) {
        let m = self.p + 1;
        for (c, live) in self.live.iter_mut().enumerate() {
            *live = *live || b[c * stride..c * stride + rows].iter().any(|&x| x != 0.0);
        }
        for k in 0..m {
            let (left, right) = b.split_at_mut((k + 1) * stride);
            let v = &mut left[k * stride..k * stride + rows];
            let below = dot(v, v);
            if below == 0.0 {
                continue;
            }
            let r = self.entries[k * m + k];
            let beta = -r.signum() * r.hypot(below.sqrt());
            let scale = 1.0 / (r - beta);
            v.iter_mut().for_each(|x| *x *= scale);
            let tau = (beta - r) / beta;
            self.entries[k * m + k] = beta;
            for j in (k + 1..m).filter(|&j| self.live[j]) {
                let column = &mut right[(j - k - 1) * stride..(j - k - 1) * stride + rows];
                let top = &mut self.entries[j * m + k];
                let w = tau * (*top + dot(v, column));
                if w != 0.0 {
                    *top -= w;
                    axpy(-w, v, column);
                }
            }
        }
    }

    /// |y|^2 and |W x - y|^2 of the rows behind the triangle.
    pub fn squares(&self, x: &[f64]) -> (f64, f64) {
        let p = self.p;
        let mut total = 0.0;
        let mut residual = 0.0;
        for i in 0..=p {
            let z = self.at(i, p);
            let fit: f64 = (i..p).map(|j| self.at(i, j) * x[j]).sum();
            total += z * z;
            residual += (z - fit) * (z - fit);
        }
        (total, residual)
    }

    /// |W_c|, the norm of a column of the rows.
    pub fn column_norm(&self, c: usize) -> f64 {
        (0..=c).map(|i| self.at(i, c) * self.at(i, c)).sum::<f64>().sqrt()
    }
}

/// Sum of products, in thirty-two running sums that fill the processor's vectors.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 32;
    let mut sums = [0.0; LANES];
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (b, b_rest) = b.as_chunks::<LANES>();
    for (a, b) in a.iter().zip(b) {
        for l in 0..LANES {
            sums[l] += a[l] * b[l];
        }
    }
    let mut width = LANES / 2;
    while width > 0 {
        for l in 0..width {
            sums[l] += sums[l + width];
        }
        width /= 2;
    }
    sums[0] + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}

fn axpy(w: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += w * x;
    }
}

/// The triangle of some of the columns.
pub fn select(triangle: &Triangle, columns: &[usize]) -> Triangle {
    let p = triangle.columns();
    let mut out = Triangle::new(columns.len());
    let mut block = Block::new(columns.len());
    let entry = |i: usize, j: usize| if i <= j { triangle.at(i, j) } else { 0.0 };
    for i in 0..=p {
        if block.is_full() {
            out.fold(&mut block);
        }
        let row: Vec<f64> = columns.iter().map(|&c| entry(i, c)).collect();
        block.push(&row, entry(i, p));
    }
    out.fold(&mut block);
    out.rows = triangle.rows;
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::random::Random;

    fn rows(seed: u64, n: usize, p: usize) -> Vec<Vec<f64>> {
        let mut random = Random::new(seed);
        (0..n).map(|_| (0..=p).map(|c| if c == 2 { 0.0 } else { random.normal() }).collect()).collect()
    }

    fn triangle(rows: &[Vec<f64>], p: usize) -> Triangle {
        let (mut triangle, mut block) = (Triangle::new(p), Block::new(p));
        for row in rows {
            if block.is_full() {
                triangle.fold(&mut block);
            }
            block.push(&row[..p], row[p]);
        }
        triangle.fold(&mut block);
        triangle
    }

    /// R'R = W'W for the rows and the right-hand side: nothing of the least-squares problem is lost.
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
                // Sums of 1500 products of unit size: 1500 eps.
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
                    // The rows of a triangle are free up to a sign; these have the same history of pivots.
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
}
