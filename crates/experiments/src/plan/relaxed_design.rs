//! Finds the best relaxed design (fractional numbers of runs of candidates) between bounds, and the upper bound that it proves.
//!
//! Over x with low <= x <= high and sum x = N, maximise log det F(x), F(x) = sum x_i F_i, F_i = W_i'W_i. For any x of full
//! rank, with T = F(x)^-1 and g_i = tr(F_i T),
//!
//! log det F(y) <= log det F(x) - p + max over y of sum y_i g_i
//!
//! because a concave function lies below its tangent: this is the natural (Lagrangian) bound of [Ponte, Fampa, Lee 2023] at the
//! dual point T. For the maximum, the candidates with the greatest g get their greatest number of runs, until N runs are used.
//! The g of the last candidate that gets runs is the price nu of an experiment. One run of candidate i changes the bound by g_i -
//! nu. If x_i is at a bound and g_i is far from the price, x_i is at this bound in every plan that is as good as a known plan.
//!
//! The ascent is a Newton method. Each step is the best step of [`crate::plan::quadratic_model`] between the bounds; a step is
//! halved until log det F increases. The bound holds at every iteration.

use numerics::information_matrix::{InformationMatrix, WeightedRows};

use crate::plan::quadratic_model::{QuadraticModel, StepBounds};

/// Greatest number of moves (shifts of runs between two candidates) in one step of the ascent: several for each candidate that
/// has runs.
const MAX_ASCENT_MOVES: usize = 400;
/// Greatest number of candidates without runs to which one step of the ascent may give runs.
const MAX_ENTERING_CANDIDATES: usize = 40;
/// Number of runs that is added to every candidate if no design between the bounds has full rank.
const REGULARIZING_RUNS: f64 = 1e-3;
/// Numbers of runs in a design are rounded to multiples of one over this number. The effect of the rounding on the bound is
/// only of second order.
const PARTS_PER_EXPERIMENT: f64 = 1e5;
/// Greatest number of halvings of a step of the ascent that does not increase log det F.
const MAX_STEP_HALVINGS: i32 = 12;
/// An initial design without full rank is mixed with this share of a design in which all allowed candidates have runs.
const MIXED_SHARE: f64 = 0.1;

/// Least and greatest number of runs of each candidate in a set of plans.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// Least number of runs, one per candidate.
    pub low: Vec<usize>,
    /// Greatest number of runs, one per candidate.
    pub high: Vec<usize>,
}

/// The tangent of log det F at a design x. For any other design y, log det F(y) is at most `constant` + sum y_i g_i. F:
/// information matrix; g_i: slopes.
#[derive(Clone, Debug, PartialEq)]
pub struct Tangent {
    /// log det F(x) - p; F: information matrix of the design x, p: number of parameters.
    pub constant: f64,
    /// Slopes g_i = tr(F_i F(x)^-1), one per candidate i; F_i: information matrix of the candidate, F(x): of the design.
    pub gain: Vec<f64>,
}

/// A relaxed design (fractional numbers of runs) with the upper bound that it proves.
#[derive(Clone, Debug)]
pub struct Relaxed {
    /// Fractional number of runs, one per candidate.
    pub x: Vec<f64>,
    /// The tangent of log det F at this design (F: information matrix). It gives an upper bound for every plan.
    pub tangent: Tangent,
    /// Second-order model of log det F about this design; F: information matrix.
    pub model: QuadraticModel,
    /// Upper bound of log det F for all designs between the bounds of the search.
    pub bound: f64,
}

impl Bounds {
    fn has_room_for(&self, count: usize) -> bool {
        self.low.iter().sum::<usize>() <= count && self.high.iter().sum::<usize>() >= count
    }

    /// Keeps only the plans with at most `at_most` runs of a candidate (`keeps_below`), or else only the plans with more runs
    /// of this candidate.
    pub fn cut(&mut self, candidate: usize, at_most: usize, keeps_below: bool) {
        if keeps_below {
            self.high[candidate] = self.high[candidate].min(at_most);
        } else {
            self.low[candidate] = self.low[candidate].max(at_most + 1);
        }
    }

    /// The range from the number of runs in the design `x` to the bounds, for each candidate.
    pub fn room(&self, x: &[f64]) -> StepBounds {
        let to = |ends: &[usize]| ends.iter().zip(x).map(|(end, x)| *end as f64 - x).collect();
        StepBounds { least: to(&self.low), most: to(&self.high) }
    }

    /// The candidates that a step may change: all candidates above their least number of runs, and, of the other candidates,
    /// those with the greatest slopes `gain`.
    fn members(&self, x: &[f64], gain: &[f64]) -> Vec<usize> {
        let is_above = |i: usize| x[i] > self.low[i] as f64;
        let mut found: Vec<usize> = (0..x.len()).filter(|&i| !is_above(i) && self.low[i] < self.high[i]).collect();
        found.sort_by(|&a, &b| gain[b].total_cmp(&gain[a]).then(a.cmp(&b)));
        found.truncate(MAX_ENTERING_CANDIDATES);
        found.extend((0..x.len()).filter(|&i| is_above(i)));
        found.sort_unstable();
        found
    }

