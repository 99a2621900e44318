//! The optimality criterion J of a motion from the rows of its regressor W, and the gradient of J by the entries of W.
//!
//! F = W'W / samples, p x p for p parameters. C: F scaled to a unit diagonal. J is minimised:
//!
//! determinant: J = -log det F / p,                dJ/dF = -F^-1 / p
//! condition:   J = log(p tr C^-1) / 2, the logarithm of the Frobenius condition number of the scaled columns,
//!              dJ/dF = [diag((F^-1)_cc) - F^-1 diag(F_cc) F^-1] / (2 tr C^-1)
//!
//! and dJ/dW = 2 W dJ/dF / samples. The rows of a joint are zero in the columns of the links before it, so each joint stores only
//! the columns of its own link and of the links after it; this saves two thirds of the products. Scaling a column adds only a
//! constant to J.

use numerics::information_matrix::{add_products as add_row_products, log_det_and_inverse};
use numerics::reflection::{add_products, combine};
use numerics::row_block::{BLOCK_ROWS, RowBlock};
use processor::in_parallel;
use serde::{Deserialize, Serialize};

/// The criterion that a search for a motion optimises.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SearchObjective {
    /// Maximise the determinant of the information matrix W'W; W: regressor of the motion.
    Determinant,
    /// Minimise the condition number (Frobenius norm) of the regressor W after scaling its columns to unit norm.
    Condition,
}

/// The rows of the regressor W that belong to one joint.
#[derive(Clone, Debug)]
pub struct CriterionRows {
    /// Indices of the columns of the regressor W in which these rows may differ from zero.
    columns: Vec<usize>,
    /// Entries of the rows, one per column in `columns`, followed by equally many derivatives of the criterion J by these
    /// entries.
    blocks: Vec<RowBlock>,
}

impl CriterionRows {
    /// Makes an empty set of rows whose entries are in these columns of the regressor W.
    pub fn new(columns: Vec<usize>) -> CriterionRows {
        CriterionRows { columns, blocks: vec![] }
    }

    /// The columns of the regressor W in which the rows have entries.
    pub fn columns(&self) -> &[usize] {
        &self.columns
    }

    /// Appends a row of the regressor W with one entry per column in `columns`.
    pub fn push(&mut self, row: impl Iterator<Item = f64>) {
        let width = 2 * self.columns.len();
        if self.blocks.last().is_none_or(RowBlock::is_full) {
            self.blocks.push(RowBlock::new(width));
        }
        if let Some(block) = self.blocks.last_mut() {
            block.push(row);
        }
    }

    /// The dot products of all pairs of columns of these rows W, that is W'W. The product of the columns i <= j is at the index j
    /// m + i; m: number of columns.
    fn products(&mut self) -> Vec<f64> {
        let m = self.columns.len();
        let places: Vec<usize> = (0..m).collect();
        let mut products = vec![0.0; m * m];
        self.blocks.iter_mut().filter(|_| m > 0).for_each(|block| add_products(&mut products, &places, block));
        products
    }

    /// The derivatives of the criterion J by the entries of up to eight rows of the regressor W, one slice per column. `first`:
    /// number of the first row, a multiple of eight. `None` after the last row.
    pub fn slopes(&self, first: usize) -> Option<impl Iterator<Item = &[f64]>> {
        let m = self.columns.len();
        let block = self.blocks.get(first / BLOCK_ROWS)?;
        let row = first % BLOCK_ROWS;
        let count = block.rows.checked_sub(row).filter(|rows| *rows > 0)?.min(8);
        Some(block.rows_from(row)[m..2 * m].iter().map(move |eight| &eight.0[..count]))
    }
}

/// The value of the optimality criterion J for one motion, with the data for its gradient.
pub struct Criterion {
    /// The value of the criterion J; a smaller value is better.
    pub value: f64,
    aim: SearchObjective,
    rows: Vec<CriterionRows>,
    threads: usize,
    /// Factor that scales each column of the regressor W to unit norm.
    scale: Vec<f64>,
    /// Inverse of C, p x p for p parameters. C is the information matrix W'W scaled to a unit diagonal.
    inverse: Vec<f64>,
}

