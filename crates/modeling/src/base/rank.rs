//! Finds the independent columns of a matrix from left to right, and the distance of each column from the span of the kept
//! columns before it.
//!
//! The matrix is compressed to its triangle by QR (`triangle`). Then the columns are taken from left to right: a column is kept
//! if its distance from the span of the columns kept before it, relative to its own norm, is above the threshold [Gautier 1991].
//! Columns far smaller than the largest are treated as zero: a truncated pi causes columns of 1e-10, which would count as
//! independent if they were scaled to one. If the columns are chosen elsewhere ([`crate::base::exact_rank`]), the scan gives the
//! distance of each chosen column.

use nalgebra::{DMatrix, DVector};

use crate::base::triangle::triangle;

/// A column is independent if its distance from the span of the columns kept before it, divided by its norm, is above this
/// value.
pub(crate) const INDEPENDENT: f64 = 1e-7;
/// A column is treated as zero if its norm is at most this share of the norm of the largest column.
const NEGLIGIBLE_PIVOT_RATIO: f64 = 1e-9;
/// The numeric rank is clear-cut if the smallest distance of a kept column is at least this many times the largest distance of a
/// dropped column.
pub(crate) const CLEAR_GAP: f64 = 1e3;

/// The result of a scan of columns from left to right. The distance of a column is its distance from the span of the columns
/// kept before it.
#[derive(Clone, Debug, Default)]
pub struct Scan {
    /// Indices of the columns that are kept, ascending.
    pub kept: Vec<usize>,
    /// Indices of the columns that are zero (negligible), ascending.
    pub zero: Vec<usize>,
    /// Columns in the span of kept columns, each as (index, coefficients of all kept columns).
    pub dependent: Vec<(usize, Vec<f64>)>,
    /// Distance of each column, divided by the norm of this column. For a zero column: its norm, divided by the norm of the
    /// largest column.
    pub distance: Vec<f64>,
    /// Distance of each column relative to the norm of the largest column; 0 for a zero column.
    pub share: Vec<f64>,
}

/// Scans the columns of a matrix from left to right and keeps the independent columns, as for base parameters.
///
/// If columns are not finite, the error has their indices.
pub fn independent_columns(matrix: &DMatrix<f64>) -> Result<Scan, Vec<usize>> {
    scan(&triangle(matrix, 1), None)
}

/// Scans the columns of a QR triangle ([`crate::base::triangle`]) and keeps the independent columns, or the `chosen` ones.
///
/// Every number of the result is finite. Otherwise the error has the indices of the columns that are not finite.
pub(crate) fn scan(triangle: &DMatrix<f64>, chosen: Option<&[usize]>) -> Result<Scan, Vec<usize>> {
    let p = triangle.ncols();
    let norms: Vec<f64> = triangle.column_iter().map(|c| c.norm()).collect();
    let broken: Vec<usize> = (0..p).filter(|&c| !norms[c].is_finite()).collect();
    if !broken.is_empty() {
        return Err(broken);
    }
    let largest = norms.iter().fold(0.0, |a: f64, &b| a.max(b));
    let is_chosen = |c: usize| chosen.map(|chosen| chosen.binary_search(&c).is_ok());

    let mut s = Scan { kept: vec![], zero: vec![], dependent: vec![], distance: vec![0.0; p], share: vec![0.0; p] };
    // The matrix is triangular: only the first c + 1 entries of column c, and of its basis vector, can be non-zero.
    let mut basis: Vec<DVector<f64>> = Vec::new();
    // Coefficients of each kept column k in the orthonormal basis: column k = sum_i basis_i factors[k][i].
    let mut factors: Vec<Vec<f64>> = Vec::new();
    for c in 0..p {
        if norms[c] <= NEGLIGIBLE_PIVOT_RATIO * largest && is_chosen(c) != Some(true) {
            s.zero.push(c);
            s.distance[c] = if largest > 0.0 { norms[c] / largest } else { 0.0 };
            continue;
        }
        let mut v: DVector<f64> = triangle.column(c).rows(0, c + 1).into_owned();
        let mut along = vec![0.0; basis.len()];
        // Gram-Schmidt orthogonalisation. Two passes are enough [Parlett, after Kahan].
        for _ in 0..2 {
            for (b, a) in basis.iter().zip(&mut along) {
                let mut v = v.rows_mut(0, b.len());
                let projection = b.dot(&v);
                v.axpy(-projection, b, 1.0);
                *a += projection;
            }
        }
        s.distance[c] = if norms[c] > 0.0 { v.norm() / norms[c] } else { 0.0 };
        s.share[c] = v.norm() / largest;
        // A chosen column cannot be kept if its distance is zero.
        if is_chosen(c).unwrap_or(s.distance[c] > INDEPENDENT) && s.distance[c] > 0.0 {
            let norm = v.norm();
            along.push(norm);
            basis.push(v / norm);
            factors.push(along);
            s.kept.push(c);
        } else {
            s.dependent.push((c, along));
        }
    }
    // Back substitution converts coefficients of the basis vectors to coefficients of the kept columns.
    for (_, x) in &mut s.dependent {
        for k in (0..x.len()).rev() {
            x[k] /= factors[k][k];
            for i in 0..k {
                x[i] -= x[k] * factors[k][i];
            }
        }
        x.resize(s.kept.len(), 0.0);
    }
    let is_finite = |d: &&(usize, Vec<f64>)| d.1.iter().all(|x| x.is_finite());
    let broken: Vec<usize> = s.dependent.iter().filter(|d| !is_finite(d)).map(|d| d.0).collect();
    if broken.is_empty() { Ok(s) } else { Err(broken) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_leftmost_independent_columns() {
        // Columns: a, almost 0, b, 2a - 3b, c, a.
        let (a, b, c) = ([1.0, 2.0, 3.0, 4.0], [0.0, 1.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0]);
        let matrix = DMatrix::from_fn(4, 6, |r, k| match k {
            0 | 5 => a[r],
            1 => 1e-14 * c[r],
            2 => b[r],
            3 => 2.0 * a[r] - 3.0 * b[r],
            _ => c[r],
        });
        let triangle = triangle(&matrix, 1);
        let s = scan(&triangle, None).unwrap();
        assert_eq!((s.kept, s.zero), (vec![0, 2, 4], vec![1]));
        assert_eq!(s.dependent.iter().map(|d| d.0).collect::<Vec<_>>(), [3, 5]);
        for (found, expected) in s.dependent[0].1.iter().zip([2.0, -3.0, 0.0]) {
            assert!((found - expected).abs() < 1e-13);
        }

        // Other columns with the same span are chosen beforehand.
        let s = scan(&triangle, Some(&[2, 3, 4])).unwrap();
        assert_eq!((s.kept, s.zero), (vec![2, 3, 4], vec![1]));
        assert_eq!(s.dependent.iter().map(|d| d.0).collect::<Vec<_>>(), [0, 5]);
        for (found, expected) in s.dependent[1].1.iter().zip([1.5, 0.5, 0.0]) {
            assert!((found - expected).abs() < 1e-13);
        }
        // If a chosen column is dependent, the distance of this column shows this.
        assert!(scan(&triangle, Some(&[0, 2, 3])).unwrap().distance[3] < 1e-13);
    }

    #[test]
    fn what_is_not_finite_is_named() {
        for bad in [f64::NAN, f64::INFINITY] {
            let matrix = DMatrix::from_fn(6, 4, |r, k| if k == 2 && r == 3 { bad } else { (r * r + k) as f64 });
            assert!(scan(&triangle(&matrix, 2), None).is_err_and(|broken| broken.contains(&2)));
        }
    }
}
