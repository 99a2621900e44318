//! Solves least squares from a triangle (R, z and rho of a QR decomposition), and finds the directions that the data do not
//! determine.
//!
//! min |R x - z|. The columns are scaled to unit norm: R = S D with a diagonal D, and S = U diag(s) V'. The condition number is
//! s_1 / s_p of the scaled columns. Directions with s_i <= SINGULAR_VALUE_TOLERANCE s_1 are not determined by the data, and
//! parameters with a component along such a direction have no value. [Golub, Van Loan 2013; van der Sluis 1969, on scaling]
//!
//! sigma^2 = rho^2 / (r - p) from r rows, |rho|: norm of the residual. C = sigma^2 (R'R)^-1 is the covariance of x for white
//! noise of equal variance in all rows.

use nalgebra::{DMatrix, DVector, Dyn, SVD};

use crate::triangle::Triangle;

/// A singular value is rounding error if its ratio to the largest singular value is at most this value. Columns of filtered
/// signals have about nine correct digits, and fewer if their terms nearly cancel.
const SINGULAR_VALUE_TOLERANCE: f64 = 1e-7;

/// A parameter is not determined if its entry in an undetermined direction of unit norm exceeds this value.
const TOUCHED_PARAMETER_SHARE: f64 = 1e-3;
/// A direction is weak if its singular value is below this share of the largest singular value.
const WEAK_SHARE: f64 = 0.1;

/// The least-squares solution and its uncertainty.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The p parameters. If the solution is not unique, this is the solution of least norm.
    pub x: Vec<f64>,
    /// For each parameter, whether the data determine it.
    pub determined: Vec<bool>,
    /// (R'R)^+, p x p: the covariance of the parameters for noise of unit variance.
    pub inverse: DMatrix<f64>,
    /// Variance sigma^2 of the noise of a row, computed from the residual.
    pub variance: f64,
    /// Singular values of the scaled columns, largest first.
    pub singular_values: Vec<f64>,
    /// Condition number of the columns scaled to unit norm; infinite if a direction is not determined.
    pub condition_number: f64,
    /// Weak directions of the parameter space, the weakest first: the ratio of the singular value to the largest one, and the
    /// direction in the units of the parameters with largest entry 1.
    pub weak: Vec<(f64, Vec<f64>)>,
    /// Number of independent columns.
    pub rank: usize,
}

impl Solution {
    /// The directions of the parameter space that the data do not determine, in the units of the parameters with largest entry 1.
    pub fn open(&self) -> impl Iterator<Item = &[f64]> {
        self.weak.iter().take(self.x.len() - self.rank).map(|(_, direction)| direction.as_slice())
    }
}

/// The least-squares solution x of R x = z from a triangle. A direction is undetermined if its singular value is at most 1e-7
/// times the largest.
pub fn solve(triangle: &Triangle) -> Solution {
    solve_within(triangle, SINGULAR_VALUE_TOLERANCE)
}

/// The least-squares solution x of R x = z from a triangle. A direction is undetermined if its singular value is at most
/// `tolerance` times the largest.
pub fn solve_within(triangle: &Triangle, tolerance: f64) -> Solution {
    // The singular values of R with columns of unit norm, the largest first.
    let p = triangle.columns();
    let norms: Vec<f64> = (0..p).map(|c| triangle.column_norm(c)).collect();
    let scale: Vec<f64> = norms.iter().map(|&d| if d > 0.0 { 1.0 / d } else { 1.0 }).collect();
    let scaled = DMatrix::from_fn(p, p, |i, j| if i <= j { triangle.at(i, j) * scale[j] } else { 0.0 });
    let z = DVector::from_fn(p, |i, _| triangle.at(i, p));
    let svd = decomposed(scaled);
    let empty = DMatrix::zeros(p, p);
    let (u, vt) = (svd.u.as_ref().unwrap_or(&empty), svd.v_t.as_ref().unwrap_or(&empty));
    let mut order: Vec<usize> = (0..p).collect();
    order.sort_by(|&a, &b| svd.singular_values[b].total_cmp(&svd.singular_values[a]));
    let s: Vec<f64> = order.iter().map(|&i| svd.singular_values[i]).collect();
    let largest = s.first().copied().unwrap_or(0.0);
    let rank = s.iter().filter(|&&s| s > tolerance * largest).count();

    // x = D^-1 V diag(1/s) U' z, (R'R)^-1 = D^-1 V diag(1/s^2) V' D^-1, over the determined directions. D: column norms; U
    // diag(s) V': decomposition of the scaled R.
    let mut x = vec![0.0; p];
    let mut inverse = DMatrix::zeros(p, p);
    for &i in &order[..rank] {
        let (s, v) = (svd.singular_values[i], vt.row(i));
        let share = u.column(i).dot(&z) / s;
        for a in 0..p {
            x[a] += scale[a] * v[a] * share;
            for b in 0..p {
                inverse[(a, b)] += scale[a] * v[a] * scale[b] * v[b] / (s * s);
            }
        }
    }
    // Of all x with the least residual, take the x of least norm in the units of the parameters. With the norm in the units of
    // the scaled columns, a parameter with a very small column would get a very large value.
    let null = DMatrix::from_fn(p, p - rank, |c, i| scale[c] * vt[(order[rank + i], c)]);
    if rank > 0 && rank < p {
        let q = null.map(|x| if x.is_finite() { x } else { 0.0 }).qr().q();
        let least = DVector::from_column_slice(&x);
        x = (&least - &q * q.tr_mul(&least)).as_slice().to_vec();
    }
    // If a parameter has a component along an undetermined direction, it is not determined.
    let mut determined: Vec<bool> = norms.iter().map(|&d| d > 0.0).collect();
    for &i in &order[rank..] {
        for (c, d) in determined.iter_mut().enumerate() {
            *d = *d && vt[(i, c)].abs() <= TOUCHED_PARAMETER_SHARE;
        }
    }
    // Weak directions in the units of the parameters, with largest entry 1.
    let weak = order.iter().rev().filter(|&&i| svd.singular_values[i] < WEAK_SHARE * largest);
    let weak = weak.map(|&i| {
        let v: Vec<f64> = (0..p).map(|c| vt[(i, c)] * scale[c]).collect();
        let peak = v.iter().copied().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
        (svd.singular_values[i] / largest, v.iter().map(|x| x / peak).collect())
    });
    let weak = weak.collect();
    let (_, squares) = triangle.squares(&x);
    let freedom = triangle.rows.saturating_sub(rank).max(1);
    Solution {
        x,
        determined,
        inverse,
        variance: squares / freedom as f64,
        condition_number: if rank < p { f64::INFINITY } else { largest / s.last().copied().unwrap_or(largest) },
        singular_values: s,
        weak,
        rank,
    }
}

