//! Bounds on the quality of any plan that can be chosen from given candidate experiments.
//!
//! F_i: information matrix of candidate i; F: sum over the N experiments of the plan; p: number of parameters; w: weights of the
//! candidates, whose sum is 1; M(w) = sum w_i F_i. For any other weights w*:
//!
//! log det M(w*) - log det M(w) <= max_i tr(F_i M(w)^-1) - p     [Kiefer, Wolfowitz 1960]
//!
//! The right side of this inequality is called gap. With it, the D-efficiency of the plan is bounded by (det F / det(N
//! M(w*)))^(1/p) >= exp[(log det F - p log N - log det M(w) - gap)/p].
//!
//! cond_fro^2 = tr F tr F^-1 is independent of the scale of F. If each F_i is scaled to unit trace, then for any w, cond_fro^2 >=
//! (tr M^-1)^2 / max_i tr(F_i M^-2): the dual of A-optimality.
//!
//! For the first bound, the weights are found by the multiplicative rule w_i <- w_i tr(F_i M^-1)/p, then by exchange between the
//! best and the worst candidate of the support with an exact line search. For the second bound they are found by w_i <- w_i
//! sqrt(tr(F_i M^-2)). Both bounds hold at every iteration.

use nalgebra::{DMatrix, SymmetricEigen};
use numerics::information_matrix::{InformationFactor, InformationMatrix, WeightedRows};
use numerics::interruption::Interruption;

use crate::plan::exchange::scales;

/// An approximate design (weights of the candidate experiments) with a bound on its quality.
#[derive(Clone, Debug, PartialEq)]
pub struct ApproximateDesign {
    /// Weights w of the candidates; their sum is 1.
    pub weights: Vec<f64>,
    /// log det M(w), with M(w) = sum w_i F_i of the candidates' information matrices. Minus infinity: all candidates together do
    /// not have full rank.
    pub log_det: f64,
    /// Bound of the distance to the optimum: no weights have a log det M above `log_det` + `gap`. M: information matrix of the
    /// weighted candidates.
    pub gap: f64,
    /// Number of iterations in which the weights were improved.
    pub iterations: usize,
}

/// Lower bound of the condition number sqrt(tr F tr F^-1) of any plan; F: information matrix of the plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConditionBound {
    /// The proved lower bound.
    pub bound: f64,
    /// sqrt(tr F tr F^-1) of the best approximate design (with fractional weights) that was found.
    pub reached: f64,
}
/// Number of iterations of the multiplicative rule for the weights. Then weight is exchanged between the best and the worst
/// candidate.
const MULTIPLICATIVE_ITERATIONS: usize = 300;
/// A candidate belongs to the support of a design (the candidates with weight) if its weight is at least this value.
const SUPPORT_WEIGHT: f64 = 1e-12;
/// Number of bisections in the search for the best amount of weight to exchange between two candidates.
const LINE_SEARCH_BISECTIONS: usize = 60;

