//! Computes friction columns with a jump or kink at reversals, before the low-pass of the torques.
//!
//! The low-pass smooths the jump of a torque at a reversal. A friction column f(dq) must be smoothed in the same way. So f is
//! computed from a lightly filtered velocity, and the column is filtered then. If f were computed from the filtered velocity, the
//! column would differ: a filtered velocity changes sign earlier or later, and more slowly, than the joint.
//!
//! A row at time t represents its cell [t - h/2, t + h/2], h: sample time. The velocity is taken as linear on either side of t.
//! With F the antiderivative of f, the mean of f over velocities from a to b is (F(b) - F(a)) / (b - a). F = abs(v) for the sign,
//! and F = w ln cosh(v/w) for tanh(v/w), w: width of the smooth jump. The sign at the samples alone would shift every reversal by
//! up to half a sample.
//!
//! | term | column before the filter; s: mean sign |
//! |---|---|
//! | Coulomb | s |
//! | smooth Coulomb | mean of tanh(v/w) |
//! | asymmetric | max(v, 0), (1 + s)/2, min(v, 0), (1 - s)/2 |
//! | Stribeck | s exp(-(v/v_s)^2) |
//! | load | s abs(tau) |

use linear_model::friction::terms::{FrictionTerm, sign};

/// The mean direction of each row, from -1 to 1: the mean sign of the velocity v over the cell of the row (half a sample before
/// and after the row).
pub fn directions(v: &[f64]) -> Vec<f64> {
    let mean = |a: f64, b: f64| if a == b || a * b > 0.0 { sign(a) } else { (b.abs() - a.abs()) / (b - a) };
    let direction = |i: usize| match v.get(i.wrapping_sub(1)..i + 2) {
        // Most rows have no reversal: their direction is the sign of v.
        Some(&[before, at, after]) if before * at > 0.0 && at * after > 0.0 => sign(at),
        _ => cell_mean(v, i, mean),
    };
    (0..v.len()).map(direction).collect()
}

/// The columns of a friction term, one series each, from velocities v, rad/s (m/s), and torques, N m (N).
///
/// Empty for a term with columns that are linear in the motion or equal to the direction.
pub fn columns(term: FrictionTerm, v: &[f64], tau: &[f64]) -> Vec<Vec<f64>> {
    let of = |f: &dyn Fn(f64, f64) -> f64| v.iter().zip(directions(v)).map(|(&v, s)| f(v, s)).collect::<Vec<f64>>();
    match term {
        FrictionTerm::SmoothCoulomb(width) => vec![cell_means(v, |a, b| mean_tanh(a, b, width))],
        FrictionTerm::Asymmetric => vec![
            of(&|v, _| v.max(0.0)),
            of(&|_, s| 0.5 * (1.0 + s)),
            of(&|v, _| v.min(0.0)),
            of(&|_, s| 0.5 * (1.0 - s)),
        ],
        FrictionTerm::Stribeck(speed) => vec![of(&|v, s| s * (-(v / speed) * (v / speed)).exp())],
        FrictionTerm::Load => vec![directions(v).iter().zip(tau).map(|(s, tau)| s * tau.abs()).collect()],
        FrictionTerm::Viscous
        | FrictionTerm::Coulomb
        | FrictionTerm::Offset
        | FrictionTerm::Rotor
        | FrictionTerm::At(..) => Vec::new(),
    }
}

/// A velocity interval is narrow if its length |b - a| is below this share of w (width of the smooth jump). The mean of
/// tanh(v/w) over a narrow interval is taken as the value in the middle, because the difference quotient would have a larger
/// error from rounding.
const NARROW_INTERVAL_RATIO: f64 = 1e-3;

/// The mean of a function f of the velocity over the cell of each row (half a sample before and after the row). `mean(a, b)`:
/// mean of f over the velocities from a to b.
fn cell_means(v: &[f64], mean: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    (0..v.len()).map(|i| cell_mean(v, i, &mean)).collect()
}

/// The mean of a function of the velocity over the cell of row i: the average of two means, over the half cell before the
/// sample and over the half cell after it.
fn cell_mean(v: &[f64], i: usize, mean: impl Fn(f64, f64) -> f64) -> f64 {
    let before = 0.5 * (v[i.saturating_sub(1)] + v[i]);
    let after = 0.5 * (v[i] + v[(i + 1).min(v.len() - 1)]);
    0.5 * (mean(before, v[i]) + mean(v[i], after))
}

/// The mean of tanh(v/w) over the velocities v from a to b.
fn mean_tanh(a: f64, b: f64, w: f64) -> f64 {
    if (b - a).abs() < NARROW_INTERVAL_RATIO * w {
        return (0.5 * (a + b) / w).tanh();
    }
    let log_cosh = |x: f64| x.abs() + (-2.0 * x.abs()).exp().ln_1p();
    w * (log_cosh(b / w) - log_cosh(a / w)) / (b - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sum over the cells, in samples, is the time of forward motion minus the time of backward motion. The sum does not
    /// depend on where the samples are.
    #[test]
    fn a_reversal_is_where_it_is() {
        for shift in [0.0, 0.13, 0.5, 0.77] {
            let v: Vec<f64> = (0..21).map(|i| 0.3 * (i as f64 - 10.0 + shift)).collect();
            // The joint moves forward from sample 10 - shift on. The half cells at both ends of the sum are left out.
            let sum: f64 = directions(&v)[1..20].iter().sum();
            assert!((sum - 2.0 * shift).abs() < 1e-12, "{shift} {sum}");
            let narrow: f64 = columns(FrictionTerm::SmoothCoulomb(1e-4), &v, &v)[0][1..20].iter().sum();
            assert!((narrow - sum).abs() < 1e-3);
        }
        assert_eq!(directions(&[0.0, 0.0, 0.0]), [0.0; 3]);
        assert_eq!(directions(&[]), [] as [f64; 0]);
    }

    #[test]
    fn the_cell_of_a_smooth_law_is_its_mean() {
        for (a, b, w) in [(-0.01, 0.03, 0.005), (0.2, 0.21, 0.1), (0.02, 0.020001, 0.05), (-3.0, -2.0, 1e-3)] {
            let at = |i: usize| ((a + (b - a) * (i as f64 + 0.5) / 4000.0) / w).tanh();
            let mean = (0..4000).map(at).sum::<f64>() / 4000.0;
            // Allowed error: error of the midpoint rule with 4000 steps.
            assert!((mean_tanh(a, b, w) - mean).abs() < 1e-6, "{a} {b} {w}");
        }
    }

    #[test]
    fn the_columns_are_those_of_the_terms() {
        let (v, tau) = ([-0.4; 5], [2.0; 5]);
        use FrictionTerm::*;
        for term in [SmoothCoulomb(0.3), Asymmetric, Stribeck(0.5), Load] {
            let mut expected = vec![0.0; term.parameters().len()];
            term.fill(-0.4, 0.0, 2.0, -1.0, &mut expected);
            let found: Vec<f64> = columns(term, &v, &tau).iter().map(|x| x[2]).collect();
            assert_eq!(found.len(), expected.len());
            found.iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{term} {found:?}"));
        }
        assert!([Viscous, Coulomb, Offset, Rotor].into_iter().all(|term| columns(term, &v, &tau).is_empty()));
    }
}