    /// Rounds the numbers of runs to few decimals, with the sum `count`. So a file contains exactly the numbers of the
    /// computation.
    fn on_grid(&self, x: impl Iterator<Item = f64>, count: usize) -> Vec<f64> {
        let ends = |i: usize| (self.low[i] as f64 * PARTS_PER_EXPERIMENT, self.high[i] as f64 * PARTS_PER_EXPERIMENT);
        let mut parts: Vec<f64> = x.map(|x| (x * PARTS_PER_EXPERIMENT).round()).collect();
        parts.iter_mut().enumerate().for_each(|(i, x)| *x = x.clamp(ends(i).0, ends(i).1));
        // The sum of whole numbers is exact. The candidates with the most runs take the remainder that rounding leaves.
        let mut left = count as f64 * PARTS_PER_EXPERIMENT - parts.iter().sum::<f64>();
        let mut order: Vec<usize> = (0..parts.len()).collect();
        order.sort_by(|&a, &b| parts[b].total_cmp(&parts[a]).then(a.cmp(&b)));
        for i in order {
            let by = left.clamp(ends(i).0 - parts[i], ends(i).1 - parts[i]);
            (parts[i], left) = (parts[i] + by, left - by);
        }
        parts.into_iter().map(|x| x / PARTS_PER_EXPERIMENT).collect()
    }

    /// A design near `wanted` that keeps the bounds and has `count` runs in total.
    fn nearest(&self, wanted: &[f64], count: usize) -> Vec<f64> {
        let ends = |i: usize| (self.low[i] as f64, self.high[i] as f64);
        let mut x: Vec<f64> = wanted.iter().enumerate().map(|(i, x)| x.clamp(ends(i).0, ends(i).1)).collect();
        let missing = count as f64 - x.iter().sum::<f64>();
        let room = |i: usize, x: f64| if missing > 0.0 { ends(i).1 - x } else { x - ends(i).0 };
        let all: f64 = x.iter().enumerate().map(|(i, x)| room(i, *x)).sum();
        if all > 0.0 {
            for i in 0..x.len() {
                x[i] = (x[i] + missing * room(i, x[i]) / all).clamp(ends(i).0, ends(i).1);
            }
        }
        x
    }
}

impl Tangent {
    /// The greatest value of the tangent over all designs between the bounds, and the price of an experiment: the slope of the
    /// last candidate that gets runs. Minus infinity if the bounds do not allow `count` experiments.
    pub fn bound(&self, bounds: &Bounds, count: usize) -> (f64, f64) {
        if !bounds.has_room_for(count) {
            return (f64::NEG_INFINITY, 0.0);
        }
        let mut order: Vec<usize> = (0..self.gain.len()).collect();
        order.sort_by(|&a, &b| self.gain[b].total_cmp(&self.gain[a]).then(a.cmp(&b)));
        let mut left = count - bounds.low.iter().sum::<usize>();
        let mut sum: f64 = bounds.low.iter().zip(&self.gain).map(|(x, g)| *x as f64 * g).sum();
        let mut price = 0.0;
        for i in order {
            let taken = left.min(bounds.high[i] - bounds.low[i]);
            if taken > 0 {
                (sum, price, left) = (sum + taken as f64 * self.gain[i], self.gain[i], left - taken);
            }
        }
        (self.constant + sum, price)
    }
}

/// The tangent of log det F at the design `x`. `None` if the design does not have full rank. `blocks`: rows of each candidate.
pub fn tangent(blocks: &[WeightedRows], x: &[f64]) -> Option<Tangent> {
    let p = blocks.first().map_or(0, WeightedRows::width);
    let used = blocks.iter().zip(x.iter().copied()).filter(|(_, x)| *x > 0.0);
    let factor = InformationMatrix::sum(p, 0.0, used).factor()?;
    let mut out = vec![0.0; p];
    let gain = blocks.iter().map(|b| factor.variance(b, &mut out)).collect();
    Some(Tangent { constant: factor.log_det - p as f64, gain })
}