/// Improves the weights w of an approximate design until the bound of its distance to the optimum (Kiefer-Wolfowitz gap) is below
/// `tolerance`, in at most `iterations`. If interrupted, it returns the bound at the current w. `blocks`: regressor rows of each
/// candidate.
pub fn determinant_bound(blocks: &[WeightedRows], tolerance: f64, iterations: usize) -> ApproximateDesign {
    let p = blocks.first().map_or(0, WeightedRows::width);
    let scale = scales(p, blocks.iter());
    let blocks: Vec<WeightedRows> = blocks.iter().map(|b| b.scaled(&scale)).collect();
    let log_scale = 2.0 * scale.iter().map(|s| s.ln()).sum::<f64>();
    let mut w = vec![1.0 / blocks.len().max(1) as f64; blocks.len()];
    let mut out = vec![0.0; p];
    for iteration in 0..iterations {
        // d_i = tr(F_i M^-1); F_i: information matrix of candidate i, M: of the design. The log det M of any other design exceeds
        // the present one by at most max d_i - p.
        let Some(factor) = design(&blocks, &w).factor() else { break };
        let d: Vec<f64> = blocks.iter().map(|b| factor.variance(b, &mut out)).collect();
        let best = argmax(&d, |_| true);
        let gap = d[best] - p as f64;
        if gap < tolerance || iteration + 1 == iterations || Interruption::check().is_err() {
            return ApproximateDesign { weights: w, log_det: factor.log_det - log_scale, gap, iterations: iteration };
        }
        if iteration < MULTIPLICATIVE_ITERATIONS {
            w.iter_mut().zip(&d).for_each(|(w, d)| *w *= d / p as f64);
            let sum: f64 = w.iter().sum();
            w.iter_mut().for_each(|w| *w /= sum);
        } else {
            let negative: Vec<f64> = d.iter().map(|d| -d).collect();
            let worst = argmax(&negative, |i| w[i] > SUPPORT_WEIGHT);
            let t = line_search(&factor, &blocks[best], &blocks[worst], w[worst]);
            w[best] += t;
            w[worst] = (w[worst] - t).max(0.0);
        }
    }
    ApproximateDesign { weights: w, log_det: f64::NEG_INFINITY, gap: f64::INFINITY, iterations: 0 }
}

/// Lower bound of the D-efficiency of a plan with `count` experiments and p parameters. `log_det`: log det of its information
/// matrix; `bound`: a design with a bound of its distance to the optimum.
pub fn certified_efficiency(log_det: f64, count: usize, p: usize, bound: &ApproximateDesign) -> f64 {
    let p = p as f64;
    ((log_det - p * (count as f64).ln() - bound.log_det - bound.gap) / p).exp()
}

/// Improves the weights w of an approximate design to lower tr M(w)^-1; M: information matrix of the design. Returns the bound of
/// the condition number. Ends when the square of the bound is within the relative `tolerance`, or after `iterations`.
pub fn condition_bound(blocks: &[WeightedRows], tolerance: f64, iterations: usize) -> ConditionBound {
    let p = blocks.first().map_or(0, WeightedRows::width);
    let unit = |b: &WeightedRows| b.scaled(&vec![1.0 / b.trace().sqrt(); p]);
    let blocks: Vec<WeightedRows> = blocks.iter().filter(|b| b.trace() > 0.0).map(unit).collect();
    let mut w = vec![1.0 / blocks.len().max(1) as f64; blocks.len()];
    let mut best = ConditionBound { bound: 0.0, reached: f64::INFINITY };
    for _ in 0..iterations {
        let Some(factor) = design(&blocks, &w).factor() else { break };
        let inverse = factor.inverse();
        // tr(F_i M^-2) = |M^-1 W_i'|^2; W_i: rows of candidate i, F_i = W_i' W_i, M: information matrix of the design.
        let square = |row: &[f64]| {
            let along = |i: usize| inverse[i * p..(i + 1) * p].iter().zip(row).map(|(m, x)| m * x).sum::<f64>();
            (0..p).map(|i| along(i).powi(2)).sum::<f64>()
        };
        let d: Vec<f64> = blocks.iter().map(|b| b.iter().map(square).sum()).collect();
        let trace: f64 = (0..p).map(|i| inverse[i * p + i]).sum();
        let greatest = d.iter().copied().fold(0.0, f64::max);
        best.bound = best.bound.max(trace / greatest.sqrt());
        best.reached = best.reached.min(trace.sqrt());
        if 1.0 - trace / greatest < tolerance || Interruption::check().is_err() {
            break;
        }
        w.iter_mut().zip(&d).for_each(|(w, d)| *w *= (d / trace).sqrt());
        let sum: f64 = w.iter().sum();
        w.iter_mut().for_each(|w| *w /= sum);
    }
    best
}

fn design(blocks: &[WeightedRows], w: &[f64]) -> InformationMatrix {
    let p = blocks.first().map_or(0, WeightedRows::width);
    InformationMatrix::sum(p, 0.0, blocks.iter().zip(w.iter().copied()).filter(|(_, w)| *w > 0.0))
}

