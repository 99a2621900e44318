//! The criterion of the rows of W, and its slope along each of their entries.
//!
//! F = W'W / samples, p x p. With d_c the norms of the columns and C = F scaled to a unit diagonal:
//!
//! determinant: J = -log det F / p,                dJ/dF = -F^-1 / p
//! condition:   J = log(p tr C^-1) / 2, the logarithm of cond_fro of the scaled columns,
//!              dJ/dF = [diag((F^-1)_cc) - F^-1 diag(F_cc) F^-1] / (2 tr C^-1)
//!
//! and dJ/dW = 2 W dJ/dF / samples. Both are to be made small. Neither depends on the scale of a column but for a
//! constant.

use numerics::information_matrix::{InformationMatrix, Rows};
use serde::{Deserialize, Serialize};

/// The aim of a search for a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Aim {
    /// The greatest determinant of the information.
    Determinant,
    /// The least condition number (Frobenius) of the columns scaled to unit norm.
    Condition,
}

/// J, and what its derivative follows from.
pub struct Criterion {
    /// The criterion, the smaller the better.
    pub value: f64,
    aim: Aim,
    /// W with columns of unit norm.
    scaled: Rows,
    /// What each column was multiplied by for that.
    scale: Vec<f64>,
    /// C^-1, p x p.
    inverse: Vec<f64>,
}

/// The criterion of the rows `w` (p a row), whose memory becomes that of the slope; `None` where they have not full rank.
pub fn criterion(aim: Aim, mut w: Vec<f64>, p: usize, samples: usize) -> Option<Criterion> {
    let mut squares = vec![0.0; p];
    for row in w.chunks_exact(p) {
        (0..p).for_each(|i| squares[i] += row[i] * row[i]);
    }
    let scale: Vec<f64> = squares.iter().map(|s| 1.0 / s.sqrt()).collect();
    if p == 0 || scale.iter().any(|s| !s.is_finite()) {
        return None;
    }
    for row in w.chunks_exact_mut(p) {
        (0..p).for_each(|i| row[i] *= scale[i]);
    }
    let scaled = Rows::of(p, w);
    let factor = InformationMatrix::sum(p, 0.0, [(&scaled, 1.0)]).factor()?;
    let inverse = factor.inverse();
    let columns = p as f64;
    let value = match aim {
        Aim::Determinant => {
            let of_scale: f64 = squares.iter().map(|s| (s / samples as f64).ln()).sum();
            -(factor.log_det + of_scale) / columns
        }
        Aim::Condition => 0.5 * (columns * trace(&inverse, p)).ln(),
    };
    Some(Criterion { value, aim, scaled, scale, inverse })
}

fn trace(matrix: &[f64], p: usize) -> f64 {
    (0..p).map(|i| matrix[i * p + i]).sum()
}

impl Criterion {
    /// dJ/dW, row by row.
    pub fn slope(self) -> Vec<f64> {
        let (p, inverse) = (self.scale.len(), &self.inverse);
        // dJ/dC of the scaled columns; of W: 2 (scaled W) (dJ/dC) scale.
        let of_c: Vec<f64> = match self.aim {
            Aim::Determinant => inverse.iter().map(|x| -x / p as f64).collect(),
            Aim::Condition => {
                let trace = trace(inverse, p);
                let entry = |at: usize| {
                    let (i, j) = (at / p, at % p);
                    let product: f64 =
                        inverse[i * p..][..p].iter().zip(&inverse[j * p..][..p]).map(|(a, b)| a * b).sum();
                    let own = if i == j { inverse[at] } else { 0.0 };
                    (own - product) / (2.0 * trace)
                };
                (0..p * p).map(entry).collect()
            }
        };
        let mut slope = self.scaled.into_entries();
        let mut row = vec![0.0; p];
        for out in slope.chunks_exact_mut(p) {
            row.copy_from_slice(out);
            out.fill(0.0);
            multiply(&row, &of_c, out);
            (0..p).for_each(|i| out[i] *= 2.0 * self.scale[i]);
        }
        slope
    }
}

/// Rows of a matrix that are taken in one pass.
const ROWS_PER_PASS: usize = 4;

/// Adds x' M to `out`, row after row of M in every entry, but for rows whose x are zero.
fn multiply(x: &[f64], m: &[f64], out: &mut [f64]) {
    let p = out.len();
    for (x, rows) in x.chunks(ROWS_PER_PASS).zip(m.chunks(ROWS_PER_PASS * p)) {
        if x.iter().all(|x| *x == 0.0) {
            continue;
        }
        if let Ok(x) = <[f64; ROWS_PER_PASS]>::try_from(x) {
            let rows: [&[f64]; ROWS_PER_PASS] = std::array::from_fn(|r| &rows[r * p..][..p]);
            for k in 0..p {
                out[k] = (0..ROWS_PER_PASS).fold(out[k], |sum, r| sum + x[r] * rows[r][k]);
            }
            continue;
        }
        for (x, row) in x.iter().zip(rows.chunks_exact(p)) {
            for k in 0..p {
                out[k] += x * row[k];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    #[test]
    fn slopes_are_those_of_central_differences() {
        let (p, samples) = (4, 9);
        let mut random = Random::new(2);
        let scales = [1.0, 30.0, 0.02, 4.0];
        let w: Vec<f64> = (0..p * samples).map(|k| random.normal() * scales[k % p]).collect();
        for aim in [Aim::Determinant, Aim::Condition] {
            let at = |w: &[f64]| criterion(aim, w.to_vec(), p, samples).unwrap();
            let slopes = at(&w).slope();
            for k in 0..w.len() {
                let h = 1e-6 * scales[k % p];
                let moved = |h: f64| {
                    let mut w = w.clone();
                    w[k] += h;
                    at(&w).value
                };
                let slope = (moved(h) - moved(-h)) / (2.0 * h);
                // Central differences: 1e-16 over 1e-6, per scale of the column.
                assert!((slopes[k] - slope).abs() < 1e-7 / scales[k % p], "{aim:?} {k}: {} {slope}", slopes[k]);
            }
        }
        let mut lost = w.clone();
        lost.chunks_exact_mut(p).for_each(|row| row[1] = 2.0 * row[0]);
        lost.iter_mut().skip(3).step_by(p).for_each(|x| *x = 0.0);
        assert!(criterion(Aim::Determinant, lost, p, samples).is_none());
    }
}
