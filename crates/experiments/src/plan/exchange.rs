//! Chooses the experiments of a plan: exchange algorithm on blocks of rows, from many random starts.
//!
//! Each experiment i gives a block W_i of rows; a plan of N experiments has F = sum W_i' W_i. A start begins with a random plan.
//! It replaces the experiment at each position of the plan by the best candidate, until no exchange improves the criterion. For a
//! further experiment with the rows W,
//!
//! det(F + W'W) = det F det(I + W F^-1 W'),
//! tr (F + W'W)^-1 = tr F^-1 - tr((I + W F^-1 W')^-1 W F^-2 W').
//!
//! | criterion | rows | equation |
//! |---|---|---|
//! | greatest log det F | divided by their noise | [Fedorov 1972] |
//! | least sqrt(tr F tr F^-1) | not divided | (15) of [Vandanjon, Gautier, Desbats 1995] |
//!
//! The two criteria give different plans. The result does not depend on the number of threads, for two reasons: each start has
//! a number and its own stream of random numbers, and among starts with equally good plans, the start with the lowest number
//! wins. `certificate` bounds how much better the best possible plan can be.

use numerics::information_matrix::{InformationFactor, InformationMatrix, WeightedRows};
use numerics::interruption::Interruption;
use processor::in_parallel;
use random::Random;

/// The criterion that a plan maximises; F is its information matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Criterion {
    /// log det F: the information on all parameters together.
    Determinant,
    /// Minus the logarithm of the Frobenius condition number sqrt(tr F tr F^-1).
    FrobeniusCondition,
}

/// Effort of the search for a plan: number of starts, passes, threads and nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchEffort {
    /// Number of random initial plans from which the exchange starts.
    pub starts: usize,
    /// Greatest number of passes of one start over the positions of the plan.
    pub sweeps: usize,
    /// Number of threads that share the starts; it does not change the result.
    pub threads: usize,
    /// Seed of the random initial plans.
    pub seed: u64,
    /// Greatest number of nodes of the branch and bound that follows the exchange; 0: none is run.
    pub nodes: usize,
    /// The branch and bound ends when the D-efficiency is proved up to this relative gap.
    pub tolerance: f64,
}

impl Default for SearchEffort {
    fn default() -> SearchEffort {
        SearchEffort { starts: 12, sweeps: 100, threads: 2, seed: 1, nodes: 0, tolerance: 1e-3 }
    }
}

/// Settings for the choice of a plan: number of experiments, criterion, and effort of the search.
#[derive(Clone, Debug)]
pub struct ExchangeSettings {
    /// Number of experiments in the plan.
    pub count: usize,
    /// The criterion that is maximised.
    pub criterion: Criterion,
    /// The effort of the search.
    pub search: SearchEffort,
}

/// The best plan that the exchange algorithm found.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Indices of the chosen candidates, ascending; a candidate that runs more than once is listed more than once.
    pub chosen: Vec<usize>,
    /// Value of the criterion for the plan. Minus infinity if the information matrix of the plan does not have full rank.
    pub value: f64,
    /// Value of the criterion that each start reached, in the order of the starts. These values are computed with scaled columns
    /// and with a small ridge.
    pub starts: Vec<f64>,
}

/// Ridge added to a plan's information matrix, relative to the mean information. It keeps the update formulas finite while a plan
/// does not have full rank.
const RELATIVE_RIDGE: f64 = 1e-9;

/// Number of candidates that are evaluated between two checks for an interruption. Their evaluation takes some milliseconds.
const BLOCKS_PER_CHECK: usize = 64;
/// If the relative gain of an exchange is below this value, the gain is only a rounding error.
const LEAST_RELATIVE_GAIN: f64 = 1e-10;

