//! Robust regression: rows that do not fit count less.
//!
//! w(u) = 1 for |u| <= k, k/|u| beyond; u = residual / s_j, s_j = 1.4826 median |residual| of joint
//! j, k = 1.345: 95 % efficiency for normal noise [Huber 1981; Holland, Welsch 1977]. Iteratively
//! reweighted least squares from the WLS solution.

use crate::identify::{Weights, fit};
use crate::least_squares::Solution;
use crate::observation::{Model, Observation, row_residuals};
use crate::signal::States;

const K: f64 = 1.345;
const ITERATIONS: usize = 30;
/// Relative change of the parameters, in their sigmas, at which the iteration ends.
const SETTLED: f64 = 1e-3;

/// The robust solution, its weights by joint, and its triangles.
pub struct Reweighted {
    pub solution: Solution,
    pub weights: Vec<f64>,
    pub observation: Observation,
    /// Share of the rows of each joint that count less than fully.
    pub outliers: Vec<f64>,
    pub iterations: usize,
}

/// Iterates from a solution; `parts` as in `Observation::of`.
pub fn reweighted(model: &Model, records: &[States], start: &Solution, parts: usize) -> Reweighted {
    let n = model.n();
    let mut x = start.x.clone();
    let mut out = None;
    for iteration in 1..=ITERATIONS {
        let residuals: Vec<Vec<f64>> = records.iter().map(|s| row_residuals(model, s, &x)).collect();
        let scales: Vec<f64> = (0..n).map(|j| scale(&residuals, n, j)).collect();
        let mut observation: Option<Observation> = None;
        for (states, residuals) in records.iter().zip(&residuals) {
            let weight = |r: usize, j: usize| huber(residuals[r * n + j] / scales[j]).sqrt();
            let part = Observation::of_rows(model, states, parts, &weight);
            match &mut observation {
                Some(all) => all.append(part),
                None => observation = Some(part),
            }
        }
        let Some(observation) = observation else { break };
        let outliers = (0..n).map(|j| {
            let rows = residuals.iter().flat_map(|e| e.iter().skip(j).step_by(n)).filter(|e| e.is_finite());
            let (all, far) = rows.fold((0, 0), |(a, f), e| (a + 1, f + usize::from((e / scales[j]).abs() > K)));
            f64::from(far as u32) / f64::from(all.max(1) as u32)
        });
        let outliers: Vec<f64> = outliers.collect();
        let joints = observation.joints(|_| true);
        let (solution, weights) = fit(&joints, Weights::Joint);
        let change = x.iter().zip(&solution.x).enumerate().map(|(c, (a, b))| {
            (a - b).abs() / (solution.variance * solution.inverse[(c, c)]).sqrt().max(f64::MIN_POSITIVE)
        });
        let settled = change.fold(0.0, f64::max) < SETTLED;
        x = solution.x.clone();
        out = Some(Reweighted { solution, weights, observation, outliers, iterations: iteration });
        if settled {
            break;
        }
    }
    out.unwrap_or_else(|| Reweighted {
        solution: start.clone(),
        weights: vec![1.0; n],
        observation: Observation { parts: Vec::new(), range: Vec::new(), speed: Vec::new() },
        outliers: vec![0.0; n],
        iterations: 0,
    })
}

fn huber(u: f64) -> f64 {
    if u.abs() <= K || !u.is_finite() { 1.0 } else { K / u.abs() }
}

/// 1.4826 times the median of the absolute residuals of a joint: sigma for normal noise.
fn scale(residuals: &[Vec<f64>], n: usize, j: usize) -> f64 {
    let all = residuals.iter().flat_map(|e| e.iter().skip(j).step_by(n));
    let mut all: Vec<f64> = all.filter(|e| e.is_finite()).map(|e| e.abs()).collect();
    if all.is_empty() {
        return 1.0;
    }
    let middle = all.len() / 2;
    let (_, median, _) = all.select_nth_unstable_by(middle, f64::total_cmp);
    (1.4826 * *median).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::test_arm::Pendulum;

    /// 5 % of the torques off by thirty sigmas to one side: least squares is pulled away, the robust
    /// estimate stays within half a sigma.
    #[test]
    fn outliers_do_not_pull() {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &[], &[]);
        let mut random = Random::new(17);
        let runs = 30;
        let (mut bias_ls, mut bias) = ([0.0; 3], [0.0; 3]);
        for _ in 0..runs {
            let mut states = arm.states(800);
            for r in 0..states.len() {
                let outlier = if random.uniform() < 0.05 { 3.0 } else { 0.0 };
                states.tau[r] += 0.1 * random.normal() + outlier * states.q[r].signum();
            }
            let (ls, _) = fit(&Observation::of(&model, &states, 1).joints(|_| true), Weights::Joint);
            let robust = reweighted(&model, &[states], &ls, 1);
            for c in 0..3 {
                let sigma = 0.1 * robust.solution.inverse[(c, c)].sqrt() * robust.weights[0];
                bias_ls[c] += (ls.x[c] - arm.truth[c]) / sigma / f64::from(runs);
                bias[c] += (robust.solution.x[c] - arm.truth[c]) / sigma / f64::from(runs);
            }
        }
        let worst = |b: [f64; 3]| b.into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        assert!(worst(bias_ls) > 3.0, "{bias_ls:?}");
        assert!(worst(bias) < worst(bias_ls) / 5.0, "{bias:?} {bias_ls:?}");
    }

    #[test]
    fn clean_data_are_left_alone() {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &[], &[]);
        let mut random = Random::new(18);
        let mut states = arm.states(800);
        states.tau.iter_mut().for_each(|t| *t += 0.1 * random.normal());
        let (ls, _) = fit(&Observation::of(&model, &states, 1).joints(|_| true), Weights::Joint);
        let robust = reweighted(&model, &[states], &ls, 1);
        for c in 0..3 {
            let sigma = (ls.variance * ls.inverse[(c, c)]).sqrt();
            // At 95 % efficiency the two differ by 0.23 sigma, one standard deviation; four of them.
            assert!((robust.solution.x[c] - ls.x[c]).abs() < sigma);
        }
        // Outside of 1.345 sigmas: 17.9 % of a normal distribution, 800 rows.
        assert!((robust.outliers[0] - 0.179).abs() < 0.05, "{:?}", robust.outliers);
    }
}
