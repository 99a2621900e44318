//! Standard deviations to believe where the model does not explain everything.
//!
//! x - X = sum_r h_r, h_r = A^-1 W_r' e_r, A = W'W, the rows weighted. White noise gives s^2 A^-1. What a model leaves
//! unexplained is not white, and most of it is no noise: it is the same wherever the robot is in the same state. Rows that
//! share one error are a cluster, whose sum of h counts as one draw,
//!   var x = f sum_g S_g^2,   S_g = (A - k A_g)^-1 W_g' e_g,   A_g = W_g' W_g      [Liang, Zeger 1986]
//! The fit has hidden the share A^-1 A_g of the error of cluster g. k undoes that: with k = 1, x - S_g is the fit without
//! the cluster and f = (G - 1) / G, the jackknife; (1 - A^-1 A_g / 2)^-1 is (1 - A^-1 A_g)^(-1/2) to the second order,
//! which for errors of equal strength leaves no bias with f = 1 [Bell, McCaffrey 2002].
//!
//! | clusters | hold | k, f |
//! |---|---|---|
//! | the parts of the record, a twentieth of it each | noise that stays the same for a while, and drift | 19/20, (G - 1)/G |
//! | rows of a joint whose speed is of one octave, below 1/16 to 1 of its largest | friction of another law, hysteresis where a joint turns, ripple, play: they are the same at every pass | 1/2, 1 |
//!
//! Drifts outlast the parts, so that the estimate on the wide side is taken there; a twentieth of a part stays, lest a
//! direction that one part alone shows have no value.
//!
//! Where white noise is all there is, both are estimates of one variance, and the larger of two is above it by what their few
//! draws scatter: their mean is not. Slow noise sets the parts above the bands, and what the model lacks the bands above the
//! parts, of nearly every parameter: there the larger is right. The median over the parameters of speed over parts tells which
//! (`ALIKE`, `APART`, `TELLING`). No sigma is below that of white noise. Measured: `tests/benches/coverage.rs`.
//!
//! An error that looks like a column of W cannot be seen here: a wrong gain, a wrong gravity, friction that grows with
//! the speed in another way over the whole range.

use std::sync::Arc;

use crate::algebra::least_squares::Solution;
use crate::estimators::clusters::{Cluster, ROUNDING, Whole};
use crate::estimators::huber::Reweighted;
use crate::estimators::speed_bands::SpeedBands;
use crate::model::linear_model::Model;
use crate::rows::observation::{Observation, weighted};

/// k of the parts of the record, and of the bands.
const PART: f64 = 0.95;
const BAND: f64 = 0.5;

/// log2 of the ratio of the variances by speed and by part, median of the parameters: up to the first their mean counts,
/// from the second on the larger, between them a part of both. White noise on 24 records of a UR5: 0.0 to 0.75; slow noise:
/// 1.1 and more; friction of another law, ripple and play: 0.5 and more, up to where both are nearly one.
const ALIKE: f64 = 0.5;
const APART: f64 = 1.0;

/// Fewer parameters do not tell: the ratio of one alone scatters by an octave and more.
const TELLING: usize = 20;

/// The deviations of the parameters by what they allow for; zero where the data determine nothing.
#[derive(Clone, Debug)]
pub struct ReplicateDeviation {
    /// White noise.
    pub white: Vec<f64>,
    /// The parts of the record as replicates.
    pub by_part: Vec<f64>,
    /// The bands of speed of each joint as replicates.
    pub by_speed: Vec<f64>,
    /// How many correlated samples are worth one. The share that the fit has hidden is left out here (k = 0): it says how
    /// few the parts are, not how alike their samples.
    pub correlated: f64,
}

impl ReplicateDeviation {
    /// The one to believe, one a parameter: the larger of both where they disagree, their mean where they do not, and at
    /// least that of white noise.
    pub fn sigma(&self) -> Vec<f64> {
        let ratio = median_ratio(&self.by_speed, &self.by_part).filter(|_| self.white.len() >= TELLING);
        // Where nothing says that they agree, they are taken to disagree.
        let octaves = ratio.map_or(f64::INFINITY, |ratio| ratio.log2().abs());
        let apart = ((octaves - ALIKE) / (APART - ALIKE)).clamp(0.0, 1.0);
        let variance = |part: f64, speed: f64| {
            let apart = if part > 0.0 && speed > 0.0 { apart } else { 1.0 };
            apart * part.max(speed) + (1.0 - apart) * 0.5 * (part + speed)
        };
        let both = self.by_part.iter().zip(&self.by_speed);
        let believed = both.map(|(part, speed)| variance(part * part, speed * speed).sqrt());
        believed.zip(&self.white).map(|(believed, white)| believed.max(*white)).collect()
    }
}

