//! Finds intervals in which the residual of a joint is an outlier: a contact, a push, or another external force.
//!
//! e: residual of a joint, N m (N); m: moving mean of e over `WINDOW_S`; s: robust standard deviation of m.
//! ```text
//! s = median |m| / 0.6745        m stands out where |m| > OUTLIER_SCALES s
//! ```
//! Friction that the model lacks causes outliers at every reversal. So a joint is reported only if there are few intervals,
//! and if they cover a small share of the log.

use linear_model::linear_model::Model;
use linear_model::states::States;
use logs::Error;
use numerics::vector::dot;

use crate::signals::records::Records;
use crate::signals::thinned::MOST_THINNED_SAMPLES;

/// An interval in which the residual of a joint is an outlier (stands out).
#[derive(Clone, Debug, PartialEq)]
pub struct StandingOut {
    /// Number of the coordinate.
    pub joint: usize,
    /// Number of the log, from 0.
    pub log: usize,
    /// Start of the interval, s, by the clock of the log.
    pub from: f64,
    /// End of the interval, s, by the clock of the log.
    pub to: f64,
    /// Largest |m| in the interval divided by s. m: moving mean of the residual; s: robust standard deviation of m.
    pub ratio: f64,
}

impl StandingOut {
    /// A sentence on the interval. `joint`: name of the joint; `log`: name of the log, if there are several.
    pub fn statement(&self, joint: &str, log: Option<&str>) -> String {
        let StandingOut { from, to, ratio, .. } = self;
        let of_log = log.map_or(String::new(), |log| format!(" of {log}"));
        format!(
            "the residual of {joint} stands out from {from:.1} to {to:.1} s{of_log}, {ratio:.0} times its usual size: contact, or \
             another load"
        )
    }
}

/// Length of the window of the moving mean, s.
const WINDOW_S: f64 = 0.2;
/// Least duration of a reported interval, s. It is longer than the window, because a reversal makes the moving mean an
/// outlier for the length of the window.
const LEAST_CONTACT_S: f64 = 1.5 * WINDOW_S;
/// Least number of samples in a window of the moving mean.
const LEAST_WINDOW_SAMPLES: usize = 5;
/// Least length of a record, in half windows of the moving mean. Shorter records are not searched.
const LEAST_RECORD_HALF_WINDOWS: usize = 20;
/// A moving mean is an outlier beyond this many robust standard deviations. A normal variable exceeds it once in 5e8 draws.
const OUTLIER_SCALES: f64 = 6.0;
/// Median absolute value of a standard normal variable.
const MEDIAN_OF_NORMAL: f64 = 0.6745;
/// Largest number of intervals of a joint in a record. If there are more, the model has an error, and no interval is
/// reported.
const MOST_INTERVALS: usize = 2;
/// Largest total duration of the intervals of a joint, as a share of the record. If they are longer, no interval is reported.
const LARGEST_LOG_SHARE: f64 = 0.3;

/// Finds the intervals in which the residuals of the parameters x are outliers, the largest ratio to the robust standard
/// deviation first.
///
/// Fails when a record cannot be read.
pub fn standing_out<R: Records + ?Sized>(model: &Model, records: &R, x: &[f64]) -> Result<Vec<StandingOut>, Error> {
    let (n, p) = (model.n(), model.p());
    let thinned = records.thinned(MOST_THINNED_SAMPLES)?;
    let mut found = Vec::new();
    for (_, states) in &thinned.records {
        let mut residuals = vec![Vec::with_capacity(states.len()); n];
        model.rows(states, 0..states.len(), |r, w| {
            for (j, residual) in residuals.iter_mut().enumerate() {
                residual.push(states.tau[r * n + j] - dot(&w[j * p..(j + 1) * p], x));
            }
        });
        for (joint, residual) in residuals.iter().enumerate() {
            let times = times(states, residual);
            found.extend(times.into_iter().map(|(from, to, ratio)| StandingOut {
                joint,
                log: states.log,
                from,
                to,
                ratio,
            }));
        }
    }
    found.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    Ok(found)
}

/// Intervals (start in s, end in s, ratio) of one record in which the residual of one joint is an outlier. ratio: largest
/// moving mean / its robust standard deviation. Empty if there are too many intervals.
fn times(states: &States, residual: &[f64]) -> Vec<(f64, f64, f64)> {
    let (Some(first), Some(last)) = (states.t.first(), states.t.last()) else { return Vec::new() };
    let half = (0.5 * WINDOW_S * (states.len() - 1) as f64 / (last - first)) as usize;
    if 2 * half + 1 < LEAST_WINDOW_SAMPLES || states.len() < LEAST_RECORD_HALF_WINDOWS * half {
        return Vec::new();
    }
    let mean = |r: usize| {
        let window = &residual[r - half..=r + half];
        window.iter().sum::<f64>() / window.len() as f64
    };
    let means: Vec<f64> = (half..states.len() - half).map(mean).collect();
    let mut sizes: Vec<f64> = means.iter().map(|m| m.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let scale = sizes[sizes.len() / 2] / MEDIAN_OF_NORMAL;
    // Outliers that are at most one window apart belong to the same interval.
    let mut found: Vec<(f64, f64, f64)> = Vec::new();
    let mut before = None;
    for (k, m) in means.iter().enumerate().filter(|(_, m)| m.abs() > OUTLIER_SCALES * scale) {
        let (t, ratio) = (states.t[k + half], m.abs() / scale);
        match found.last_mut() {
            Some(last) if before.is_some_and(|before| k - before <= 2 * half) => {
                (last.1, last.2) = (t, last.2.max(ratio));
            }
            _ => found.push((t, t, ratio)),
        }
        before = Some(k);
    }
    found.retain(|(from, to, _)| to - from > LEAST_CONTACT_S);
    let long: f64 = found.iter().map(|(from, to, _)| to - from).sum();
    let are_events = found.len() <= MOST_INTERVALS && long < LARGEST_LOG_SHARE * (last - first);
    if are_events { found } else { Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;
    use random::Random;

    #[test]
    fn a_push_is_found_with_its_times() {
        let arm = Pendulum::new();
        let states = arm.states(1500);
        let (mut random, end) = (Random::new(8), states.t[1499]);
        let noise: Vec<f64> = (0..1500).map(|_| 0.01 * random.normal()).collect();
        assert_eq!(times(&states, &noise), []);
        let (from, to) = (0.4 * end, 0.4 * end + 0.5);
        let push = |t: f64| if t > from && t < to { 0.2 } else { 0.0 };
        let pushed: Vec<f64> = noise.iter().zip(&states.t).map(|(e, t)| e + push(*t)).collect();
        let [(found_from, found_to, ratio)] = times(&states, &pushed)[..] else {
            panic!("{:?}", times(&states, &pushed))
        };
        // The moving mean extends the push by half a window at both ends.
        assert!((found_from - from).abs() < WINDOW_S && (found_to - to).abs() < WINDOW_S, "{found_from} {found_to}");
        assert!(ratio > OUTLIER_SCALES);
        let reversals: Vec<f64> =
            noise.iter().zip(&states.t).map(|(e, t)| e + if t.rem_euclid(2.0) < 0.3 { 0.2 } else { 0.0 }).collect();
        assert_eq!(times(&states, &reversals), []);
    }
}
