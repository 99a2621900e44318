//! The information matrix F = sum W_i' W_i of weighted rows W_i, and its Cholesky factor.
//!
//! The matrices are dense and symmetric, p x p with p from ten to a hundred, stored row by row. This code is the inner loop of
//! the planning of experiments: to evaluate one candidate experiment takes a few thousand operations.

use processor::{Work, widely};

/// Weighted rows of the observation matrix W: m rows of p entries, stored row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightedRows {
    width: usize,
    entries: Vec<f64>,
}

impl WeightedRows {
    /// Makes an empty set of rows with `width` columns.
    pub fn new(width: usize) -> WeightedRows {
        WeightedRows { width, entries: vec![] }
    }

    /// Makes the rows from `entries`, which are stored row by row, `width` entries per row.
    pub fn of(width: usize, entries: Vec<f64>) -> WeightedRows {
        WeightedRows { width, entries }
    }

    /// Appends one row. A longer row is cut to the width, a shorter one is filled with zeros.
    #[inline]
    pub fn push(&mut self, row: &[f64]) {
        let missing = self.width.saturating_sub(row.len());
        self.entries.extend(row.iter().take(self.width));
        self.entries.extend(std::iter::repeat_n(0.0, missing));
    }

    /// Number of columns.
    #[inline]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    #[inline]
    pub fn len(&self) -> usize {
        self.entries.len().checked_div(self.width).unwrap_or(0)
    }

    /// Whether there is no row.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The rows, in their order.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = &[f64]> {
        self.entries.chunks_exact(self.width.max(1))
    }

    /// A copy in which each column is multiplied by its factor.
    pub fn scaled(&self, factors: &[f64]) -> WeightedRows {
        let entries = self.iter().flat_map(|row| row.iter().zip(factors).map(|(x, f)| x * f)).collect();
        WeightedRows { width: self.width, entries }
    }

    /// Sum of the squares of all entries, which is the trace of W'W.
    pub fn trace(&self) -> f64 {
        self.entries.iter().map(|x| x * x).sum()
    }
}

/// The information matrix F = sum W_i' W_i, p x p. Only its lower triangle is used.
#[derive(Clone, Debug)]
pub struct InformationMatrix {
    p: usize,
    entries: Vec<f64>,
}

/// The Cholesky factor L of F = L L', stored as log det F and L^-1.
#[derive(Clone, Debug)]
pub struct InformationFactor {
    p: usize,
    /// The logarithm of the determinant of F.
    pub log_det: f64,
    /// L^-1, p x p row by row, with its zeros above the diagonal.
    inverse: Vec<f64>,
}

impl InformationMatrix {
    /// Makes F = `scale` times the p x p identity.
    pub fn diagonal(p: usize, scale: f64) -> InformationMatrix {
        let mut f = InformationMatrix { p, entries: vec![0.0; p * p] };
        (0..p).for_each(|i| f.entries[i * p + i] = scale);
        f
    }

    /// Makes F = sum weight W'W over blocks of rows W with their weights, plus `ridge` times the identity.
    pub fn sum<'a>(
        p: usize,
        ridge: f64,
        blocks: impl IntoIterator<Item = (&'a WeightedRows, f64)>,
    ) -> InformationMatrix {
        let mut f = InformationMatrix::diagonal(p, ridge);
        blocks.into_iter().for_each(|(rows, weight)| f.add(rows, weight));
        f
    }

    /// Adds weight W'W of the rows W to F.
    pub fn add(&mut self, rows: &WeightedRows, weight: f64) {
        add_products(&mut self.entries, self.p, &rows.entries, |_| weight);
    }

    /// Trace of F: the sum of its diagonal.
    pub fn trace(&self) -> f64 {
        (0..self.p).map(|i| self.entries[i * self.p + i]).sum()
    }

    /// Entry (i, j) of F.
    #[inline]
    pub fn at(&self, i: usize, j: usize) -> f64 {
        if i >= j { self.entries[i * self.p + j] } else { self.entries[j * self.p + i] }
    }

