//! The few directions of the parameters' error that move the torques most.
//!
//! C = L L' is the covariance of the parameters, M = mean y'y / noise^2 over the rows y of the fitted logs. The eigenvectors V of
//! L' M L with the largest eigenvalues give G = L V, and y C y' is nearly the squared length of y G.

use nalgebra::{DMatrix, SymmetricEigen};

/// Number of directions: the columns of G. On a UR5 six hold more than 90 % of the variance of the torques.
pub const DIRECTIONS: usize = 6;

/// The factor G (p x [`DIRECTIONS`], row by row), and the share of the variance of the torques that it holds.
pub(crate) fn directions(covariance: &DMatrix<f64>, products: &DMatrix<f64>) -> (Vec<[f64; DIRECTIONS]>, f64) {
    let p = covariance.nrows();
    let own = SymmetricEigen::new(covariance.clone());
    let roots = own.eigenvalues.map(|value| value.max(0.0).sqrt());
    let factor = &own.eigenvectors * DMatrix::from_diagonal(&roots);
    let seen = SymmetricEigen::new(factor.transpose() * products * &factor);
    let mut order: Vec<usize> = (0..p).collect();
    order.sort_by(|a, b| seen.eigenvalues[*b].total_cmp(&seen.eigenvalues[*a]));
    let turned = factor * &seen.eigenvectors;
    let row = |r: usize| std::array::from_fn(|d| order.get(d).map_or(0.0, |&c| turned[(r, c)]));
    let held: f64 = order.iter().take(DIRECTIONS).map(|&c| seen.eigenvalues[c].max(0.0)).sum();
    let whole: f64 = seen.eigenvalues.iter().map(|value| value.max(0.0)).sum();
    ((0..p).map(row).collect(), if whole > 0.0 { held / whole } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_directions_give_the_covariance_and_few_the_largest_part() {
        let p = 12;
        let root = DMatrix::from_fn(p, p, |i, j| ((7 * i * i + 13 * i * j) % 11) as f64 / (1.0 + j as f64).powi(2));
        let covariance = &root * root.transpose();
        let rows = DMatrix::from_fn(40, p, |i, j| ((i * (j + 1)) as f64 * 0.37).cos());
        let (factor, held) = directions(&covariance, &(rows.transpose() * &rows));
        let (mut exact, mut found) = (0.0, 0.0);
        for row in rows.row_iter() {
            exact += (row * &covariance * row.transpose())[(0, 0)];
            found += (0..DIRECTIONS)
                .map(|d| row.iter().zip(&factor).map(|(y, g)| y * g[d]).sum::<f64>().powi(2))
                .sum::<f64>();
        }
        // Rounding of a hundred products of numbers of order one.
        assert!((found / exact - held).abs() < 1e-9 && held > 0.99 && held < 1.0, "{held}");
    }
}
