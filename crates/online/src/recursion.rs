//! Recursive least squares with forgetting, in square-root form.
//!
//! The rows h x = z + noise (unit variance) are stored as the triangle R and the right side Q z of their QR decomposition. A
//! new row is rotated into the triangle by Givens rotations [Golub, Van Loan 2013, chapter 5]. Forgetting multiplies R and Q z
//! by sqrt(lambda), so old rows lose weight. The covariance inv(R) inv(R)' is positive definite for every rounding, also in
//! f32.

use crate::real::Real;

/// Least squares for M parameters, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Recursion<R, const M: usize> {
    triangle: [[R; M]; M],
    right: [R; M],
}

impl<R: Real, const M: usize> Recursion<R, M> {
    /// Starts from independent parameters with mean zero and these standard deviations, all positive.
    pub fn new(deviations: &[R; M]) -> Recursion<R, M> {
        let mut triangle = [[R::ZERO; M]; M];
        for (k, (row, &deviation)) in triangle.iter_mut().zip(deviations).enumerate() {
            row[k] = R::ONE / deviation;
        }
        Recursion { triangle, right: [R::ZERO; M] }
    }

    /// Adds a row h x = z with a noise of unit variance. A row that contains NaN or infinity is not used.
    pub fn push(&mut self, mut row: [R; M], mut value: R) {
        if !(value.is_finite() && row.iter().all(|x| x.is_finite())) {
            return;
        }
        for k in 0..M {
            let (a, b) = (self.triangle[k][k], row[k]);
            let length = (a * a + b * b).sqrt();
            if !length.is_positive() {
                continue;
            }
            let (c, s) = (a / length, b / length);
            for (t, x) in self.triangle[k].iter_mut().zip(&mut row).skip(k) {
                (*t, *x) = (c * *t + s * *x, c * *x - s * *t);
            }
            (self.right[k], value) = (c * self.right[k] + s * value, c * value - s * self.right[k]);
        }
    }

    /// Multiplies the weight of all rows so far by `root_of_weight`^2, between 0 and 1.
    pub fn forget(&mut self, root_of_weight: R) {
        self.triangle.iter_mut().flatten().for_each(|x| *x = *x * root_of_weight);
        self.right.iter_mut().for_each(|x| *x = *x * root_of_weight);
    }

    /// The sum of squares z'z that the estimate explains. z: right side of R x = z.
    pub fn explained_square(&self) -> R {
        self.right.iter().fold(R::ZERO, |sum, z| sum + *z * *z)
    }

    /// The estimate: the x with the smallest sum of squares.
    pub fn solution(&self) -> [R; M] {
        self.solved(self.right)
    }

    /// The solution of R x = right.
    fn solved(&self, right: [R; M]) -> [R; M] {
        let mut x = right;
        for k in (0..M).rev() {
            for c in k + 1..M {
                x[k] = x[k] - self.triangle[k][c] * x[c];
            }
            x[k] = x[k] / self.triangle[k][k];
        }
        x
    }

    /// inv(R), upper triangular: the covariance of the estimate is inv(R) inv(R)'.
    pub fn inverse_triangle(&self) -> [[R; M]; M] {
        let mut inverse = [[R::ZERO; M]; M];
        for c in 0..M {
            let mut unit = [R::ZERO; M];
            unit[c] = R::ONE;
            for (row, x) in inverse.iter_mut().zip(self.solved(unit)) {
                row[c] = x;
            }
        }
        inverse
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    extern crate std;

    #[test]
    fn the_estimate_is_that_of_the_normal_equations_and_its_sigma_is_right() {
        let truth = [2.0, -1.0, 0.5];
        let mut random = Random::new(4);
        let draws = 400;
        let mut squares = [0.0; 3];
        for _ in 0..draws {
            let mut recursion = Recursion::new(&[1e6; 3]);
            for _ in 0..50 {
                let row = [random.normal(), 1.0, random.normal() + 1.0];
                let value: f64 = row.iter().zip(truth).map(|(h, x)| h * x).sum();
                recursion.push(row, value + random.normal());
            }
            let (x, inverse) = (recursion.solution(), recursion.inverse_triangle());
            for k in 0..3 {
                let variance: f64 = inverse[k].iter().map(|x| x * x).sum();
                squares[k] += (x[k] - truth[k]).powi(2) / variance / f64::from(draws);
            }
        }
        // The mean of 400 squares of standard normal numbers is 1 with a standard deviation of 0.07. The limit is four standard
        // deviations.
        assert!(squares.iter().all(|s| (s - 1.0).abs() < 0.28), "{squares:?}");
    }

    #[test]
    fn forgetting_follows_a_change_and_single_precision_keeps_the_result() {
        let mut slow = Recursion::new(&[1e3_f64; 2]);
        let mut single = Recursion::new(&[1e3_f32; 2]);
        let root = 0.99_f64.sqrt();
        for k in 0..4000 {
            let truth = if k < 2000 { [1.0, 2.0] } else { [3.0, -1.0] };
            let row = [1.0, (0.1 * f64::from(k)).sin()];
            let value = row[0] * truth[0] + row[1] * truth[1];
            slow.forget(root);
            slow.push(row, value);
            single.forget(root as f32);
            single.push(row.map(|x| x as f32), value as f32);
        }
        let (x, y) = (slow.solution(), single.solution());
        // The weight of the rows before the change is 0.99^2000 = 2e-9.
        assert!((x[0] - 3.0).abs() < 1e-6 && (x[1] + 1.0).abs() < 1e-6, "{x:?}");
        // Rounding in single precision is 6e-8, and the memory is a hundred rows.
        assert!((f64::from(y[0]) - 3.0).abs() < 1e-4 && (f64::from(y[1]) + 1.0).abs() < 1e-4, "{y:?}");
    }

    #[test]
    fn rows_without_numbers_are_not_used() {
        let mut recursion = Recursion::new(&[1.0, 1.0]);
        recursion.push([f64::NAN, 1.0], 1.0);
        recursion.push([1.0, 0.0], f64::INFINITY);
        recursion.push([0.0, 0.0], 1.0);
        assert_eq!(recursion.solution(), [0.0, 0.0]);
    }
}
