//! Solves mixed least squares and total least squares: some columns are exact, others noisy.
//!
//! [W_1 | W_2] [X_1; X_2] = y; W_1: exact columns, W_2, y: noisy. A QR decomposition eliminates the exact columns and gives
//! [R_22 S, r_2], with the scaling S = diag(s). The right singular vector of the smallest singular value of [R_22 S, r_2] gives
//! X_2, and X_1 follows by back substitution [Golub, Van Loan 1980; Van Huffel, Vandewalle 1991, 3.6].
//!
//! Each noisy column is divided by the ratio of the standard deviation of its noise to the standard deviation of the noise of y,
//! both after projection. Unscaled columns with different noise give biased results.

use nalgebra::DMatrix;

use crate::error::Error;
use crate::triangle::{Triangle, select};

/// The solution of a mixed least-squares and total least-squares problem.
#[derive(Clone, Debug)]
pub struct TotalLeastSquares {
    /// The parameters, in the order of the columns of the triangle.
    pub x: Vec<f64>,
    /// Singular values of the noisy columns with the right-hand side, largest first. The last value comes from the noise. If
    /// the last value is not much smaller than the last but one, the solution is meaningless.
    pub singular_values: Vec<f64>,
}
/// If the entry of the last singular vector that belongs to the right-hand side is below this value, the data do not determine
/// the solution.
const LEAST_SIDE_SHARE: f64 = 1e-9;
/// If the pivot of an exact column is below this share of its norm, the column depends on the others.
const DEPENDENT_COLUMN_SHARE: f64 = 1e-12;

/// Solves the mixed problem. `noisy`: index of each noisy column, with the ratio of the standard deviation of its noise to the
/// standard deviation of the noise of the right-hand side.
///
/// Fails if no column is noisy, if the exact columns are dependent, or if the data do not determine the solution (the direction
/// of the smallest singular value does not contain the right-hand side).
pub fn total_least_squares(triangle: &Triangle, noisy: &[(usize, f64)]) -> Result<TotalLeastSquares, Error> {
    let p = triangle.columns();
    if noisy.is_empty() || noisy.iter().any(|&(c, s)| c >= p || s <= 0.0 || !s.is_finite()) {
        return Err(Error::new("total least squares needs noisy columns, each with a positive noise ratio"));
    }
    // The exact columns go first, so that [R_22, r_2] is the lower right corner.
    let exact: Vec<usize> = (0..p).filter(|c| noisy.iter().all(|n| n.0 != *c)).collect();
    let order: Vec<usize> = exact.iter().copied().chain(noisy.iter().map(|n| n.0)).collect();
    let t = select(triangle, &order);
    let (a, b) = (exact.len(), noisy.len());
    let scale = |j: usize| if j < b { 1.0 / noisy[j].1 } else { 1.0 };
    let core = DMatrix::from_fn(b + 1, b + 1, |i, j| if i <= j { t.at(a + i, a + j) * scale(j) } else { 0.0 });
    let svd = core.svd(false, true);
    let mut values: Vec<(f64, usize)> = svd.singular_values.iter().copied().zip(0..).collect();
    values.sort_by(|a, b| b.0.total_cmp(&a.0));
    let undetermined = || Error::new("total least squares: the data do not determine the noisy part");
    let (Some(vt), Some(&(_, last))) = (svd.v_t.as_ref(), values.last()) else { return Err(undetermined()) };
    // The right singular vector of the smallest singular value, scaled so that its entry for the right-hand side is -1.
    let v = vt.row(last);
    if v[b].abs() < LEAST_SIDE_SHARE {
        return Err(undetermined());
    }
    let mut sorted: Vec<f64> = (0..b).map(|j| -v[j] * scale(j) / v[b]).collect();
    // Back substitution of R_11 X_1 = z_1 - R_12 X_2, from the last row.
    let mut x1 = vec![0.0; a];
    for i in (0..a).rev() {
        let known: f64 = (i + 1..a).map(|j| t.at(i, j) * x1[j]).sum::<f64>()
            + (0..b).map(|j| t.at(i, a + j) * sorted[j]).sum::<f64>();
        let pivot = t.at(i, i);
        if pivot.abs() <= DEPENDENT_COLUMN_SHARE * t.column_norm(i) {
            return Err(Error::new("total least squares: the exact columns depend on each other"));
        }
        x1[i] = (t.at(i, p) - known) / pivot;
    }
    x1.append(&mut sorted);
    let mut x = vec![0.0; p];
    order.iter().zip(x1).for_each(|(&c, v)| x[c] = v);
    Ok(TotalLeastSquares { x, singular_values: values.into_iter().map(|v| v.0).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::least_squares::solve;
    use crate::triangle::TriangleBuilder;
    use random::Random;

    fn triangle(column_noise: f64, noise: f64, seed: u64) -> Triangle {
        let mut random = Random::new(seed);
        let mut rows = TriangleBuilder::new(2);
        for _ in 0..500 {
            let (a, b) = (random.normal(), random.normal());
            rows.push(&[a + column_noise * random.normal(), b], 2.0 * a - b + noise * random.normal());
        }
        rows.finish()
    }

    #[test]
    fn exact_data() {
        let x = total_least_squares(&triangle(0.0, 0.0, 1), &[(0, 1.0)]).unwrap().x;
        assert!((x[0] - 2.0).abs() < 1e-12 && (x[1] + 1.0).abs() < 1e-12, "{x:?}");
    }

    /// The noise of the column is half as large as the column. Least squares underestimates the parameter by a fifth, and the
    /// mixed solution does not.
    #[test]
    fn a_noisy_column_is_not_shrunk() {
        let (mut ls, mut tls) = (0.0, 0.0);
        let runs = 50;
        for seed in 0..runs {
            let t = triangle(0.5, 0.2, 50 + seed);
            ls += solve(&t).x[0] / runs as f64;
            tls += total_least_squares(&t, &[(0, 0.5 / 0.2)]).unwrap().x[0] / runs as f64;
        }
        assert!((ls - 1.6).abs() < 0.05, "{ls}");
        // The standard error of the mean of 50 runs is 0.01.
        assert!((tls - 2.0).abs() < 0.04, "{tls}");
    }

    #[test]
    fn refusals() {
        assert!(total_least_squares(&triangle(0.0, 0.1, 1), &[]).is_err());
        assert!(total_least_squares(&triangle(0.0, 0.1, 1), &[(5, 1.0)]).is_err());
        let message = total_least_squares(&Triangle::new(2), &[(0, 1.0)]).unwrap_err().to_string();
        assert!(message.contains("open") || message.contains("depend"), "{message}");
    }
}
