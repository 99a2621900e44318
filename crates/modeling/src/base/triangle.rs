//! Computes the triangle R of the QR decomposition of a matrix A, joint by joint.
//!
//! R'R = A'A. All rows of one joint are added to R at once, by Householder reflections [Golub, Van Loan, 5.1]. A reflection
//! changes one row of R and the rows of the joint. Only R and the rows of one joint are in memory. The row of a joint is zero
//! in the columns of bodies that the joint does not carry. A column that is zero in both blocks of a reflection stays zero and
//! is skipped, which saves most of the work for a tree.
//!
//! A joint has some dozens of rows and a robot has thousands of columns, so the information of the rows is in R long before the
//! last column. After that, the rows contain only rounding errors, which are dropped: each further pass would square them, until
//! the factor 2 / v'v overflows.

use nalgebra::DMatrix;

/// A column of a joint's rows counts as rounding error if its norm is at most this share of the norm of the whole column.
/// Reflections leave about 1e-15, a second pass 1e-30. The threshold of the rank is 1e-7.
const COLUMN_ROUNDING: f64 = 1e-15;

/// The QR triangle R, p x p, of a matrix with p columns whose row i belongs to joint i modulo `joints`.
pub(crate) fn triangle(matrix: &DMatrix<f64>, joints: usize) -> DMatrix<f64> {
    let (rows, p) = matrix.shape();
    let mut r = vec![0.0; p * p];
    // A bound is at least the smallest normal number, because the square of a smaller norm cannot be a divisor.
    let rounding =
        |c: nalgebra::DVectorView<f64>| (COLUMN_ROUNDING * COLUMN_ROUNDING * c.norm_squared()).max(f64::MIN_POSITIVE);
    let rounding: Vec<f64> = matrix.column_iter().map(rounding).collect();
    for joint in 0..joints.max(1) {
        let own: Vec<usize> = (joint..rows).step_by(joints.max(1)).collect();
        let mut block: Vec<f64> = (0..p).flat_map(|c| own.iter().map(move |&i| matrix[(i, c)])).collect();
        absorb(&mut r, &mut block, &rounding, own.len());
    }
    DMatrix::from_row_slice(p, p, &r)
}

/// Adds the rows of one joint to the triangle R. `block` holds the rows, column by column, and is overwritten. `rounding`: for
/// each column, the squared norm that counts as zero.
fn absorb(r: &mut [f64], block: &mut [f64], rounding: &[f64], rows: usize) {
    let p = rounding.len();
    for c in 0..p {
        let (head, behind) = block.split_at_mut((c + 1) * rows);
        let v = &head[c * rows..];
        let square = dot(v, v);
        // NaN passes this comparison and reaches the scan of the columns, which refuses NaN.
        if square <= rounding[c] {
            continue;
        }
        let diagonal = r[c * p + c];
        let norm = (diagonal * diagonal + square).sqrt();
        let image = if diagonal > 0.0 { -norm } else { norm };
        // Householder reflection H = 1 - 2 v v' / v'v with v = (diagonal - image, column of the rows).
        let first = diagonal - image;
        let factor = 2.0 / (first * first + square);
        r[c * p + c] = image;
        for (entry, column) in r[c * p + c + 1..(c + 1) * p].iter_mut().zip(behind.chunks_exact_mut(rows)) {
            let along = factor * (first * *entry + dot(v, column));
            if along != 0.0 {
                *entry -= along * first;
                column.iter_mut().zip(v).for_each(|(x, v)| *x -= along * v);
            }
        }
    }
}

/// Dot product with four independent sums. With a single sum, each addition would have to wait for the previous one.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a4.zip(b4) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::SplitMix;

    /// Checks that R'R = A'A, and that R equals the R of an ordinary QR up to the signs of its rows. Some columns are zero for
    /// some joints.
    #[test]
    fn the_triangle_of_an_ordinary_qr() {
        let (joints, states, p) = (4, 9, 12);
        let mut random = SplitMix(7);
        let reaches = |joint: usize, column: usize| column / 3 >= joint || column == 5;
        let entry = |row: usize, column: usize| if reaches(row % joints, column) { random.unit() } else { 0.0 };
        let mut entry = entry;
        let matrix = DMatrix::from_fn(joints * states, p, &mut entry);
        let found = triangle(&matrix, joints);
        let expected = matrix.clone().qr().unpack_r();
        for c in 0..p {
            for i in 0..p {
                // Entries are of order one, so the difference is rounding.
                assert!((found[(i, c)].abs() - expected[(i, c)].abs()).abs() < 1e-13, "{i} {c}");
                assert!(i <= c || found[(i, c)] == 0.0);
            }
        }
        let gram = found.transpose() * &found - matrix.transpose() * &matrix;
        assert!(gram.amax() < 1e-12);
    }

    /// Checks a matrix with 600 columns and 21 rows, 7 for each joint. After 21 columns at most, R has all information, and the
    /// rows contain only rounding errors. If these errors were not dropped, every 7 further columns would square them, about 80
    /// times in all, and the factor 2 / v'v would overflow.
    #[test]
    fn rows_that_are_used_up_leave_nothing() {
        let (joints, states, p) = (3, 7, 600);
        let mut random = SplitMix(45);
        let matrix = DMatrix::from_fn(joints * states, p, |_, _| random.unit());
        let found = triangle(&matrix, joints);
        let gram = found.transpose() * &found - matrix.transpose() * &matrix;
        // Entries are sums of 21 terms of order one. NaN would fail this comparison too.
        assert!(gram.iter().all(|x| x.abs() < 1e-13));
        // The rows of R beyond the number of rows of the matrix contain only rounding errors.
        assert!(found.rows(joints * states, p - joints * states).iter().all(|x| x.abs() < 1e-12));
    }

    #[test]
    fn not_a_number_stays_so() {
        let mut matrix = DMatrix::from_fn(6, 3, |r, c| (r + 2 * c) as f64 + 1.0);
        matrix[(4, 1)] = f64::NAN;
        assert!(triangle(&matrix, 2).column(1).iter().any(|x| x.is_nan()));
    }

    #[test]
    fn few_rows_leave_zeros() {
        let matrix = DMatrix::from_row_slice(2, 3, &[3.0, 1.0, 2.0, 4.0, 1.0, 0.0]);
        let found = triangle(&matrix, 1);
        // The matrix has two rows, so the third row of R is only rounding.
        assert!((found[(0, 0)].abs() - 5.0).abs() < 1e-14 && found[(2, 2)].abs() < 1e-14);
        assert_eq!(triangle(&DMatrix::zeros(0, 2), 3), DMatrix::zeros(2, 2));
    }
}