/// The median over the parameters of one variance over another, of deviations; none where no parameter has both.
fn median_ratio(above: &[f64], below: &[f64]) -> Option<f64> {
    let ratio = |(above, below): (&f64, &f64)| Some((above / below).powi(2)).filter(|r| r.is_finite() && *r > 0.0);
    let mut ratios: Vec<f64> = above.iter().zip(below).filter_map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied()
}

/// The bands of speed of a fit, without rows yet: its rows (reweighted where `reweighted` says how) and weights by joint.
pub fn speed_bands<'a>(
    model: &Model,
    observation: &'a Observation,
    weights: &'a [f64],
    reweighted: Option<&'a Reweighted>,
) -> SpeedBands<'a> {
    let weight = move |j: usize, e: f64| weights[j] * weights[j] * reweighted.map_or(1.0, |found| found.weight(j, e));
    SpeedBands::new(model, &observation.speed, Arc::new(weight))
}

/// From the rows of a fit (reweighted where `reweighted` says how), its solution, its weights by joint, and the
/// [`speed_bands`] of its rows and residuals.
pub fn replicate_deviation(
    model: &Model,
    observation: &Observation,
    solution: &Solution,
    weights: &[f64],
    reweighted: Option<&Reweighted>,
    bands: SpeedBands,
) -> ReplicateDeviation {
    let whole = Whole::of(&weighted(&observation.joints(|_| true), weights));
    let parts = observation.parts.iter().filter(|part| part.iter().any(|triangle| triangle.rows > 0));
    let parts: Vec<Cluster> = parts.map(|part| Cluster::of(&weighted(part, weights), &solution.x)).collect();
    // psi(u) s = slope w e: what a residual counts in the scores of a robust fit.
    let slope = reweighted.map_or(1.0, |found| found.slope);
    of_clusters(&whole, &parts, &bands.clusters(model), slope, white_deviation(solution))
}

/// From all rows, those of the parts, those of the bands, the factor of the scores, and the deviations of white noise.
pub(crate) fn of_clusters(
    whole: &Whole,
    parts: &[Cluster],
    bands: &[Cluster],
    slope: f64,
    white: Vec<f64>,
) -> ReplicateDeviation {
    let root = |variance: Vec<f64>| variance.into_iter().map(|v| slope * v.sqrt()).collect::<Vec<f64>>();
    let count = parts.len() as f64;
    let by_part = root(whole.variance(parts, PART, ROUNDING).into_iter().map(|v| v * (count - 1.0) / count).collect());
    let sums = root(whole.variance(parts, 0.0, ROUNDING).into_iter().map(|v| v * count / (count - 1.0)).collect());
    let by_speed = root(whole.variance(bands, BAND, ROUNDING));
    let correlated = median_ratio(&sums, &white).unwrap_or(1.0).max(1.0);
    ReplicateDeviation { white, by_part, by_speed, correlated }
}