/// Chooses the best plan of `count` experiments by exchange, from `search.starts` random plans. `blocks`: regressor rows of each
/// candidate.
///
/// `progress` receives (ended starts, number of starts, best value) from one thread at a time. If the search is interrupted, it
/// gives the best plan found so far.
pub fn exchange(
    blocks: &[WeightedRows],
    count: usize,
    criterion: Criterion,
    search: &SearchEffort,
    progress: &(dyn Fn(usize, usize, f64) + Sync),
) -> Selection {
    let p = blocks.first().map_or(0, WeightedRows::width);
    if p == 0 || count == 0 {
        return Selection { chosen: vec![], value: f64::NEG_INFINITY, starts: vec![] };
    }
    let scaled = equilibrated(blocks, criterion);
    let done = std::sync::Mutex::new((0, f64::NEG_INFINITY));
    let interruption = Interruption::here();
    // The result of a start depends only on its number, not on its thread.
    let start = |s: usize| {
        let mut random = Random::stream(search.seed, s as u64);
        let found = interruption.during(|| one_start(&scaled, count, criterion, search.sweeps, &mut random));
        if let Ok(mut state) = done.lock() {
            *state = (state.0 + 1, state.1.max(found.1));
            progress(state.0, search.starts, state.1);
        }
        found
    };
    let unless_interrupted = |s| (!interruption.is_raised()).then(|| start(s));
    let found = in_parallel((0..search.starts).collect(), search.threads, unless_interrupted);
    let found: Vec<(Vec<usize>, f64)> = found.into_iter().flatten().collect();
    let starts: Vec<f64> = found.iter().map(|f| f.1).collect();
    let best = found.into_iter().reduce(|a, b| if b.1 > a.1 { b } else { a });
    let mut chosen = best.map(|b| b.0).unwrap_or_default();
    chosen.sort_unstable();
    let value = value_of(blocks, &chosen, criterion);
    Selection { chosen, value, starts }
}

/// The criterion of a plan: log det F, or - log sqrt(tr F tr F^-1); F: information matrix of the plan. Minus infinity if F does
/// not have full rank. `chosen`: indices of the candidates in the plan.
pub fn value_of(blocks: &[WeightedRows], chosen: &[usize], criterion: Criterion) -> f64 {
    let p = blocks.first().map_or(0, WeightedRows::width);
    let of_plan = || chosen.iter().filter_map(|&i| blocks.get(i));
    match criterion {
        Criterion::Determinant => {
            // The columns are scaled, so that different units are not mistaken for a lack of rank.
            let scale = scales(p, of_plan());
            let scaled: Vec<WeightedRows> = of_plan().map(|b| b.scaled(&scale)).collect();
            let factor = InformationMatrix::sum(p, 0.0, scaled.iter().map(|b| (b, 1.0))).factor();
            factor.map_or(f64::NEG_INFINITY, |f| f.log_det - 2.0 * scale.iter().map(|s| s.ln()).sum::<f64>())
        }
        Criterion::FrobeniusCondition => {
            let f = InformationMatrix::sum(p, 0.0, of_plan().map(|b| (b, 1.0)));
            f.factor().map_or(f64::NEG_INFINITY, |l| -0.5 * (f.trace() * l.trace_of_inverse()).ln())
        }
    }
}

/// The rows of all candidates with scaled columns. For the determinant, each column is divided by its root mean square, so that
/// the small ridge has the same effect on each. For the condition number, the columns keep their relative scale; only their mean
/// trace is scaled to one.
fn equilibrated(blocks: &[WeightedRows], criterion: Criterion) -> Vec<WeightedRows> {
    let p = blocks.first().map_or(0, WeightedRows::width);
    let scale = match criterion {
        Criterion::Determinant => scales(p, blocks.iter()),
        Criterion::FrobeniusCondition => {
            let trace: f64 = blocks.iter().map(WeightedRows::trace).sum::<f64>() / (blocks.len() * p) as f64;
            vec![1.0 / trace.sqrt().max(f64::MIN_POSITIVE); p]
        }
    };
    blocks.iter().map(|b| b.scaled(&scale)).collect()
}

/// Scale factor of each of the p regressor columns: 1 / root mean square over all candidates; 1 for a column of zeros.
pub fn scales<'a>(p: usize, blocks: impl Iterator<Item = &'a WeightedRows>) -> Vec<f64> {
    let (mut squares, mut count) = (vec![0.0; p], 0);
    for b in blocks {
        count += 1;
        for row in b.iter() {
            squares.iter_mut().zip(row).for_each(|(s, x)| *s += x * x);
        }
    }
    squares.iter().map(|&s| if s > 0.0 { (f64::from(count) / s).sqrt() } else { 1.0 }).collect()
}

