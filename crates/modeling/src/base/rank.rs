//! Which columns of a matrix are independent, in their own order, and how clearly.
//!
//! The matrix is compressed to its triangle by QR [nalgebra]; then the columns are taken from left
//! to right: one is kept when its distance from the span of those kept before it, relative to its
//! own norm, is above the threshold [Gautier 1991]. Columns far smaller than the largest count as
//! zero: a truncated pi leaves columns of 1e-10 behind, which scaling to one would make count.

use nalgebra::{DMatrix, DVector};

/// Distance, relative to the column's norm, from which a column is independent.
pub(crate) const INDEPENDENT: f64 = 1e-7;
/// Norm, relative to the largest column's, below which a column is zero.
const NEGLIGIBLE: f64 = 1e-9;
/// A rank is clear-cut when the largest dropped distance is this many times below the smallest kept.
pub(crate) const CLEAR_GAP: f64 = 1e3;

/// The outcome of the scan.
#[derive(Clone, Debug)]
pub(crate) struct Scan {
    /// Columns kept, ascending.
    pub kept: Vec<usize>,
    /// Columns that are zero, ascending.
    pub zero: Vec<usize>,
    /// Columns in the span of kept ones before them, with the coefficient of each kept column.
    pub dependent: Vec<(usize, Vec<f64>)>,
    /// Relative distance of each column (of a zero column: its relative norm).
    pub distance: Vec<f64>,
    /// The same distance relative to the norm of the largest column.
    pub share: Vec<f64>,
}

pub(crate) fn scan(matrix: DMatrix<f64>) -> Scan {
    let p = matrix.ncols();
    let triangle = matrix.qr().unpack_r();
    let norms: Vec<f64> = triangle.column_iter().map(|c| c.norm()).collect();
    let largest = norms.iter().fold(0.0, |a: f64, &b| a.max(b));

    let mut s = Scan { kept: vec![], zero: vec![], dependent: vec![], distance: vec![0.0; p], share: vec![0.0; p] };
    let mut basis: Vec<DVector<f64>> = Vec::new();
    // kept column k = sum_i basis_i factors[k][i]
    let mut factors: Vec<Vec<f64>> = Vec::new();
    for c in 0..p {
        if norms[c] <= NEGLIGIBLE * largest {
            s.zero.push(c);
            s.distance[c] = if largest > 0.0 { norms[c] / largest } else { 0.0 };
            continue;
        }
        let mut v: DVector<f64> = triangle.column(c).into_owned();
        let mut along = vec![0.0; basis.len()];
        // Twice is enough [Parlett, after Kahan].
        for _ in 0..2 {
            for (b, a) in basis.iter().zip(&mut along) {
                let projection = b.dot(&v);
                v.axpy(-projection, b, 1.0);
                *a += projection;
            }
        }
        s.distance[c] = v.norm() / norms[c];
        s.share[c] = v.norm() / largest;
        if s.distance[c] > INDEPENDENT {
            let norm = v.norm();
            along.push(norm);
            basis.push(v / norm);
            factors.push(along);
            s.kept.push(c);
        } else {
            s.dependent.push((c, along));
        }
    }
    // From coefficients along the basis to coefficients along the kept columns.
    for (_, x) in &mut s.dependent {
        for k in (0..x.len()).rev() {
            x[k] /= factors[k][k];
            for i in 0..k {
                x[i] -= x[k] * factors[k][i];
            }
        }
        x.resize(s.kept.len(), 0.0);
    }
    s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_leftmost_independent_columns() {
        // a, 0, b, 2a - 3b, c + 1e-12 noise, a
        let (a, b, c) = ([1.0, 2.0, 3.0, 4.0], [0.0, 1.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0]);
        let matrix = DMatrix::from_fn(4, 6, |r, k| match k {
            0 | 5 => a[r],
            1 => 1e-14 * c[r],
            2 => b[r],
            3 => 2.0 * a[r] - 3.0 * b[r],
            _ => c[r],
        });
        let s = scan(matrix);
        assert_eq!((s.kept, s.zero), (vec![0, 2, 4], vec![1]));
        assert_eq!(s.dependent.iter().map(|d| d.0).collect::<Vec<_>>(), [3, 5]);
        for (found, expected) in s.dependent[0].1.iter().zip([2.0, -3.0, 0.0]) {
            assert!((found - expected).abs() < 1e-13);
        }
    }
}
