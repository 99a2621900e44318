//! Standard deviations that hold when residuals stay the same for a while.
//!
//! x - X = sum_r h_r, h_r = A^-1 W_r' e_r with A = W' W, the rows weighted. White noise would give
//! C = sigma^2 A^-1, but what a model leaves unexplained is not white. With h correlated over time,
//!   var x = sum_l (1 - |l|/L) sum_r h_r h_(r-l)        [Newey, West 1987]
//! of each parameter, and since the Bartlett weights are those of overlapping sums,
//!   var x = 1/L sum_k S_k^2,  S_k = sum of L successive h_r,
//! which needs L vectors at a time. Short spans miss the correlation that reaches beyond them. Therefore h is
//! whitened first, u_r = h_r - a h_(r-1) with a the parameter's own correlation from sample to
//! sample, and the variance of u is divided by (1 - a)^2 [Andrews, Monahan 1992]. L follows the rule for a
//! first-order process with the correlation of the residuals:
//!   L = 1.1447 (4 rho^2 / ((1 - rho)^2 (1 + rho)^2) n)^(1/3)   [Andrews 1991]
//! with rho the largest among the joints, and at most a tenth of the record. A span that is a share b of the
//! record leaves the variance itself uncertain: 95 % intervals reach 1.96 + 2.9694 b + 0.4160 b^2 - 0.5324 b^3
//! sigmas [Kiefer, Vogelsang 2005, Bartlett kernel], so sigma is given that much larger.

use std::convert::Infallible;
use std::ops::Range;

use logs::Error;

use crate::algebra::in_order::in_order;
use crate::algebra::least_squares::Solution;
use crate::algebra::vector::dot;
use crate::model::linear_model::Model;
use crate::model::states::States;
use crate::signals::records::Records;

/// Longest span, in samples: bounds the memory.
const LONGEST: usize = 4096;

/// A correlation nearer to one cannot be told from an endless drift.
const LONGEST_MEMORY: f64 = 0.97;

/// Autocorrelation-robust standard deviations of the parameters.
#[derive(Clone, Debug)]
pub struct Robust {
    /// One a parameter; zero where the data determine nothing.
    pub sigma: Vec<f64>,
    /// The correlation of the residual at successive samples, the largest of the joints.
    pub correlation: f64,
    /// Samples over which scores are summed, a record.
    pub span: Vec<usize>,
}

/// The squares of the sums of `span` successive scores.
pub(crate) struct OverlappingSums {
    ring: Vec<Vec<f64>>,
    sum: Vec<f64>,
    variance: Vec<f64>,
    at: usize,
}

impl OverlappingSums {
    pub(crate) fn new(p: usize, span: usize) -> OverlappingSums {
        OverlappingSums { ring: vec![vec![0.0; p]; span], sum: vec![0.0; p], variance: vec![0.0; p], at: 0 }
    }

    /// Takes the next h_r.
    pub(crate) fn add(&mut self, h: &[f64]) {
        let span = self.ring.len();
        let slot = &mut self.ring[self.at % span];
        for c in 0..self.sum.len() {
            self.sum[c] += h[c] - slot[c];
            self.variance[c] += self.sum[c] * self.sum[c] / span as f64;
        }
        slot.copy_from_slice(h);
        self.at += 1;
    }

    /// One variance a parameter; the last sums reach over the end.
    pub(crate) fn variance(mut self) -> Vec<f64> {
        let nothing = vec![0.0; self.sum.len()];
        for _ in 0..self.ring.len() {
            self.add(&nothing);
        }
        self.variance
    }
}