/// s sqrt(A^-1_cc): what white noise alone would leave.
pub fn white_deviation(solution: &Solution) -> Vec<f64> {
    (0..solution.x.len()).map(|c| (solution.variance * solution.inverse[(c, c)]).sqrt()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::random::Random;
    use crate::estimators::huber::reweighted;
    use crate::estimators::loss::Loss;
    use crate::estimators::weighted::{Weights, fit};
    use crate::model::friction::terms::FrictionTerm;
    use crate::model::states::States;
    use crate::rows::residual_sums::residual_sums;
    use crate::test_arm::Pendulum;

    fn of(model: &Model, states: States) -> (Solution, ReplicateDeviation) {
        let observation = Observation::of(model, &states, 20);
        let (solution, weights) = fit(&observation.joints(|_| true), Weights::Joint);
        let records = [states];
        let bands = speed_bands(model, &observation, &weights, None);
        let bands = residual_sums(model, records.as_slice(), &solution.x, bands).unwrap();
        let found = replicate_deviation(model, &observation, &solution, &weights, None, bands);
        (solution, found)
    }

    /// White and claimed variance over the variance of the estimate, in noise that forgets by `rho` a sample.
    fn calibration(rho: f64) -> [f64; 3] {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &[], &[]);
        let mut random = Random::new(11);
        let (runs, c) = (150, 1);
        let (mut errors, mut claimed) = (0.0, [0.0; 3]);
        for _ in 0..runs {
            let (mut states, mut noise) = (arm.states(1200), 0.0);
            for r in 0..states.len() {
                noise = rho * noise + (1.0 - rho * rho).sqrt() * random.normal();
                states.tau[r] += 0.1 * noise;
            }
            let (solution, found) = of(&model, states);
            errors += (solution.x[c] - arm.truth[c]).powi(2);
            let all = [found.white[c], found.by_part[c], found.sigma()[c]];
            claimed.iter_mut().zip(all).for_each(|(sum, sigma)| *sum += sigma * sigma);
        }
        claimed.map(|sum| sum / errors)
    }

    #[test]
    fn slow_noise_is_not_taken_for_white() {
        let [white, by_part, _] = calibration(0.9);
        // Twelve seconds hold sixty independent samples; 150 runs tell a variance to 12 %, and twenty draws scatter.
        assert!(white < 0.2, "{white}");
        assert!((0.65..1.5).contains(&by_part), "{by_part}");
    }

    #[test]
    fn the_larger_counts_where_parts_and_speeds_disagree() {
        let sigma = |by_part: [f64; 3], by_speed: [f64; 3], times: usize| {
            let (white, by_part, by_speed) = (vec![0.5; 3 * times], by_part.repeat(times), by_speed.repeat(times));
            ReplicateDeviation { white, by_part, by_speed, correlated: 1.0 }.sigma()[..3].to_vec()
        };
        // The median is one: the mean of the variances, whatever one parameter has.
        assert_eq!(sigma([1.0, 1.0, 7.0], [1.0, 7.0, 1.0], 7), [1.0, 5.0, 5.0]);
        // Three parameters do not tell.
        assert_eq!(sigma([1.0, 1.0, 7.0], [1.0, 7.0, 1.0], 1), [1.0, 7.0, 7.0]);
        // The median is two octaves, either way.
        assert_eq!(sigma([1.0, 1.0, 1.0], [2.0, 3.0, 0.9], 7), [2.0, 3.0, 1.0]);
        assert_eq!(sigma([2.0, 3.0, 0.9], [1.0, 1.0, 1.0], 7), [2.0, 3.0, 1.0]);
        // Nothing by speed is no agreement, and white noise is the least.
        assert_eq!(sigma([1.0, 0.1, 3.0], [0.0; 3], 7), [1.0, 0.5, 3.0]);
    }

    /// The largest of three estimates of one figure: 1.3 times it, not more. Three parameters do not tell what they agree on.
    #[test]
    fn white_noise_stays_white() {
        let [white, by_part, sigma] = calibration(0.0);
        assert!((0.75..1.35).contains(&white) && (0.75..1.5).contains(&by_part), "{white} {by_part}");
        assert!((1.0..1.9).contains(&sigma), "{sigma}");
    }

    /// Friction that the model has not: the same at every pass, however long the record. Parts of it agree with one
    /// another, and the bands of speed do not.
    #[test]
    fn what_the_model_lacks_is_not_averaged_away() {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &FrictionTerm::STANDARD, &[]);
        let at = |len: usize| {
            let mut states = arm.states(len);
            for r in 0..len {
                let v = states.dq[r];
                states.tau[r] += 0.3 * v + (1.0 + 0.3 * (-(v / 0.3) * (v / 0.3)).exp()) * v.signum();
            }
            of(&model, states)
        };
        // FS, of which 1 is true.
        let c = 4;
        for len in [4000, 32_000] {
            let (solution, found) = at(len);
            let error = (solution.x[c] - 1.0).abs();
            assert!(error > 0.01 && error < 1.96 * found.sigma()[c], "{len}: {error} {}", found.sigma()[c]);
            assert!(found.white[c] < 0.1 * found.by_speed[c], "{found:?}");
            assert!(found.by_speed[c] < 2.0 * error, "{error} {found:?}");
        }
        assert!(at(32_000).1.by_part[c] < 0.5 * at(4000).1.by_part[c]);
    }

    /// Rows that count less count less in the scores too, and nothing is claimed of what no row depends on.
    #[test]
    fn weighted_rows_and_empty_columns() {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &[], &[]);
        let mut random = Random::new(3);
        let mut states = arm.states(2000);
        for r in 0..states.len() {
            states.tau[r] += if random.uniform() < 0.05 { 3.0 } else { 0.1 * random.normal() };
        }
        let (ls, plain) = of(&model, states.clone());
        let records = [states];
        let found = reweighted(&model, records.as_slice(), &ls, Loss::Huber).unwrap();
        let records = records.as_slice();
        let (solution, weights) = (&found.solution, &found.weights);
        let bands = speed_bands(&model, &found.observation, weights, Some(&found));
        let bands = residual_sums(&model, records, &solution.x, bands).unwrap();
        let robust = replicate_deviation(&model, &found.observation, solution, weights, Some(&found), bands);
        for c in 0..3 {
            assert!(robust.sigma()[c] < 0.5 * plain.sigma()[c], "{robust:?} {plain:?}");
        }
        let still = States { used: vec![false; records[0].used.len()], ..records[0].clone() };
        assert_eq!(of(&model, still).1.sigma(), [0.0; 3]);
    }
}
