//! The best design with fractions of experiments between bounds, and what it proves.
//!
//! Over x with low <= x <= high and sum x = N, maximise log det F(x), F(x) = sum x_i F_i, F_i = W_i'W_i. For any x of full
//! rank, with T = F(x)^-1 and g_i = tr(F_i T),
//!
//! log det F(y) <= log det F(x) - p + max over y of sum y_i g_i
//!
//! because a concave function lies below its tangent: the natural (Lagrangian) bound of [Ponte, Fampa, Lee 2023], with T as
//! its dual. The maximum is a sum over the greatest g, filled up to the bounds; the last one filled is the price nu of an
//! experiment. An x_i is worth g_i - nu, so one that stands at a bound and is far from the price cannot leave it in any
//! plan as good as one known.
//!
//! The ascent exchanges the best against the worst candidate, with an exact line search [Fedorov 1972]; the bound holds
//! wherever it stops.

use crate::algebra::information_matrix::{InformationMatrix, Rows};
use crate::experiments::certificate::line_search;

/// Least and greatest number of each candidate.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// One a candidate.
    pub low: Vec<usize>,
    /// One a candidate.
    pub high: Vec<usize>,
}

/// The tangent at a design: log det of any other plan is at most `constant` + sum x_i g_i.
#[derive(Clone, Debug, PartialEq)]
pub struct Tangent {
    /// log det F(x) - p.
    pub constant: f64,
    /// g, one a candidate.
    pub gain: Vec<f64>,
}

/// A relaxed design.
#[derive(Clone, Debug)]
pub struct Relaxed {
    /// Fractions of experiments, one a candidate.
    pub x: Vec<f64>,
    /// What it proves.
    pub tangent: Tangent,
    /// No design between the bounds has a greater log det.
    pub bound: f64,
}

impl Bounds {
    fn has_room_for(&self, count: usize) -> bool {
        self.low.iter().sum::<usize>() <= count && self.high.iter().sum::<usize>() >= count
    }

    /// A design within, as near as it may be to `wanted`.
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
    /// The greatest log det that it allows between the bounds, with the price of an experiment; minus infinity where the
    /// bounds have no room for `count`.
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

/// The tangent at a design; `None` where it has not full rank.
pub fn tangent(blocks: &[Rows], x: &[f64]) -> Option<Tangent> {
    let p = blocks.first().map_or(0, Rows::width);
    let used = blocks.iter().zip(x.iter().copied()).filter(|(_, x)| *x > 0.0);
    let factor = InformationMatrix::sum(p, 0.0, used).factor()?;
    let mut out = vec![0.0; p];
    let gain = blocks.iter().map(|b| factor.variance(b, &mut out)).collect();
    Some(Tangent { constant: factor.log_det - p as f64, gain })
}

/// Ascends from `start` until the bound is below `target`, or within `tolerance` of what is reached, or for so many
/// steps; `None` where no design between the bounds has full rank.
pub fn relaxed(
    blocks: &[Rows],
    bounds: &Bounds,
    count: usize,
    start: &[f64],
    (target, tolerance): (f64, f64),
    steps: usize,
) -> Option<Relaxed> {
    let p = blocks.first().map_or(0, Rows::width);
    if !bounds.has_room_for(count) {
        return None;
    }
    let mut x = bounds.nearest(start, count);
    if tangent(blocks, &x).is_none() {
        // A little of all that is allowed: without rank then, there is none between the bounds.
        let all: Vec<f64> = bounds.nearest(&vec![0.0; x.len()], count);
        x = x.iter().zip(&all).map(|(x, y)| 0.9 * x + 0.1 * y).collect();
    }
    let mut best: Option<Relaxed> = None;
    for step in 0..=steps {
        let used = blocks.iter().zip(x.iter().copied()).filter(|(_, x)| *x > 0.0);
        let Some(factor) = InformationMatrix::sum(p, 0.0, used).factor() else { break };
        let mut out = vec![0.0; p];
        let gain: Vec<f64> = blocks.iter().map(|b| factor.variance(b, &mut out)).collect();
        let tangent = Tangent { constant: factor.log_det - p as f64, gain };
        let (bound, _) = tangent.bound(bounds, count);
        let gap = bound - factor.log_det;
        let (can_grow, can_shrink) =
            (|i: usize| x[i] < bounds.high[i] as f64 - 1e-9, |i: usize| x[i] > bounds.low[i] as f64 + 1e-9);
        let gain = &tangent.gain;
        let grows = (0..x.len()).filter(|&i| can_grow(i)).reduce(|a, b| if gain[b] > gain[a] { b } else { a });
        let shrinks = (0..x.len()).filter(|&i| can_shrink(i)).reduce(|a, b| if gain[b] < gain[a] { b } else { a });
        if best.as_ref().is_none_or(|b| bound < b.bound) {
            best = Some(Relaxed { x: x.clone(), tangent: tangent.clone(), bound });
        }
        let (Some(grows), Some(shrinks)) = (grows, shrinks) else { break };
        if bound <= target || gap <= tolerance || step == steps || grows == shrinks {
            break;
        }
        let most = (bounds.high[grows] as f64 - x[grows]).min(x[shrinks] - bounds.low[shrinks] as f64);
        let by = line_search(&factor, &blocks[grows], &blocks[shrinks], most);
        if by <= 0.0 {
            break;
        }
        x[grows] += by;
        // What is meant to reach its bound does, whatever rounding leaves.
        x[shrinks] = if x[shrinks] - by - bounds.low[shrinks] as f64 <= 1e-12 {
            bounds.low[shrinks] as f64
        } else {
            x[shrinks] - by
        };
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::random::Random;

    /// No plan between the bounds is above the bound, and without bounds the relaxed design is the best there is.
    #[test]
    fn no_plan_is_above_the_bound() {
        let mut random = Random::new(4);
        let mut block = || {
            let mut rows = Rows::new(3);
            (0..2).for_each(|_| rows.push(&[random.normal(), random.normal(), random.normal()]));
            rows
        };
        let blocks: Vec<Rows> = (0..6).map(|_| block()).collect();
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