/// Deviations from the records of a fit, its solution and its weights by joint. `influence(j, e)` is what a residual e
/// of joint j counts as: e itself for least squares.
///
/// Fails when a record cannot be read.
pub fn robust<R: Records + ?Sized>(
    model: &Model,
    records: &R,
    solution: &Solution,
    weights: &[f64],
    influence: &(dyn Fn(usize, f64) -> f64 + Sync),
) -> Result<Robust, Error> {
    let p = model.p();
    let score = |j: usize, e: f64| weights[j] * weights[j] * influence(j, e);
    let mut variance = vec![0.0; p];
    let mut out = Robust { sigma: Vec::new(), correlation: 0.0, span: Vec::new() };
    records.each(&mut |states| {
        let scores = Scores { model, states, solution, score: &score };
        let mut lag_one = LagOne::new(model.n());
        let mut memory = Memory::new(p);
        let mut held = Vec::new();
        let is_held = states.len() * p <= HELD;
        scores.each(|r, residuals, h| {
            residuals.iter().enumerate().filter(|(_, e)| !e.is_nan()).for_each(|(j, e)| lag_one.add(r, j, *e));
            memory.add(h);
            if is_held {
                held.extend_from_slice(h);
            }
        });
        let (correlation, memory) = (lag_one.largest(), memory.shares());
        let span = span(correlation, states.len());
        out.correlation = out.correlation.max(correlation);
        out.span.push(span);
        let share = span as f64 / states.len().max(1) as f64;
        let reach = (1.96 + share * (2.9694 + share * (0.4160 - 0.5324 * share))) / 1.96;
        let (mut last, mut whitened) = (vec![0.0; p], vec![0.0; p]);
        let mut sums = OverlappingSums::new(p, span);
        let mut add = |h: &[f64]| {
            for c in 0..p {
                whitened[c] = h[c] - memory[c] * last[c];
            }
            sums.add(&whitened);
            last.copy_from_slice(h);
        };
        match is_held {
            true => held.chunks_exact(p.max(1)).for_each(add),
            false => scores.each(|_, _, h| add(h)),
        }
        for ((total, v), a) in variance.iter_mut().zip(sums.variance()).zip(&memory) {
            *total += v * (reach / (1.0 - a)).powi(2);
        }
    })?;
    out.sigma = variance.into_iter().map(f64::sqrt).collect();
    Ok(out)
}

/// Numbers of scores that are held instead of being computed again, 64 MiB.
const HELD: usize = 1 << 23;

/// The correlation from sample to sample of each parameter's h.
struct Memory {
    squares: Vec<f64>,
    products: Vec<f64>,
    last: Vec<f64>,
}

impl Memory {
    fn new(p: usize) -> Memory {
        Memory { squares: vec![0.0; p], products: vec![0.0; p], last: vec![0.0; p] }
    }

    fn add(&mut self, h: &[f64]) {
        for c in 0..h.len() {
            self.squares[c] += h[c] * h[c];
            self.products[c] += h[c] * self.last[c];
        }
        self.last.copy_from_slice(h);
    }

    fn shares(&self) -> Vec<f64> {
        let of = |(s, p): (&f64, &f64)| if *s > 0.0 { (p / s).clamp(0.0, LONGEST_MEMORY) } else { 0.0 };
        self.squares.iter().zip(&self.products).map(of).collect()
    }
}

/// h_r = A^-1 W_r' e_r of the samples of a record.
struct Scores<'a> {
    model: &'a Model<'a>,
    states: &'a States,
    solution: &'a Solution,
    /// From a joint and its residual to its weighted influence.
    score: &'a (dyn Fn(usize, f64) -> f64 + Sync),
}

/// Samples whose scores one thread computes at once.
const PIECE: usize = 1024;

/// Pieces whose scores wait for one another.
const WAITING: usize = 16;

impl Scores<'_> {
    /// Sample, residuals by joint (NaN where the row does not count) and h of each sample in turn.
    fn each(&self, mut take: impl FnMut(usize, &[f64], &[f64])) {
        let (n, p, len) = (self.model.n(), self.model.p(), self.states.len());
        let pieces: Vec<Range<usize>> = (0..len).step_by(PIECE).map(|first| first..len.min(first + PIECE)).collect();
        for pieces in pieces.chunks(WAITING) {
            let done: Result<(), Infallible> = in_order(
                pieces,
                |_, piece| self.piece(piece.clone()),
                |i, (residuals, h)| {
                    for (k, r) in pieces[i].clone().enumerate() {
                        take(r, &residuals[k * n..][..n], &h[k * p..][..p]);
                    }
                    Ok(())
                },
            );
            match done {
                Ok(()) => {}
            }
        }
    }

    /// Residuals and h of the samples of a range.
    fn piece(&self, range: Range<usize>) -> (Vec<f64>, Vec<f64>) {
        let (n, p, first) = (self.model.n(), self.model.p(), range.start);
        let (mut residuals, mut all) = (vec![f64::NAN; range.len() * n], vec![0.0; range.len() * p]);
        let mut g = vec![0.0; p];
        self.model.rows(self.states, range, |r, w| {
            g.fill(0.0);
            for j in (0..n).filter(|&j| self.states.used[r * n + j]) {
                let row = &w[j * p..(j + 1) * p];
                let e = self.states.tau[r * n + j] - dot(row, &self.solution.x);
                residuals[(r - first) * n + j] = e;
                let score = (self.score)(j, e);
                g.iter_mut().zip(row.iter()).for_each(|(g, a)| *g += score * a);
            }
            let h = &mut all[(r - first) * p..][..p];
            for (column, g) in self.solution.inverse.as_slice().chunks_exact(p.max(1)).zip(&g) {
                h.iter_mut().zip(column).for_each(|(h, a)| *h += g * a);
            }
        });
        (residuals, all)
    }
}