/// The decomposition U diag(s) V'. A matrix with a NaN or an infinity is replaced by zeros, because the iteration of the
/// decomposition would never end.
fn decomposed(matrix: DMatrix<f64>) -> SVD<f64, Dyn, Dyn> {
    let is_finite = matrix.iter().all(|x| x.is_finite());
    let matrix = if is_finite { matrix } else { DMatrix::zeros(matrix.nrows(), matrix.ncols()) };
    matrix.svd(true, true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::triangle::TriangleBuilder;
    use random::Random;

    fn triangle(rows: &[(Vec<f64>, f64)]) -> Triangle {
        let p = rows[0].0.len();
        let mut block = TriangleBuilder::new(p);
        for (row, y) in rows {
            block.push(row, *y);
        }
        block.finish()
    }

    /// Rows with a NaN give a solution without determined parameters, and the iteration ends.
    #[test]
    fn of_what_is_no_number_nothing_is_determined() {
        let rows = [(vec![1.0, f64::NAN], 1.0), (vec![0.5, 2.0], 1.0), (vec![0.1, 3.0], 2.0)];
        let solution = solve(&triangle(&rows));
        assert_eq!(solution.rank, 0);
        assert!(solution.determined.iter().all(|d| !d), "{solution:?}");
    }

    #[test]
    fn exact_data_give_the_parameters_back() {
        let mut random = Random::new(5);
        let truth = [1e-4, 250.0, -3.0];
        let rows: Vec<(Vec<f64>, f64)> = (0..300)
            .map(|_| {
                let row = vec![1e3 * random.normal(), 0.01 * random.normal(), random.normal()];
                let y = row.iter().zip(truth).map(|(a, b)| a * b).sum();
                (row, y)
            })
            .collect();
        let solution = solve(&triangle(&rows));
        for (x, t) in solution.x.iter().zip(truth) {
            assert!((x - t).abs() < 1e-12 * t.abs(), "{x} {t}");
        }
        assert_eq!(solution.rank, 3);
        assert!(solution.condition_number < 1.5, "scaling makes unlike units alike: {}", solution.condition_number);
    }

    /// One of two parallel columns is a hundred thousand times smaller than the other. The solution must not give a large value
    /// to the parameter of the small column.
    #[test]
    fn a_column_that_hardly_shows_gets_no_large_value() {
        let mut random = Random::new(9);
        let mut row = || {
            let a = random.normal();
            (vec![a, 1e-5 * a, random.normal()], 2.0 * a)
        };
        let s = solve(&triangle(&(0..100).map(|_| row()).collect::<Vec<_>>()));
        assert_eq!((s.rank, s.determined), (2, vec![false, false, true]));
        assert!((s.x[0] - 2.0).abs() < 1e-9 && (s.x[1] - 2e-5).abs() < 1e-9, "{:?}", s.x);
    }

    #[test]
    fn what_is_not_in_the_data_has_no_value() {
        let mut random = Random::new(8);
        let mut row = || {
            let (a, b) = (random.normal(), random.normal());
            (vec![a, b, a + b, 0.0, random.normal()], a)
        };
        let s = solve(&triangle(&(0..100).map(|_| row()).collect::<Vec<_>>()));
        assert_eq!(s.determined, [false, false, false, false, true]);
        assert_eq!(s.rank, 3);
        assert_eq!(s.condition_number, f64::INFINITY);
    }
}
