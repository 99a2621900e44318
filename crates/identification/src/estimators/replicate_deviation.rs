//! Standard deviations to believe where the model does not explain everything.
//!
//! x - X = sum_r h_r, h_r = A^-1 W_r' e_r, A = W'W, the rows weighted. White noise gives s^2 A^-1. What a model leaves
//! unexplained is not white, and most of it is not noise: it is the same wherever the robot is in the same state. Rows
//! that share one error are a cluster, whose sum of h counts as one draw,
//!   var x = f sum_g S_g^2,   S_g = (A - k A_g)^-1 W_g' e_g,   A_g = W_g' W_g      [Liang, Zeger 1986]
//! The fit has absorbed the share A^-1 A_g of the error of cluster g, and k restores it. With k = 1, x - S_g is the fit
//! without the cluster and f = (G - 1) / G, which is the jackknife. With k = 1/2,
//! (1 - A^-1 A_g / 2)^-1 is (1 - A^-1 A_g)^(-1/2) but for terms of the second order, and for errors of equal strength
//! this leaves no bias with f = 1 [Bell, McCaffrey 2002].
//!
//! | clusters | hold | k, f |
//! |---|---|---|
//! | the parts of the record, a twentieth of it each | noise that stays the same for a while, and drift | 19/20, (G - 1)/G |
//! | rows of a joint whose speed is of one octave, below 1/16 to 1 of its largest | friction of another law, hysteresis where a joint turns, play: they are the same at every pass | 1/2, 1 |
//! | the logs, where there are several | what changes from log to log, or from motion to motion | 1/2, 1 |
//! | rows of a joint whose position is of one eighth of its range | ripple, friction that grows with the load, cross talk, a base that yields: they are the same at every pass of a position | 1/2, 1 |
//!
//! Drifts outlast the parts, so that k is near one there and the estimate is on the wide side. A twentieth of a part
//! stays, because otherwise a direction that one part alone shows would have no value.
//!
//! Where all noise is white, the rows of the table estimate one variance. The largest of them is then too large by
//! the scatter of their few draws, and their mean is not. Slow noise raises the variance by parts above that by bands,
//! for nearly every parameter, and what the model lacks raises the variance by bands above that by parts. There the
//! larger is right. The median over the parameters of the one variance over the other tells which case it is
//! (`ALIKE_OCTAVES`, `APART_OCTAVES`, `MIN_TELLING_PARAMETERS`): first for speed and position, then for what both give
//! and the parts. No sigma is below that of white noise.
//! `tests/benches/coverage.rs` measures the result. Logs are too few to say what they agree with: theirs is a lower bound, without
//! the quantile of Student's t, which for two logs would be 6 times that.
//!
//! An error that looks like a column of W cannot be seen here. Examples are a wrong gain, a wrong gravity, and friction
//! that grows with the speed in another way over the whole range.

use std::sync::Arc;

use linear_model::linear_model::Model;
use numerics::least_squares::Solution;
use numerics::student::reach;
use numerics::triangle::Triangle;

use crate::estimators::clusters::{Cluster, REMAINDER_ROUNDING_SHARE, Whole};
use crate::estimators::huber::Reweighted;
use crate::estimators::state_bands::StateBands;
use crate::rows::observation::{Observation, weighted};

/// k of the parts of the record.
const PART_LEVERAGE_EXPONENT: f64 = 0.95;
/// k of the bands of speed.
const BAND_LEVERAGE_EXPONENT: f64 = 0.5;

/// Limits for log2 of the ratio of the variance by speed to that by part, median of the parameters. Up to the first
/// their mean counts, from the second on the larger, and between them a part of both. Measured on 24 records of a UR5:
/// white noise 0.0 to 0.75; slow noise 1.1 and more; friction of another law, ripple and play 0.5 and more, up to where
/// both are nearly one.
const ALIKE_OCTAVES: f64 = 0.5;
/// The second of these limits.
const APART_OCTAVES: f64 = 1.0;