fn one_start(
    blocks: &[WeightedRows],
    count: usize,
    criterion: Criterion,
    sweeps: usize,
    random: &mut Random,
) -> (Vec<usize>, f64) {
    let p = blocks[0].width();
    let mut chosen: Vec<usize> = (0..count).map(|_| random.index(blocks.len())).collect();
    let ridge = RELATIVE_RIDGE * count as f64;
    let plan = |chosen: &[usize], without: Option<usize>| {
        let kept = chosen.iter().enumerate().filter(|(at, _)| Some(*at) != without);
        InformationMatrix::sum(p, ridge, kept.map(|(_, &i)| (&blocks[i], 1.0)))
    };
    let value = |f: &InformationMatrix| match (f.factor(), criterion) {
        (None, _) => f64::NEG_INFINITY,
        (Some(l), Criterion::Determinant) => l.log_det,
        (Some(l), Criterion::FrobeniusCondition) => -0.5 * (f.trace() * l.trace_of_inverse()).ln(),
    };
    let mut best = value(&plan(&chosen, None));
    let mut work = ExchangeWork::default();
    for _ in 0..sweeps {
        let mut gained = false;
        for at in 0..count {
            if Interruption::check().is_err() {
                break;
            }
            let rest = plan(&chosen, Some(at));
            let Some(factor) = rest.factor() else { continue };
            let gain = Gain::new(&rest, &factor, criterion);
            for (i, block) in blocks.iter().enumerate() {
                if i % BLOCKS_PER_CHECK == 0 && Interruption::check().is_err() {
                    break;
                }
                let v = gain.with(block, &mut work);
                // An exchange whose gain is only a rounding error could repeat forever.
                if v > best + LEAST_RELATIVE_GAIN * best.abs().max(1.0) {
                    best = v;
                    chosen[at] = i;
                    gained = true;
                }
            }
        }
        if !gained {
            break;
        }
    }
    (chosen, best)
}

/// Computes the criterion of a plan with the information matrix F + W'W. W: rows of any candidate; F: information matrix of the
/// other experiments.
struct Gain<'a> {
    factor: &'a InformationFactor,
    criterion: Criterion,
    trace: f64,
    trace_of_inverse: f64,
    /// B = L^-1 L^-T, p x p; L: Cholesky factor of the information matrix, F = L L'. Then F^-2 = L^-T B L^-1. Empty for the
    /// determinant.
    between: Vec<f64>,
}

#[derive(Default)]
struct ExchangeWork {
    whitened: Vec<f64>,
    small: Vec<f64>,
    right: Vec<f64>,
}

