//! Cluster-robust standard deviations, for residuals that are not white noise.
//!
//! X: true parameters; W: weighted rows; A = W'W. The error of the estimate x is x - X = sum_r h_r. h_r = A^-1 W_r' e_r is the
//! contribution of row W_r with the error e_r. White noise with the standard deviation s gives the covariance s^2 A^-1. The
//! residual of a model is not white, and most of it is not noise: it repeats whenever the robot is in the same state. Rows that
//! have a common error are a cluster. The sum of h_r over a cluster counts as one independent random value,
//!   var x = f sum_g S_g^2,   S_g = (A - k A_g)^-1 W_g' e_g,   A_g = W_g' W_g      [Liang, Zeger 1986]
//! The fit has absorbed the share A^-1 A_g of the error of cluster g, and k corrects for this. With k = 1, x - S_g is the fit
//! without the cluster and f = (G - 1) / G for G clusters, which is the jackknife. With k = 1/2, (1 - A^-1 A_g / 2)^-1 equals
//! (1 - A^-1 A_g)^(-1/2) up to terms of second order. For errors of equal variance this is unbiased with f = 1 [Bell,
//! McCaffrey 2002].
//!
//! | clusters | errors that their rows have in common | k, f |
//! |---|---|---|
//! | blocks of the record, a twentieth of it each | slow noise and drift | 19/20, (G - 1)/G |
//! | rows of a joint with speed in one octave, from below 1/16 up to 1 of its largest speed | wrong friction law, hysteresis at reversals, play: equal at every pass | 1/2, 1 |
//! | the logs, if there are several | changes from log to log, or from motion to motion | 1/2, 1 |
//! | rows of a joint with position in one eighth of its range | ripple, load-dependent friction, cross talk, a compliant base: equal at every pass of a position | 1/2, 1 |
//!
//! Drifts last longer than a block, so k is near one for blocks, which overestimates the deviation. k is 19/20 and not 1: if a
//! block is left out as a whole, a direction of the parameters that only this block determines has no value.
//!
//! With white noise only, the variances from all rows of the table are estimates of one variance. Each estimate is inaccurate,
//! because the number of clusters is small. So the largest of them would be too large, and their mean is right. Slow noise
//! makes the variance by blocks larger than the variance by bands, for nearly every parameter. Errors of the model make the
//! variance by bands larger. In both cases the larger variance is right. The cases are distinguished by the ratio of two
//! variances, as median over the parameters (`EQUAL_OCTAVES`, `DIFFERENT_OCTAVES`, `LEAST_COMPARED_PARAMETERS`): first the
//! variances by speed and by position are compared and combined, then their result and the variance by blocks. No sigma is
//! below the sigma for white noise. `tests/benches/coverage.rs` measures the result. There are too few logs for such a
//! comparison. So the deviation by logs is only a lower bound of sigma. This bound is not inflated by the quantile of Student's
//! t, which for two logs would be a factor of 6.
//!
//! An error that is a linear combination of columns of W cannot be detected here. Examples are a wrong gain, a wrong gravity,
//! and friction that grows differently with the speed over the whole range.

use std::sync::Arc;

use linear_model::linear_model::Model;
use numerics::least_squares::Solution;
use numerics::student::two_sided_quantile;
use numerics::triangle::Triangle;

use crate::estimators::clusters::{Cluster, FullNormalMatrix, REMAINDER_ROUNDING_SHARE};
use crate::estimators::huber::Reweighted;
use crate::estimators::state_bands::StateBands;
use crate::rows::observation::{Observation, weighted};

/// k in S_g = (A - k A_g)^-1 W_g' e_g (see the module) if the clusters g are blocks of the record.
const BLOCK_LEVERAGE_SHARE: f64 = 0.95;
/// k in S_g = (A - k A_g)^-1 W_g' e_g (see the module) if the clusters g are bands of speed or position, or logs.
const BAND_LEVERAGE_SHARE: f64 = 0.5;

/// Two variances are equal if the median over the parameters of |log2(ratio of the variances)| is at most this value. Then
/// their mean is used. On 24 records of a UR5 this median was 0.0 to 0.75 for white noise, at least 1.1 for slow noise, and at
/// least 0.5 for another friction law, ripple and play.
const EQUAL_OCTAVES: f64 = 0.5;
/// Two variances are different if the median |log2(ratio)| is at least this value. Then the larger variance is used. Between
/// `EQUAL_OCTAVES` and this value, the result is interpolated.
const DIFFERENT_OCTAVES: f64 = 1.0;

/// Probability of an error outside the 95 % interval (1.96 sigma).
const INTERVAL_RISK: f64 = 0.05;

/// Least number of parameters for the comparison of two variances. The ratio of the variances of a single parameter varies by
/// more than an octave (a factor of two).
const LEAST_COMPARED_PARAMETERS: usize = 20;