/// Probability of an error beyond the interval.
const INTERVAL_RISK: f64 = 0.05;

/// Fewer parameters do not tell the cases apart, because the ratio of a single one scatters by an octave and more.
const MIN_TELLING_PARAMETERS: usize = 20;

/// The standard deviations of the parameters, by the kind of error they allow for; zero where the data determine
/// nothing. Those of replicates are wider by the quantile of Student's t over that of a normal error.
#[derive(Clone, Debug)]
pub struct ReplicateDeviation {
    /// White noise.
    pub white: Vec<f64>,
    /// The parts of the record as replicates.
    pub by_part: Vec<f64>,
    /// The bands of speed of each joint as replicates.
    pub by_speed: Vec<f64>,
    /// The bands of position of each joint as replicates.
    pub by_position: Vec<f64>,
    /// By how much the error of each log moves the parameters; empty where there is one log.
    pub moved_by_logs: Vec<Vec<f64>>,
    /// How many correlated samples are worth one.
    ///
    /// It is computed with k = 0, because the share that the fit has absorbed says how few the parts are, and not how
    /// alike their samples are.
    pub correlated: f64,
}

impl ReplicateDeviation {
    /// The deviation to believe, one per parameter: the one within logs, and at least that by logs.
    pub fn sigma(&self) -> Vec<f64> {
        self.within_logs().into_iter().enumerate().map(|(c, sigma)| sigma.max(self.by_log(c))).collect()
    }

    /// The deviation to believe where what changes from log to log does not count.
    ///
    /// It is the largest of the three where they disagree, their mean where they do not, and at least that of white noise.
    pub fn within_logs(&self) -> Vec<f64> {
        let by_state = together(&self.by_position, &self.by_speed);
        let believed = together(&by_state, &self.by_part);
        believed.into_iter().zip(&self.white).map(|(believed, white)| believed.max(*white)).collect()
    }

    /// What the deviations to believe are at least, where there are several logs: those by logs.
    fn by_log(&self, c: usize) -> f64 {
        self.moved_by_logs.iter().map(|moved| moved[c] * moved[c]).sum::<f64>().sqrt()
    }
}

/// Two deviations of each parameter as one: the root of the larger variance where they disagree, of the mean where they do
/// not.
fn together(above: &[f64], below: &[f64]) -> Vec<f64> {
    let ratio = median_ratio(above, below).filter(|_| above.len() >= MIN_TELLING_PARAMETERS);
    // Where nothing says that they agree, they count as disagreeing.
    let octaves = ratio.map_or(f64::INFINITY, |ratio| ratio.log2().abs());
    let apart = ((octaves - ALIKE_OCTAVES) / (APART_OCTAVES - ALIKE_OCTAVES)).clamp(0.0, 1.0);
    let variance = |a: f64, b: f64| {
        let apart = if a > 0.0 && b > 0.0 { apart } else { 1.0 };
        apart * a.max(b) + (1.0 - apart) * 0.5 * (a + b)
    };
    above.iter().zip(below).map(|(a, b)| variance(a * a, b * b).sqrt()).collect()
}

/// The median over the parameters of the ratio of two variances, from their deviations; `None` where no parameter has
/// both.
fn median_ratio(above: &[f64], below: &[f64]) -> Option<f64> {
    let ratio = |(above, below): (&f64, &f64)| Some((above / below).powi(2)).filter(|r| r.is_finite() && *r > 0.0);
    let mut ratios: Vec<f64> = above.iter().zip(below).filter_map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied()
}

/// The bands of speed and position of a fit, without rows yet; `reweighted` says how its rows are reweighted, where they
/// are.
pub fn state_bands<'a>(
    model: &Model,
    observation: &'a Observation,
    weights: &'a [f64],
    reweighted: Option<&'a Reweighted>,
) -> StateBands<'a> {
    let weight =
        move |j: usize, e: f64| weights[j] * weights[j] * reweighted.map_or(1.0, |found| found.rows.weight(j, e));
    StateBands::new(model, observation, Arc::new(weight))
}