/// Computes the criterion J from the regressor rows of all joints and from `others`, further rows with p entries each, on
/// `threads` threads. `None` if the rows do not have full rank.
pub fn criterion(
    aim: SearchObjective,
    rows: Vec<CriterionRows>,
    others: &[f64],
    p: usize,
    samples: usize,
    threads: usize,
) -> Option<Criterion> {
    let mut lower = vec![0.0; p * p];
    add_row_products(&mut lower, p, others, |_| 1.0);
    let all = in_parallel(rows, threads, |mut rows: CriterionRows| (rows.products(), rows));
    for (products, CriterionRows { columns, .. }) in &all {
        for (j, products) in products.chunks_exact(columns.len().max(1)).enumerate() {
            for (i, product) in products.iter().enumerate().take(j + 1) {
                let (a, b) = (columns[i].max(columns[j]), columns[i].min(columns[j]));
                lower[a * p + b] += product;
            }
        }
    }
    // C is the information matrix W'W scaled to a unit diagonal. The scale factor of a zero column is not finite.
    let rows = all.into_iter().map(|(_, rows)| rows).collect();
    let squares: Vec<f64> = (0..p).map(|c| lower[c * p + c]).collect();
    let scale: Vec<f64> = squares.iter().map(|s| 1.0 / s.sqrt()).collect();
    if p == 0 || scale.iter().any(|s| !s.is_finite()) {
        return None;
    }
    for (i, row) in lower.chunks_exact_mut(p).enumerate() {
        row.iter_mut().zip(&scale).for_each(|(x, s)| *x *= scale[i] * s);
        row[i] = 1.0;
    }
    let (log_det, inverse) = log_det_and_inverse(&lower, p)?;
    // Each diagonal entry of the inverse is the variance inflation factor of a column: one over the squared distance of the unit
    // column from the span of the other columns.
    if (0..p).any(|c| inverse[c * p + c].is_nan() || inverse[c * p + c] > MAX_VARIANCE_INFLATION) {
        return None;
    }
    let columns = p as f64;
    let value = match aim {
        SearchObjective::Determinant => {
            let of_scale: f64 = squares.iter().map(|s| (s / samples as f64).ln()).sum();
            -(log_det + of_scale) / columns
        }
        SearchObjective::Condition => 0.5 * (columns * trace(&inverse, p)).ln(),
    };
    Some(Criterion { value, aim, rows, threads, scale, inverse })
}

/// Greatest accepted variance inflation of a column of the regressor by the other columns. Above this value, rounding errors
/// dominate: they are 1e-16 of the entries of W'W.
const MAX_VARIANCE_INFLATION: f64 = 1e13;

fn trace(matrix: &[f64], p: usize) -> f64 {
    (0..p).map(|i| matrix[i * p + i]).sum()
}

impl Criterion {
    /// The rows of the regressor W with the derivative of the criterion J by each of their entries.
    pub fn slope(self) -> Vec<CriterionRows> {
        let Criterion { aim, rows, threads, scale, inverse, .. } = self;
        let p = scale.len();
        // First dJ/dC; C: information matrix W'W scaled to a unit diagonal. Then dJ/dW = 2 W (scale dJ/dC scale).
        let of_c: Vec<f64> = match aim {
            SearchObjective::Determinant => inverse.iter().map(|x| -x / p as f64).collect(),
            SearchObjective::Condition => {
                let trace = trace(&inverse, p);
                let entry = |at: usize| {
                    let (i, j) = (at / p, at % p);
                    let product: f64 =
                        inverse[i * p..][..p].iter().zip(&inverse[j * p..][..p]).map(|(a, b)| a * b).sum();
                    let own = if i == j { inverse[at] } else { 0.0 };
                    (own - product) / (2.0 * trace)
                };
                (0..p * p).map(entry).collect()
            }
        };
        in_parallel(rows, threads, |mut rows| {
            let CriterionRows { columns, blocks } = &mut rows;
            let factor = |b: usize, a: usize| 2.0 * scale[b] * scale[a] * of_c[b * p + a];
            let factors: Vec<f64> =
                columns.iter().flat_map(|&b| columns.iter().map(move |&a| (b, a))).map(|(b, a)| factor(b, a)).collect();
            blocks.iter_mut().for_each(|block| combine(&factors, columns.len(), block));
            rows
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    #[test]
    fn slopes_are_those_of_central_differences() {
        let (p, samples) = (4, 9);
        let mut random = Random::new(2);
        let scales = [1.0, 30.0, 0.02, 4.0];
        let w: Vec<f64> = (0..p * samples).map(|k| random.normal() * scales[k % p]).collect();
        // Regressor rows of two joints. The rows of the second joint have no entry in the first column.
        let rows = |w: &[f64]| {
            let mut joints = vec![CriterionRows::new((0..p).collect()), CriterionRows::new((1..p).collect())];
            w.chunks_exact(p).enumerate().for_each(|(r, row)| joints[r % 2].push(row[r % 2..].iter().copied()));
            joints
        };
        let others = [0.1, 2.0, 0.01, 0.5];
        for aim in [SearchObjective::Determinant, SearchObjective::Condition] {
            let at = |w: &[f64]| criterion(aim, rows(w), &others, p, samples, 2).unwrap();
            let mut slopes = vec![0.0; w.len()];
            for (i, joint) in at(&w).slope().into_iter().enumerate() {
                let column = joint.columns()[0];
                for (place, of_rows) in joint.slopes(0).unwrap().enumerate() {
                    for (r, slope) in of_rows.iter().enumerate() {
                        slopes[(2 * r + i) * p + column + place] = *slope;
                    }
                }
                assert!(joint.slopes(8).is_none());
            }
            for k in (0..w.len()).filter(|k| k % p > 0 || k / p % 2 == 0) {
                let h = 1e-6 * scales[k % p];
                let moved = |h: f64| {
                    let mut w = w.clone();
                    w[k] += h;
                    at(&w).value
                };
                let slope = (moved(h) - moved(-h)) / (2.0 * h);
                // Rounding error of the central differences: 1e-16 / 1e-6, divided by the scale of the column.
                assert!((slopes[k] - slope).abs() < 1e-7 / scales[k % p], "{aim:?} {k}: {} {slope}", slopes[k]);
            }
        }
        let mut lost = w.clone();
        lost.chunks_exact_mut(p).for_each(|row| row[1] = 2.0 * row[2]);
        assert!(criterion(SearchObjective::Determinant, rows(&lost), &[], p, samples, 1).is_none());
    }
}