fn argmax(values: &[f64], allowed: impl Fn(usize) -> bool) -> usize {
    let all = (0..values.len()).filter(|&i| allowed(i));
    all.fold(None, |best: Option<usize>, i| match best {
        Some(b) if values[b] >= values[i] => Some(b),
        _ => Some(i),
    })
    .unwrap_or(0)
}

/// The step t in [0, limit] that maximises log det(M + t (F_gain - F_lose)); M has the factorisation `factor`, and F_gain and
/// F_lose are the information matrices of the two candidates.
pub(crate) fn line_search(factor: &InformationFactor, gain: &WeightedRows, lose: &WeightedRows, limit: f64) -> f64 {
    let p = gain.width();
    let mut g = DMatrix::<f64>::zeros(p, p);
    let mut z = vec![0.0; p];
    for (rows, sign) in [(gain, 1.0), (lose, -1.0)] {
        for row in rows.iter() {
            factor.whiten(row, &mut z);
            for i in 0..p {
                for j in 0..p {
                    g[(i, j)] += sign * z[i] * z[j];
                }
            }
        }
    }
    // With G = F_gain - F_lose: d/dt log det(M + t G) = sum_i e_i / (1 + t e_i), e: eigenvalues of M^-1/2 G M^-1/2.
    let e = SymmetricEigen::new(g).eigenvalues;
    let slope = |t: f64| {
        let positive = e.iter().all(|e| 1.0 + t * e > 0.0);
        if positive { e.iter().map(|e| e / (1.0 + t * e)).sum() } else { f64::NEG_INFINITY }
    };
    if slope(limit) > 0.0 {
        return limit;
    }
    let (mut low, mut high) = (0.0, limit);
    for _ in 0..LINE_SEARCH_BISECTIONS {
        let t = 0.5 * (low + high);
        if slope(t) > 0.0 { low = t } else { high = t }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::exchange::{Criterion, SearchEffort, exchange, value_of};
    use crate::plan::test_plans::random_blocks;

    /// Candidates that observe y = a + b t at t in [-1, 1]; the optimal design has half of its weight at each end.
    fn line() -> Vec<WeightedRows> {
        let point = |i: usize| {
            let mut rows = WeightedRows::new(2);
            rows.push(&[1.0, -1.0 + i as f64 / 5.0]);
            rows
        };
        (0..11).map(point).collect()
    }

    #[test]
    fn straight_line_design_is_known() {
        let d = determinant_bound(&line(), 1e-9, 4000);
        // The optimal information matrix is M = I, so its log det is 0.
        assert!(d.log_det.abs() < 1e-8 && d.gap < 1e-9, "{d:?}");
        assert!((d.weights[0] - 0.5).abs() < 1e-4 && (d.weights[10] - 0.5).abs() < 1e-4);
        let plan = value_of(&line(), &[0, 10], Criterion::Determinant);
        assert!((certified_efficiency(plan, 2, 2, &d) - 1.0).abs() < 1e-8);
        let c = condition_bound(&line(), 1e-9, 4000);
        // tr M tr M^-1 >= p^2 with p = 2 parameters. Equality holds for M = I/2, the optimal design of candidates with unit
        // trace.
        assert!(c.bound <= 2.0 + 1e-9 && c.bound > 2.0 - 1e-4 && c.reached > 2.0 - 1e-9, "{c:?}");
    }

    #[test]
    fn no_plan_passes_its_certificate() {
        let blocks = random_blocks(40, 5, 4);
        let d = determinant_bound(&blocks, 1e-3, 3000);
        let c = condition_bound(&blocks, 1e-3, 3000);
        assert!(d.gap <= 1e-3);
        for count in [3, 6, 40] {
            let search = SearchEffort { starts: 4, ..SearchEffort::default() };
            let found = exchange(&blocks, count, Criterion::Determinant, &search, &|_, _, _| ());
            assert!(certified_efficiency(found.value, count, 5, &d) <= 1.0);
            let found = exchange(&blocks, count, Criterion::FrobeniusCondition, &search, &|_, _, _| ());
            assert!((-found.value).exp() >= c.bound);
        }
    }
}