impl<'a> Gain<'a> {
    fn new(f: &InformationMatrix, factor: &'a InformationFactor, criterion: Criterion) -> Gain<'a> {
        let between = match criterion {
            Criterion::Determinant => vec![],
            Criterion::FrobeniusCondition => factor.inverse_gram(),
        };
        Gain { factor, criterion, trace: f.trace(), trace_of_inverse: factor.trace_of_inverse(), between }
    }

    fn with(&self, block: &WeightedRows, work: &mut ExchangeWork) -> f64 {
        let (p, m) = (block.width(), block.len());
        // Z = L^-1 W', stored as m rows of p entries, and S = I + Z'Z, m x m. W: m rows of the candidate; L: Cholesky factor of
        // F.
        work.whitened.resize(m * p, 0.0);
        for (r, row) in block.iter().enumerate() {
            self.factor.whiten(row, &mut work.whitened[r * p..(r + 1) * p]);
        }
        let z = |r: usize| &work.whitened[r * p..(r + 1) * p];
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        work.small.clear();
        for a in 0..m {
            for b in 0..m {
                work.small.push(dot(z(a), z(b)) + if a == b { 1.0 } else { 0.0 });
            }
        }
        match self.criterion {
            Criterion::Determinant => {
                let mut log_det = self.factor.log_det;
                eliminate(&mut work.small, &mut [], m, |pivot| log_det += pivot.ln());
                log_det
            }
            Criterion::FrobeniusCondition => {
                // The decrease of tr F^-1 is tr(S^-1 Z' B Z); B = L^-1 L^-T, L: Cholesky factor of F.
                work.right.clear();
                for a in 0..m {
                    for b in 0..m {
                        let s: f64 = (0..p).map(|i| z(a)[i] * dot(&self.between[i * p..(i + 1) * p], z(b))).sum();
                        work.right.push(s);
                    }
                }
                eliminate(&mut work.small, &mut work.right, m, |_| ());
                let removed: f64 = (0..m).map(|a| work.right[a * m + a]).sum();
                let inverse = self.trace_of_inverse - removed;
                if inverse > 0.0 { -0.5 * ((self.trace + block.trace()) * inverse).ln() } else { f64::NEG_INFINITY }
            }
        }
    }
}

/// Gauss-Jordan elimination of a positive definite m x m matrix `a`, with right-hand sides `b` (m columns, or none). `pivot`
/// receives each pivot.
fn eliminate(a: &mut [f64], b: &mut [f64], m: usize, mut pivot: impl FnMut(f64)) {
    let columns = b.len() / m.max(1);
    for k in 0..m {
        let d = a[k * m + k];
        pivot(d);
        for c in k + 1..m {
            a[k * m + c] /= d;
        }
        for c in 0..columns {
            b[k * columns + c] /= d;
        }
        for i in 0..m {
            if i == k || (columns == 0 && i < k) {
                continue;
            }
            let f = a[i * m + k];
            for c in k + 1..m {
                a[i * m + c] -= f * a[k * m + c];
            }
            for c in 0..columns {
                b[i * columns + c] -= f * b[k * columns + c];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::test_plans::random_blocks;

    fn search(threads: usize) -> SearchEffort {
        SearchEffort { starts: 6, threads, ..SearchEffort::default() }
    }

    #[test]
    fn updates_agree_with_refactoring() {
        let blocks = random_blocks(8, 5, 3);
        let rest = InformationMatrix::sum(5, 0.0, blocks[..5].iter().map(|b| (b, 1.0)));
        let factor = rest.factor().unwrap();
        for criterion in [Criterion::Determinant, Criterion::FrobeniusCondition] {
            let gain = Gain::new(&rest, &factor, criterion);
            for i in 5..8 {
                let direct = value_of(&blocks, &[0, 1, 2, 3, 4, i], criterion);
                assert!((gain.with(&blocks[i], &mut ExchangeWork::default()) - direct).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn finds_the_best_of_all_small_plans() {
        let blocks = random_blocks(9, 4, 7);
        for criterion in [Criterion::Determinant, Criterion::FrobeniusCondition] {
            let found = exchange(&blocks, 4, criterion, &search(2), &|_, _, _| ());
            let mut best = f64::NEG_INFINITY;
            for code in 0..9_usize.pow(4) {
                let chosen = [code % 9, code / 9 % 9, code / 81 % 9, code / 729];
                best = best.max(value_of(&blocks, &chosen, criterion));
            }
            assert!((found.value - best).abs() < 1e-8, "{criterion:?} {} {best}", found.value);
        }
    }

    #[test]
    fn threads_change_nothing() {
        let blocks = random_blocks(60, 8, 11);
        let of = |threads| exchange(&blocks, 7, Criterion::Determinant, &search(threads), &|_, _, _| ());
        let one = of(1);
        assert_eq!(one, of(2));
        assert_eq!(one, of(5));
    }

    #[test]
    fn a_plan_without_rank_says_so() {
        let blocks = random_blocks(5, 30, 2);
        let found = exchange(&blocks, 3, Criterion::Determinant, &search(1), &|_, _, _| ());
        assert_eq!(found.value, f64::NEG_INFINITY);
        assert!(exchange(&[], 3, Criterion::Determinant, &search(1), &|_, _, _| ()).chosen.is_empty());
    }
}