    /// The Cholesky factor of F. `None` if F is not positive definite.
    pub fn factor(&self) -> Option<InformationFactor> {
        let p = self.p;
        let mut l = self.entries.clone();
        let mut log_det = 0.0;
        for j in 0..p {
            for i in j..p {
                let s: f64 = (0..j).map(|k| l[i * p + k] * l[j * p + k]).sum();
                let reduced = l[i * p + j] - s;
                if i == j {
                    if reduced.is_nan() || reduced <= 0.0 {
                        return None;
                    }
                    log_det += reduced.ln();
                    l[j * p + j] = reduced.sqrt();
                } else {
                    l[i * p + j] = reduced / l[j * p + j];
                }
            }
        }
        let mut inverse = vec![0.0; p * p];
        for j in 0..p {
            inverse[j * p + j] = 1.0 / l[j * p + j];
            for i in j + 1..p {
                let s: f64 = (j..i).map(|k| l[i * p + k] * inverse[k * p + j]).sum();
                inverse[i * p + j] = -s / l[i * p + i];
            }
        }
        Some(InformationFactor { p, log_det, inverse })
    }
}

/// log det F and F^-1 (p x p, row by row) of a symmetric positive definite F. `lower`: F, p x p, of which only the lower triangle
/// is read. `None` if F is not positive definite.
///
/// Every inner loop runs along rows, which is faster in the cache if p is about a hundred or larger.
pub fn log_det_and_inverse(lower: &[f64], p: usize) -> Option<(f64, Vec<f64>)> {
    widely(Inversion { lower, p })
}

struct Inversion<'a> {
    lower: &'a [f64],
    p: usize,
}

impl Work for Inversion<'_> {
    type Output = Option<(f64, Vec<f64>)>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Inversion { lower, p } = self;
        // Factorise F = U'U, row by row from the top.
        let mut u = vec![0.0; p * p];
        (0..p).for_each(|i| (i..p).for_each(|j| u[i * p + j] = lower[j * p + i]));
        let mut log_det = 0.0;
        for k in 0..p {
            let (above, below) = u.split_at_mut((k + 1) * p);
            let row = &mut above[k * p..];
            let pivot = row[k];
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            log_det += pivot.ln();
            let root = pivot.sqrt();
            row[k..].iter_mut().for_each(|x| *x /= root);
            for (j, other) in (k + 1..p).zip(below.chunks_exact_mut(p)) {
                subtract(&mut other[j..], row[j], &row[j..]);
            }
        }
        // Compute L^-1 = U'^-1 by elimination.
        let mut inverse = vec![0.0; p * p];
        for k in 0..p {
            let (above, below) = inverse.split_at_mut((k + 1) * p);
            let row = &mut above[k * p..][..k + 1];
            row[k] = 1.0;
            row.iter_mut().for_each(|x| *x /= u[k * p + k]);
            for (j, other) in (k + 1..p).zip(below.chunks_exact_mut(p)) {
                subtract(&mut other[..k + 1], u[k * p + j], row);
            }
        }
        let mut f = vec![0.0; p * p];
        add_products(&mut f, p, &inverse, |_| 1.0);
        for i in 0..p {
            (0..i).for_each(|j| f[j * p + i] = f[i * p + j]);
        }
        Some((log_det, f))
    }
}

/// x -= factor y. The loop runs over indices and not over iterators, because functions of iterators may be compiled separately,
/// without wide SIMD registers.
#[inline(always)]
fn subtract(x: &mut [f64], factor: f64, y: &[f64]) {
    let y = &y[..x.len()];
    for i in 0..x.len() {
        x[i] -= factor * y[i];
    }
}

/// Number of rows that [`add_products`] adds in one pass.
const ROWS_PER_PASS: usize = 4;

/// Adds the sum of weight(r) row_r row_r' over all rows r to the lower triangle of a p x p matrix. Each entry is summed in the
/// order of the rows, so the result does not depend on the number of rows in one pass.
#[inline(always)]
pub fn add_products(lower: &mut [f64], p: usize, rows: &[f64], weight: impl Fn(usize) -> f64) {
    let whole = rows.len() / p.max(1) / ROWS_PER_PASS * ROWS_PER_PASS;
    let (blocks, rest) = rows.split_at(whole * p);
    for (b, block) in blocks.chunks_exact(ROWS_PER_PASS * p.max(1)).enumerate() {
        let weights: [f64; ROWS_PER_PASS] = std::array::from_fn(|r| weight(ROWS_PER_PASS * b + r));
        for i in 0..p {
            let x: [f64; ROWS_PER_PASS] = std::array::from_fn(|r| weights[r] * block[r * p + i]);
            if x.iter().all(|x| *x == 0.0) {
                continue;
            }
            let y: [&[f64]; ROWS_PER_PASS] = std::array::from_fn(|r| &block[r * p..][..i + 1]);
            let entries = &mut lower[i * p..][..i + 1];
            for j in 0..i + 1 {
                entries[j] = (0..ROWS_PER_PASS).fold(entries[j], |sum, r| sum + x[r] * y[r][j]);
            }
        }
    }
    for (r, row) in rest.chunks_exact(p.max(1)).enumerate() {
        let weight = weight(whole + r);
        for i in 0..p {
            let x = weight * row[i];
            let entries = &mut lower[i * p..][..i + 1];
            for j in 0..i + 1 {
                entries[j] += x * row[j];
            }
        }
    }
}

