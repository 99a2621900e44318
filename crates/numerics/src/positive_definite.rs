//! Linear systems with a positive definite matrix.

/// Solves A x = b in place for a symmetric positive definite A (n x n, row by row); `false` when
/// A is not positive definite.
pub fn solve_positive(a: &mut [f64], b: &mut [f64]) -> bool {
    let n = b.len();
    for k in 0..n {
        let pivot = a[k * n + k];
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        for i in k + 1..n {
            let f = a[i * n + k] / pivot;
            for c in k + 1..n {
                a[i * n + c] -= f * a[k * n + c];
            }
            b[i] -= f * b[k];
        }
    }
    for k in (0..n).rev() {
        let tail: f64 = (k + 1..n).map(|c| a[k * n + c] * b[c]).sum();
        b[k] = (b[k] - tail) / a[k * n + k];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_positive_system() {
        let (mut a, mut b) = ([4.0, 1.0, 1.0, 3.0], [1.0, 2.0]);
        assert!(solve_positive(&mut a, &mut b));
        assert!((b[0] - 1.0 / 11.0).abs() < 1e-15 && (b[1] - 7.0 / 11.0).abs() < 1e-15);
        assert!(!solve_positive(&mut [-1.0], &mut [1.0]));
    }
}