/// The standard deviations of the parameters by kind of error; zero if the data determine nothing. Cluster-robust deviations are
/// inflated by the quantile of Student's t divided by the quantile of the normal distribution.
#[derive(Clone, Debug)]
pub struct ReplicateDeviation {
    /// Standard deviations for white noise.
    pub white: Vec<f64>,
    /// Standard deviations with the blocks of the record as clusters.
    pub by_part: Vec<f64>,
    /// Standard deviations with the speed bands of each joint as clusters.
    pub by_speed: Vec<f64>,
    /// Standard deviations with the position bands of each joint as clusters.
    pub by_position: Vec<f64>,
    /// For each log, S_g with the log as cluster g: the part of the error of each parameter that comes from this log. Empty if
    /// there is only one log.
    pub moved_by_logs: Vec<Vec<f64>>,
    /// Number of correlated samples that count as one independent sample.
    ///
    /// The number is computed with k = 0 in S_g = (A - k A_g)^-1 W_g' e_g. The correction by k depends on the number of blocks,
    /// not on the correlation of the samples.
    pub correlated: f64,
}

impl ReplicateDeviation {
    /// The final standard deviation of each parameter: the deviation within logs, but at least the deviation between logs.
    pub fn sigma(&self) -> Vec<f64> {
        self.within_logs().into_iter().enumerate().map(|(c, sigma)| sigma.max(self.by_log(c))).collect()
    }

    /// The standard deviation of each parameter without changes from log to log.
    ///
    /// If the deviations by blocks, speed and position differ, the largest deviation is taken. If these three deviations agree,
    /// their mean is taken. The result is at least the deviation for white noise.
    pub fn within_logs(&self) -> Vec<f64> {
        let by_state = together(&self.by_position, &self.by_speed);
        let believed = together(&by_state, &self.by_part);
        believed.into_iter().zip(&self.white).map(|(believed, white)| believed.max(*white)).collect()
    }

    /// The standard deviation of parameter c from differences between logs. This value is a lower bound, and 0 if there is only
    /// one log.
    fn by_log(&self, c: usize) -> f64 {
        self.moved_by_logs.iter().map(|moved| moved[c] * moved[c]).sum::<f64>().sqrt()
    }
}

/// Combines two standard deviations `above` and `below` of each parameter. If the variances differ, the result is the root of
/// the larger variance. If the variances agree, the result is the root of the mean variance.
fn together(above: &[f64], below: &[f64]) -> Vec<f64> {
    let ratio = median_ratio(above, below).filter(|_| above.len() >= LEAST_COMPARED_PARAMETERS);
    // With too few parameters, the variances count as different.
    let octaves = ratio.map_or(f64::INFINITY, |ratio| ratio.log2().abs());
    let apart = ((octaves - EQUAL_OCTAVES) / (DIFFERENT_OCTAVES - EQUAL_OCTAVES)).clamp(0.0, 1.0);
    let variance = |a: f64, b: f64| {
        let apart = if a > 0.0 && b > 0.0 { apart } else { 1.0 };
        apart * a.max(b) + (1.0 - apart) * 0.5 * (a + b)
    };
    above.iter().zip(below).map(|(a, b)| variance(a * a, b * b).sqrt()).collect()
}

/// The median over the parameters of the ratio of two variances, computed from standard deviations. `None` if no parameter has
/// both deviations.
fn median_ratio(above: &[f64], below: &[f64]) -> Option<f64> {
    let ratio = |(above, below): (&f64, &f64)| Some((above / below).powi(2)).filter(|r| r.is_finite() && *r > 0.0);
    let mut ratios: Vec<f64> = above.iter().zip(below).filter_map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied()
}

/// Makes empty bands of speed and position for a fit. `reweighted`: the robust fit, if its rows have robust weights.
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

/// The standard deviations of the parameters of a fit. `weights`: weight of each joint. `bands`: sums that [`state_bands`]
/// made; all rows must have been added to them with their residuals.
///
/// `reweighted`: the robust fit, if its rows have robust weights.
pub fn replicate_deviation(
    model: &Model,
    observation: &Observation,
    solution: &Solution,
    weights: &[f64],
    reweighted: Option<&Reweighted>,
    bands: StateBands,
) -> ReplicateDeviation {
    let whole = FullNormalMatrix::of(&weighted(&observation.joints(|_| true), weights));
    let parts = observation.parts.iter().filter(|part| part.iter().any(|triangle| triangle.rows > 0));
    let parts: Vec<Cluster> = parts.map(|part| Cluster::of(&weighted(part, weights), &solution.x)).collect();
    // In a robust fit, a residual e counts as slope w e (w: robust weight of the row), so W_g' e_g is multiplied by slope.
    let slope = reweighted.map_or(1.0, |found| found.slope);
    let moved_by_logs = moved_by_logs(&whole, observation, solution, weights, slope);
    let found = of_clusters(&whole, &parts, bands.clusters(model), slope, white_deviation(solution));
    ReplicateDeviation { moved_by_logs, ..found }
}