/// The correlation of residuals from sample to sample, joint by joint.
struct LagOne {
    /// The last sample and its residual.
    last: Vec<Option<(usize, f64)>>,
    squares: Vec<f64>,
    products: Vec<f64>,
}

impl LagOne {
    fn new(n: usize) -> LagOne {
        LagOne { last: vec![None; n], squares: vec![0.0; n], products: vec![0.0; n] }
    }

    fn add(&mut self, r: usize, j: usize, e: f64) {
        if let Some((_, before)) = self.last[j].filter(|(sample, _)| sample + 1 == r) {
            self.squares[j] += 0.5 * (e * e + before * before);
            self.products[j] += e * before;
        }
        self.last[j] = Some((r, e));
    }

    fn largest(&self) -> f64 {
        let rho = self.squares.iter().zip(&self.products).filter(|(s, _)| **s > 0.0).map(|(s, p)| p / s);
        rho.fold(0.0, f64::max)
    }
}

/// The largest lag-one correlation of the joints' residuals.
pub fn correlation(model: &Model, states: &States, x: &[f64]) -> f64 {
    let mut lag_one = LagOne::new(model.n());
    model.residuals(states, x, |r, j, e| lag_one.add(r, j, e));
    lag_one.largest()
}

pub(crate) fn span(rho: f64, n: usize) -> usize {
    // With fewer samples a correlation of one could not be told from another.
    let rho = rho.min(1.0 - 1.0 / (n as f64 + 1.0));
    let alpha = 4.0 * rho * rho / ((1.0 - rho) * (1.0 + rho)).powi(2);
    let length = 1.1447 * (alpha * n as f64).cbrt();
    (length.ceil() as usize).clamp(1, (n / 10).clamp(1, LONGEST))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::random::Random;
    use crate::estimators::weighted::{Weights, fit};
    use crate::rows::observation::Observation;
    use crate::test_arm::Pendulum;

    /// The variance of the estimate over many runs, against the mean of what each run claims.
    fn calibration(rho: f64) -> (f64, f64) {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &[], &[]);
        let mut random = Random::new(11);
        let (runs, mut errors, mut white, mut claimed) = (150, 0.0, 0.0, 0.0);
        for _ in 0..runs {
            let mut states = arm.states(600);
            let mut noise = 0.0;
            for r in 0..states.len() {
                noise = rho * noise + (1.0 - rho * rho).sqrt() * random.normal();
                states.tau[r] += 0.1 * noise;
            }
            let observation = Observation::of(&model, &states, 1);
            let (solution, weights) = fit(&observation.joints(|_| true), Weights::Joint);
            let robust = robust(&model, [states].as_slice(), &solution, &weights, &|_, e| e).unwrap();
            let c = 1;
            errors += (solution.x[c] - arm.truth[c]).powi(2) / f64::from(runs);
            white += solution.variance * solution.inverse[(c, c)] / f64::from(runs);
            claimed += robust.sigma[c].powi(2) / f64::from(runs);
        }
        (white / errors, claimed / errors)
    }

    #[test]
    fn correlated_noise_is_not_taken_for_white() {
        let (white, robust) = calibration(0.95);
        // The white-noise variance is far too small; the robust one right up to the bias of Bartlett
        // weights (downward) and the spread of 150 runs (12 %).
        assert!(white < 0.2, "{white}");
        assert!((0.5..1.4).contains(&robust), "{robust}");
    }

    #[test]
    fn white_noise_stays_white() {
        let (white, robust) = calibration(0.0);
        assert!((0.7..1.4).contains(&white), "{white}");
        assert!((0.7..1.4).contains(&robust), "{robust}");
    }
}
