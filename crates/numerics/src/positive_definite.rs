//! Solves linear systems A x = b with a small positive definite matrix A, by elimination without pivoting.

/// Solves A x = b for a symmetric positive definite A (n x n, row by row). x replaces b, and A is overwritten. Returns `false`
/// if A is not positive definite.
pub fn solve_positive(a: &mut [f64], b: &mut [f64]) -> bool {
    // Most arms have 6 or 7 joints. With a constant n the compiler unrolls the loops, which saves a third of the time.
    match b.len() {
        6 => solved(a, b, 6),
        7 => solved(a, b, 7),
        n => solved(a, b, n),
    }
}

#[inline(always)]
fn solved(a: &mut [f64], b: &mut [f64], n: usize) -> bool {
    let (a, b) = (&mut a[..n * n], &mut b[..n]);
    for k in 0..n {
        let (above, below) = a.split_at_mut((k + 1) * n);
        let pivot_row = &above[k * n..];
        let pivot = pivot_row[k];
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        for (i, row) in (k + 1..n).zip(below.chunks_exact_mut(n)) {
            let f = row[k] / pivot;
            for c in k + 1..n {
                row[c] -= f * pivot_row[c];
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

    /// Solves systems with a known solution, for n = 6 and 7, which have their own loops, and for other n.
    #[test]
    fn every_size_is_solved() {
        for n in 1..=9 {
            let entry = |i: usize, c: usize| if i == c { 3.0 } else { 1.0 / (1.0 + (i + c) as f64) };
            let a: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
            let x: Vec<f64> = (0..n).map(|k| 1.5 - k as f64).collect();
            let product = |row: &[f64]| row.iter().zip(&x).map(|(a, x)| a * x).sum::<f64>();
            let mut b: Vec<f64> = a.chunks(n).map(product).collect();
            assert!(solve_positive(&mut a.clone(), &mut b));
            // Allowed error: rounding of numbers below 30, with a condition number below 10.
            assert!(b.iter().zip(&x).all(|(b, x)| (b - x).abs() < 1e-13), "{n}: {b:?}");
            let mut not = a.clone();
            not[n * n - 1] = -3.0;
            assert!(!solve_positive(&mut not, &mut b), "{n}");
        }
    }
}