impl InformationFactor {
    /// Writes L^-1 x into `out`, both of p entries. The squared norm of the result is x' F^-1 x.
    #[inline]
    pub fn whiten(&self, x: &[f64], out: &mut [f64]) {
        let p = self.p;
        for i in 0..p {
            out[i] = self.inverse[i * p..i * p + i + 1].iter().zip(x).map(|(l, x)| l * x).sum();
        }
    }

    /// The matrix F^-1, p x p, row by row.
    pub fn inverse(&self) -> Vec<f64> {
        let p = self.p;
        let mut f = vec![0.0; p * p];
        for i in 0..p {
            for j in 0..=i {
                let s = (i..p).map(|k| self.inverse[k * p + i] * self.inverse[k * p + j]).sum();
                f[i * p + j] = s;
                f[j * p + i] = s;
            }
        }
        f
    }

    /// The matrix L^-1 L^-T of F = L L', p x p, row by row. The diagonal contains the squared norms of the rows of L^-1.
    pub fn inverse_gram(&self) -> Vec<f64> {
        let p = self.p;
        let row = |i: usize| &self.inverse[i * p..i * p + p];
        let dot = |i: usize, j: usize| row(i).iter().zip(row(j)).map(|(a, b)| a * b).sum();
        (0..p * p).map(|at| dot(at / p, at % p)).collect()
    }

    /// tr F^-1, computed as the sum of the squares of the entries of L^-1.
    pub fn trace_of_inverse(&self) -> f64 {
        self.inverse.iter().map(|x| x * x).sum()
    }

    /// tr(W F^-1 W') of rows W that are not in F: the sum of the variances of the predictions of these rows. `out`: work space
    /// of p entries.
    #[inline]
    pub fn variance(&self, rows: &WeightedRows, out: &mut [f64]) -> f64 {
        rows.iter()
            .map(|row| {
                self.whiten(row, out);
                out.iter().map(|x| x * x).sum::<f64>()
            })
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    #[test]
    fn factor_inverse_determinant() {
        let mut random = Random::new(1);
        let mut rows = WeightedRows::new(6);
        for _ in 0..9 {
            rows.push(&(0..6).map(|_| random.normal()).collect::<Vec<_>>());
        }
        let f = InformationMatrix::sum(6, 0.0, [(&rows, 2.0)]);
        let factor = f.factor().unwrap();
        let inverse = factor.inverse();
        for i in 0..6 {
            for j in 0..6 {
                let product: f64 = (0..6).map(|k| f.at(i, k) * inverse[k * 6 + j]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-10);
            }
        }
        let lower: Vec<f64> = (0..36).map(|k| f.at(k / 6, k % 6)).collect();
        let (log_det, again) = log_det_and_inverse(&lower, 6).unwrap();
        assert!((log_det - factor.log_det).abs() < 1e-12);
        assert!(inverse.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(log_det_and_inverse(&[-1.0], 1).is_none());
        let trace: f64 = (0..6).map(|i| inverse[i * 7]).sum();
        assert!((trace - factor.trace_of_inverse()).abs() < 1e-10 * trace);
        let doubled = InformationMatrix::sum(6, 0.0, [(&rows, 4.0)]).factor().unwrap();
        assert!((doubled.log_det - factor.log_det - 6.0 * 2.0_f64.ln()).abs() < 1e-10);
        // With F = 2 W'W, tr(W F^-1 W') is p/2.
        assert!((factor.variance(&rows, &mut [0.0; 6]) - 3.0).abs() < 1e-10);
        let lost = rows.scaled(&[1.0, 1.0, 0.0, 1.0, 1.0, 1.0]);
        assert!(InformationMatrix::sum(6, 0.0, [(&lost, 1.0)]).factor().is_none());
    }
}