/// The deviations of a fit, from its rows, its solution, its weights by joint and its [`state_bands`].
///
/// The rows are reweighted where `reweighted` says how. `bands` hold the rows and residuals.
pub fn replicate_deviation(
    model: &Model,
    observation: &Observation,
    solution: &Solution,
    weights: &[f64],
    reweighted: Option<&Reweighted>,
    bands: StateBands,
) -> ReplicateDeviation {
    let whole = Whole::of(&weighted(&observation.joints(|_| true), weights));
    let parts = observation.parts.iter().filter(|part| part.iter().any(|triangle| triangle.rows > 0));
    let parts: Vec<Cluster> = parts.map(|part| Cluster::of(&weighted(part, weights), &solution.x)).collect();
    // psi(u) s = slope w e: what a residual counts in the scores of a robust fit.
    let slope = reweighted.map_or(1.0, |found| found.slope);
    let moved_by_logs = moved_by_logs(&whole, observation, solution, weights, slope);
    let found = of_clusters(&whole, &parts, bands.clusters(model), slope, white_deviation(solution));
    ReplicateDeviation { moved_by_logs, ..found }
}

/// By how much the error of each of several logs moves the parameters, times `slope`.
pub fn moved_by_logs(
    whole: &Whole,
    observation: &Observation,
    solution: &Solution,
    weights: &[f64],
    slope: f64,
) -> Vec<Vec<f64>> {
    let moved = |(_, joints): (usize, Vec<Triangle>)| {
        let log = Cluster::of(&weighted(&joints, weights), &solution.x);
        let moved = whole.moved(&log, BAND_LEVERAGE_EXPONENT, REMAINDER_ROUNDING_SHARE)?;
        Some(moved.into_iter().map(|s| slope * s).collect::<Vec<f64>>())
    };
    observation.logs().into_iter().filter_map(moved).collect()
}

/// From all rows, those of the parts, those of the bands of speed and of position, the factor of the scores, and the deviations of white noise.
pub(crate) fn of_clusters(
    whole: &Whole,
    parts: &[Cluster],
    [speed, position]: [Vec<Cluster>; 2],
    slope: f64,
    white: Vec<f64>,
) -> ReplicateDeviation {
    let count = parts.len() as f64;
    // 1.96 of a deviation of few draws are to be the 95 % interval: Student's t, for as many as the parts are.
    let wider = reach(INTERVAL_RISK, (count - 1.0).max(1.0)) / reach(INTERVAL_RISK, f64::INFINITY);
    let scaled =
        |factor: f64, variance: Vec<f64>| variance.into_iter().map(|v| factor * v.sqrt()).collect::<Vec<f64>>();
    let root = |variance: Vec<f64>| scaled(slope * wider, variance);
    let by_part = root(
        whole
            .variance(parts, PART_LEVERAGE_EXPONENT, REMAINDER_ROUNDING_SHARE)
            .into_iter()
            .map(|v| v * (count - 1.0) / count)
            .collect(),
    );
    let sums = scaled(
        slope,
        whole.variance(parts, 0.0, REMAINDER_ROUNDING_SHARE).into_iter().map(|v| v * count / (count - 1.0)).collect(),
    );
    let (by_speed, by_position) = (by_band(whole, &speed, slope * wider), by_band(whole, &position, slope * wider));
    let correlated = median_ratio(&sums, &white).unwrap_or(1.0).max(1.0);
    ReplicateDeviation { white, by_part, by_speed, by_position, moved_by_logs: Vec::new(), correlated }
}

/// The deviation by bands of speed or of position, times `wider`.
pub fn by_band(whole: &Whole, bands: &[Cluster], wider: f64) -> Vec<f64> {
    let variance = whole.variance(bands, BAND_LEVERAGE_EXPONENT, REMAINDER_ROUNDING_SHARE);
    variance.into_iter().map(|v| wider * v.sqrt()).collect()
}

