//! Finds the few directions in which an error of the parameters changes the torques most.
//!
//! C = L L' is the covariance of the parameters, M = mean y'y / noise^2 over the rows y of the fitted logs. The eigenvectors V of
//! L' M L with the largest eigenvalues give
//!
//! ```text
//! G = L V sqrt(tr(M C) / tr(V' L' M L V))
//! ```
//! V has only a few directions, so without the square root G G' would cause only a part of the variance that C causes in the
//! torques of the fitted logs. (After a fit by least squares, all directions have similar shares of the variance.) The square
//! root scales G such that G G' and C cause the same variance, on average over the rows.

use nalgebra::{DMatrix, SymmetricEigen};

/// Number of directions: the columns of G. Each one costs a control loop some hundred operations.
pub const DIRECTIONS: usize = 6;

/// The factor G (p x [`DIRECTIONS`], row by row). `products`: M.
pub(crate) fn directions(covariance: &DMatrix<f64>, products: &DMatrix<f64>) -> Vec<[f64; DIRECTIONS]> {
    let p = covariance.nrows();
    let own = SymmetricEigen::new(covariance.clone());
    let roots = own.eigenvalues.map(|value| value.max(0.0).sqrt());
    let factor = &own.eigenvectors * DMatrix::from_diagonal(&roots);
    let seen = SymmetricEigen::new(factor.transpose() * products * &factor);
    let mut order: Vec<usize> = (0..p).collect();
    order.sort_by(|a, b| seen.eigenvalues[*b].total_cmp(&seen.eigenvalues[*a]));
    let held: f64 = order.iter().take(DIRECTIONS).map(|&c| seen.eigenvalues[c].max(0.0)).sum();
    let whole: f64 = seen.eigenvalues.iter().map(|value| value.max(0.0)).sum();
    let scale = if held > 0.0 { (whole / held).sqrt() } else { 1.0 };
    let turned = factor * &seen.eigenvectors;
    let row = |r: usize| std::array::from_fn(|d| order.get(d).map_or(0.0, |&c| scale * turned[(r, c)]));
    (0..p).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_directions_have_the_variance_of_the_covariance() {
        for (p, decay) in [(12, 2), (12, 0), (4, 1)] {
            let root =
                DMatrix::from_fn(p, p, |i, j| ((7 * i * i + 13 * i * j) % 11) as f64 / (1.0 + j as f64).powi(decay));
            let covariance = &root * root.transpose();
            let rows = DMatrix::from_fn(40, p, |i, j| ((i * (j + 1)) as f64 * 0.37).cos());
            let factor = directions(&covariance, &(rows.transpose() * &rows));
            let (mut exact, mut found) = (0.0, 0.0);
            for row in rows.row_iter() {
                exact += (row * &covariance * row.transpose())[(0, 0)];
                found += (0..DIRECTIONS)
                    .map(|d| row.iter().zip(&factor).map(|(y, g)| y * g[d]).sum::<f64>().powi(2))
                    .sum::<f64>();
            }
            // Rounding of a hundred products of numbers of order one.
            assert!((found / exact - 1.0).abs() < 1e-9, "{found} {exact}");
        }
    }
}