/// For each log, the part of the error of each parameter that comes from this log, times `slope`. Empty if there is only one log.
pub fn moved_by_logs(
    whole: &FullNormalMatrix,
    observation: &Observation,
    solution: &Solution,
    weights: &[f64],
    slope: f64,
) -> Vec<Vec<f64>> {
    let moved = |(_, joints): (usize, Vec<Triangle>)| {
        let log = Cluster::of(&weighted(&joints, weights), &solution.x);
        let moved = whole.moved(&log, BAND_LEVERAGE_SHARE, REMAINDER_ROUNDING_SHARE)?;
        Some(moved.into_iter().map(|s| slope * s).collect::<Vec<f64>>())
    };
    observation.logs().into_iter().filter_map(moved).collect()
}

/// The standard deviations by kind of error, from clusters. `whole`: all rows; `parts`: blocks; `speed`, `position`: bands;
/// `slope`: factor of the residuals of a robust fit (1 otherwise); `white`: standard deviations for white noise.
pub(crate) fn of_clusters(
    whole: &FullNormalMatrix,
    parts: &[Cluster],
    [speed, position]: [Vec<Cluster>; 2],
    slope: f64,
    white: Vec<f64>,
) -> ReplicateDeviation {
    let count = parts.len() as f64;
    // The deviations are inflated so that 1.96 sigma is the 95 % interval of Student's t. Degrees of freedom: number of blocks
    // minus one.
    let wider =
        two_sided_quantile(INTERVAL_RISK, (count - 1.0).max(1.0)) / two_sided_quantile(INTERVAL_RISK, f64::INFINITY);
    let scaled =
        |factor: f64, variance: Vec<f64>| variance.into_iter().map(|v| factor * v.sqrt()).collect::<Vec<f64>>();
    let root = |variance: Vec<f64>| scaled(slope * wider, variance);
    let by_part = root(
        whole
            .variance(parts, BLOCK_LEVERAGE_SHARE, REMAINDER_ROUNDING_SHARE)
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

/// The standard deviation of each parameter with bands of speed or of position as clusters, times the factor `wider`.
pub fn by_band(whole: &FullNormalMatrix, bands: &[Cluster], wider: f64) -> Vec<f64> {
    let variance = whole.variance(bands, BAND_LEVERAGE_SHARE, REMAINDER_ROUNDING_SHARE);
    variance.into_iter().map(|v| wider * v.sqrt()).collect()
}

/// The standard deviation of each parameter c for white noise, s sqrt(A^-1_cc). s: standard deviation of the residual, A: normal
/// matrix.
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

    /// Three estimated variances (for white noise, by blocks, and of `sigma`), each divided by the true variance of the
    /// estimate. The noise has the correlation `rho` from sample to sample.
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
        // Twelve seconds contain sixty independent samples. The variance from 150 runs has a relative standard deviation of 12 %,
        // and the variance from twenty blocks varies too.
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
        // The median ratio is 1, so the mean of the variances is used for every parameter.
        assert_eq!(sigma([1.0, 1.0, 7.0], [1.0, 7.0, 1.0], 7), [1.0, 5.0, 5.0]);
        // Three parameters are too few for a comparison.
        assert_eq!(sigma([1.0, 1.0, 7.0], [1.0, 7.0, 1.0], 1), [1.0, 7.0, 7.0]);
        // The median ratio is two octaves, in either direction.
        assert_eq!(sigma([1.0, 1.0, 1.0], [2.0, 3.0, 0.9], 7), [2.0, 3.0, 1.0]);
        assert_eq!(sigma([2.0, 3.0, 0.9], [1.0, 1.0, 1.0], 7), [2.0, 3.0, 1.0]);
        // If the deviations by speed are zero (missing), the deviations by blocks are used. Each result is at least the deviation
        // for white noise.
        assert_eq!(sigma([1.0, 0.1, 3.0], [0.0; 3], 7), [1.0, 0.5, 3.0]);
    }

    /// With three estimates of one variance, the largest is about 1.3 times that variance. The largest is used here, because
    /// three parameters are too few for a comparison.
    #[test]
    fn white_noise_stays_white() {
        let [white, by_part, sigma] = calibration(0.0);
        assert!((0.75..1.35).contains(&white) && (0.75..1.5).contains(&by_part), "{white} {by_part}");
        assert!((1.0..1.9).contains(&sigma), "{sigma}");
    }

    /// Friction that is not in the model causes an equal error at every pass, for any length of the record. The variance by
    /// blocks of the record is therefore too small, and the variance by bands of speed is right.
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
        // Column of FS, whose true value is 1.
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
            // The estimates from the two logs have errors of about 0.05 x. The standard deviation of the estimate from both
            // logs must have about this size.
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
        // The error is a sine of the phase, and all phases together are one independent sample. For a third of the phases, the
        // error is near its maximum.
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