/// s sqrt(A^-1_cc): what white noise alone would leave.
pub fn white_deviation(solution: &Solution) -> Vec<f64> {
    (0..solution.x.len()).map(|c| (solution.variance * solution.inverse[(c, c)]).sqrt()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimators::huber::reweighted;
    use crate::estimators::loss::Loss;
    use crate::estimators::weighted::{Weights, fit};
    use crate::rows::residual_sums::residual_sums;
    use crate::test_arm::{Pendulum, pendulum};
    use linear_model::friction::terms::FrictionTerm;
    use linear_model::states::States;
    use random::Random;

    fn of(model: &Model, states: States) -> (Solution, ReplicateDeviation) {
        of_logs(model, &[states])
    }

    fn of_logs(model: &Model, logs: &[States]) -> (Solution, ReplicateDeviation) {
        let observation = Observation::of_records(model, logs, None).unwrap();
        let (solution, weights) = fit(&observation.joints(|_| true), Weights::Joint);
        let bands = state_bands(model, &observation, &weights, None);
        let bands = residual_sums(model, logs, &solution.x, bands).unwrap();
        let found = replicate_deviation(model, &observation, &solution, &weights, None, bands);
        (solution, found)
    }

    /// White, by-part and believed variance over that of the estimate, in noise that keeps `rho` of itself from sample
    /// to sample.
    fn calibration(rho: f64) -> [f64; 3] {
        let (arm, model) = pendulum();
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
        // Twelve seconds hold sixty independent samples. 150 runs give a variance to 12 %, and twenty draws scatter.
        assert!(white < 0.2, "{white}");
        assert!((0.65..1.5).contains(&by_part), "{by_part}");
    }

    #[test]
    fn the_larger_counts_where_parts_and_speeds_disagree() {
        let sigma = |by_part: [f64; 3], by_speed: [f64; 3], times: usize| {
            let (white, by_part, by_speed) = (vec![0.5; 3 * times], by_part.repeat(times), by_speed.repeat(times));
            let by_position = by_speed.clone();
            ReplicateDeviation { white, by_part, by_speed, by_position, moved_by_logs: Vec::new(), correlated: 1.0 }
                .sigma()[..3]
                .to_vec()
        };
        // The median ratio is one, so the mean of the variances counts, whatever a single parameter has.
        assert_eq!(sigma([1.0, 1.0, 7.0], [1.0, 7.0, 1.0], 7), [1.0, 5.0, 5.0]);
        // Three parameters are too few to tell.
        assert_eq!(sigma([1.0, 1.0, 7.0], [1.0, 7.0, 1.0], 1), [1.0, 7.0, 7.0]);
        // The median ratio is two octaves, in either direction.
        assert_eq!(sigma([1.0, 1.0, 1.0], [2.0, 3.0, 0.9], 7), [2.0, 3.0, 1.0]);
        assert_eq!(sigma([2.0, 3.0, 0.9], [1.0, 1.0, 1.0], 7), [2.0, 3.0, 1.0]);
        // Missing deviations by speed do not count as agreement, and white noise is the least.
        assert_eq!(sigma([1.0, 0.1, 3.0], [0.0; 3], 7), [1.0, 0.5, 3.0]);
    }

    /// The largest of three estimates of one figure is 1.3 times it, not more. Three parameters are too few to tell
    /// whether they agree.
    #[test]
    fn white_noise_stays_white() {
        let [white, by_part, sigma] = calibration(0.0);
        assert!((0.75..1.35).contains(&white) && (0.75..1.5).contains(&by_part), "{white} {by_part}");
        assert!((1.0..1.9).contains(&sigma), "{sigma}");
    }

    /// Friction that the model lacks is the same at every pass, however long the record. Parts of the record agree with
    /// one another, and the bands of speed do not.
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
        // FS, whose true value is 1.
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

    #[test]
    fn what_changes_from_log_to_log_is_held() {
        let (arm, model) = pendulum();
        let mut random = Random::new(7);
        let mut changed = |share: f64| {
            let mut logs = [0, 1].map(|log| States { log, ..arm.states(1200) });
            for (states, sign) in logs.iter_mut().zip([1.0, -1.0]) {
                states.tau.iter_mut().for_each(|tau| *tau = *tau * (1.0 + sign * share) + 0.01 * random.normal());
            }
            of_logs(&model, &logs).1
        };
        let (alike, apart) = (changed(0.0), changed(0.05));
        for (c, x) in arm.truth.iter().enumerate() {
            // Either log alone is off by 0.05 x, and what two such logs say is as unsure.
            assert!((0.6..1.6).contains(&(apart.by_log(c) / (0.05 * x.abs()))), "{c}: {apart:?}");
            assert!(apart.sigma()[c] >= apart.by_log(c), "{c}: {apart:?}");
            assert!(alike.by_log(c) < 3.0 * alike.within_logs()[c], "{c}: {alike:?}");
        }
        let (_, alone) = of(&model, arm.states(1200));
        assert!(alone.moved_by_logs.is_empty() && alone.sigma() == alone.within_logs());
    }

    #[test]
    fn ripple_by_position_is_held() {
        let (arm, model) = pendulum();
        let (mut held, mut by_speed_alone, mut of_white, mut all) = (0, 0, 0, 0);
        for phase in (0..24).map(|k| f64::from(k) * std::f64::consts::TAU / 24.0) {
            let mut states = arm.states(4000);
            for r in 0..states.len() {
                states.tau[r] += 0.5 * (7.0 * states.q[r] + phase).sin();
            }
            let (solution, found) = of(&model, states);
            let without = ReplicateDeviation { by_position: found.by_speed.clone(), ..found.clone() }.sigma();
            for (c, sigma) in found.sigma().into_iter().enumerate() {
                let error = (solution.x[c] - arm.truth[c]).abs();
                held += usize::from(error <= 1.96 * sigma);
                by_speed_alone += usize::from(error <= 1.96 * without[c]);
                of_white += usize::from(error <= 1.96 * found.white[c]);
                all += 1;
            }
        }
        let share = |count: usize| count as f64 / all as f64;
        // A sinusoid of one phase is no draw of many: its error stays at its largest for a third of all phases.
        assert!(share(held) > 0.8, "{}", share(held));
        assert!(share(by_speed_alone) < share(held) - 0.1, "{} {}", share(by_speed_alone), share(held));
        assert!(share(of_white) < 0.6, "{}", share(of_white));
    }

    #[test]
    fn weighted_rows_and_empty_columns() {
        let (arm, model) = pendulum();
        let mut random = Random::new(3);
        let mut states = arm.states(2000);
        let mut noise = || if random.uniform() < 0.05 { 3.0 } else { 0.1 * random.normal() };
        states.tau.iter_mut().for_each(|tau| *tau += noise());
        let (ls, plain) = of(&model, states.clone());
        let records = [states];
        let found = reweighted(&model, records.as_slice(), &ls, Loss::Huber).unwrap();
        let records = records.as_slice();
        let (solution, weights) = (&found.solution, &found.weights);
        let bands = state_bands(&model, &found.observation, weights, Some(&found));
        let bands = residual_sums(&model, records, &solution.x, bands).unwrap();
        let robust = replicate_deviation(&model, &found.observation, solution, weights, Some(&found), bands);
        for c in 0..3 {
            assert!(robust.sigma()[c] < 0.5 * plain.sigma()[c], "{robust:?} {plain:?}");
        }
        let still = States { used: vec![false; records[0].used.len()], ..records[0].clone() };
        assert_eq!(of(&model, still).1.sigma(), [0.0; 3]);
    }
}