/// Maximises log det F (F: information matrix) over the designs between the bounds, from the design `start`, in at most `steps`
/// steps. Ends if the upper bound is below `target`, or within `tolerance` of the reached value.
///
/// If no design between the bounds has full rank, the resulting design is outside the bounds. `None` if all candidates together
/// do not have full rank, or if the bounds do not allow `count` experiments.
pub fn relaxed(
    blocks: &[WeightedRows],
    bounds: &Bounds,
    count: usize,
    start: &[f64],
    (target, tolerance): (f64, f64),
    steps: usize,
) -> Option<Relaxed> {
    let p = blocks.first().map_or(0, WeightedRows::width);
    if !bounds.has_room_for(count) {
        return None;
    }
    let factor_of = |x: &[f64]| {
        let used = blocks.iter().zip(x.iter().copied()).filter(|(_, x)| *x > 0.0);
        InformationMatrix::sum(p, 0.0, used).factor()
    };
    let mut x = bounds.on_grid(bounds.nearest(start, count).into_iter(), count);
    if factor_of(&x).is_none() {
        // Mix in a small share of all allowed candidates. If full rank is still missing, no design between the bounds has it.
        let all: Vec<f64> = bounds.nearest(&vec![0.0; x.len()], count);
        x = x.iter().zip(&all).map(|(x, y)| (1.0 - MIXED_SHARE) * x + MIXED_SHARE * y).collect();
    }
    let Some(mut factor) = factor_of(&x) else { return without_rank(blocks, bounds, count, &x) };
    let mut best: Option<Relaxed> = None;
    for step in 0..=steps {
        let mut out = vec![0.0; p];
        let gain = blocks.iter().map(|b| factor.variance(b, &mut out)).collect();
        let tangent = Tangent { constant: factor.log_det - p as f64, gain };
        let (bound, _) = tangent.bound(bounds, count);
        let model = QuadraticModel::new(blocks, bounds.members(&x, &tangent.gain), &factor);
        let (change, expected) = model.step(&bounds.room(&x), MAX_ASCENT_MOVES);
        let is_done = bound <= target || bound - factor.log_det <= tolerance || step == steps || expected <= 0.0;
        if best.as_ref().is_none_or(|b| bound < b.bound) {
            best = Some(Relaxed { x: x.clone(), tangent, model, bound });
        }
        if is_done {
            break;
        }
        let at = |share: f64| bounds.on_grid(x.iter().zip(&change).map(|(x, d)| x + share * d), count);
        let tries = (0..MAX_STEP_HALVINGS).map(|k| at(0.5_f64.powi(k)));
        let better = tries.filter_map(|x| factor_of(&x).map(|f| (x, f))).find(|(_, f)| f.log_det > factor.log_det);
        let Some(better) = better else { break };
        (x, factor) = better;
    }
    best
}

/// The tangent at a design to which a small number of runs of every candidate is added, so that the design has full rank.
///
/// In a direction without information from the allowed designs, F has only the information of these added runs. Its logarithm is
/// very negative, so the bound is low.
fn without_rank(blocks: &[WeightedRows], bounds: &Bounds, count: usize, x: &[f64]) -> Option<Relaxed> {
    let x: Vec<f64> = x.iter().map(|x| x + REGULARIZING_RUNS).collect();
    let tangent = tangent(blocks, &x)?;
    let p = blocks.first().map_or(0, WeightedRows::width);
    let factor = InformationMatrix::sum(p, 0.0, blocks.iter().zip(x.iter().copied())).factor()?;
    let model = QuadraticModel::new(blocks, bounds.members(&x, &tangent.gain), &factor);
    let (bound, _) = tangent.bound(bounds, count);
    Some(Relaxed { x, tangent, model, bound })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::test_plans::random_blocks;

    #[test]
    fn no_plan_is_above_the_bound() {
        let blocks = random_blocks(6, 3, 4);
        let value = |x: &[usize]| {
            let weighted = blocks.iter().zip(x.iter().map(|x| *x as f64));
            InformationMatrix::sum(3, 0.0, weighted).factor().map_or(f64::NEG_INFINITY, |f| f.log_det)
        };
        for (low, high) in [([0; 6], [4; 6]), ([1, 0, 0, 0, 0, 1], [1, 1, 0, 2, 1, 3])] {
            let bounds = Bounds { low: low.to_vec(), high: high.to_vec() };
            let found = relaxed(&blocks, &bounds, 4, &[4.0 / 6.0; 6], (f64::NEG_INFINITY, 1e-6), 2000).unwrap();
            assert!((found.x.iter().sum::<f64>() - 4.0).abs() < 1e-9, "{found:?}");
            let reached = found.tangent.constant + 3.0;
            assert!(found.bound >= reached - 1e-12 && found.bound < reached + 1e-5, "{found:?}");
            let mut best = f64::NEG_INFINITY;
            for code in 0..5_usize.pow(6) {
                let x: Vec<usize> = (0..6).map(|i| code / 5_usize.pow(i) % 5).collect();
                let is_within = (0..6).all(|i| x[i] >= low[i] && x[i] <= high[i]) && x.iter().sum::<usize>() == 4;
                best = if is_within { value(&x).max(best) } else { best };
            }
            assert!(best <= found.bound && best > found.bound - 2.0, "{best} {}", found.bound);
        }
        let none = Bounds { low: vec![0; 6], high: vec![0; 6] };
        assert!(relaxed(&blocks, &none, 4, &[1.0; 6], (0.0, 1e-6), 10).is_none());
    }
}
