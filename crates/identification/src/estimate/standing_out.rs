//! Finds intervals in which the residual of a joint is an outlier: a contact, a push, or another external force.
//!
//! e: residual of a joint, N m (N); m: moving mean of e over `WINDOW_S`; s: robust standard deviation of m.
//! ```text
//! s = median |m| / 0.6745        m stands out where |m| > OUTLIER_SCALES s
//! ```
//! Friction that the model lacks causes outliers at every reversal. So the intervals of a joint are reported only if they are
//! few, and if they cover a small share of the log. At low speed, dry friction may have any value between -FB and FB. A part
//! of e that dry friction in this range explains is no evidence of a contact, so this part is removed:
//! ```text
//! e <- the value nearest to zero of e - w f, -FB - d FS <= f <= FB - d FS      (s: from e before this step)
//! FB = BREAKAWAY_RATIO FS; d: direction in the model, -1 to 1; w: slowness, 0 to 1 (online::band)
//! ```

use linear_model::linear_model::Model;
use linear_model::states::States;
use logs::Error;
use numerics::vector::dot;
use online::Band;

use crate::signals::records::Records;
use crate::signals::thinned::MOST_THINNED_SAMPLES;

/// An interval in which the residuals of joints are outliers (stand out).
#[derive(Clone, Debug, PartialEq)]
pub struct StandingOut {
    /// Numbers of the coordinates.
    pub joints: Vec<usize>,
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
    /// A sentence on the interval. `coordinates`: names of all joints; `log`: name of the log.
    pub fn statement(&self, coordinates: &[String], log: &str) -> String {
        let StandingOut { from, to, ratio, .. } = self;
        let names: Vec<&str> = self.joints.iter().map(|&joint| coordinates[joint].as_str()).collect();
        let names = names.join(", ");
        format!(
            "the residual of {names} stands out from {from:.1} to {to:.1} s of {log}, {ratio:.0} times its usual size: contact, or \
             another load"
        )
    }

    /// The interval whose rows a contact may change, s. At both ends, this interval is longer than the found interval by the
    /// window of the moving mean.
    pub fn reach(&self) -> [f64; 2] {
        [self.from - WINDOW_S, self.to + WINDOW_S]
    }
}

/// Length of the window of the moving mean, s.
const WINDOW_S: f64 = 0.2;
/// Least duration of a reported interval, s. This duration is longer than the window, because a reversal makes the moving mean
/// an outlier for the length of the window.
const LEAST_CONTACT_S: f64 = 1.5 * WINDOW_S;
/// Least number of samples in a window of the moving mean.
const LEAST_WINDOW_SAMPLES: usize = 5;
/// Least length of a record, in half windows of the moving mean. Shorter records are not searched.
const LEAST_RECORD_HALF_WINDOWS: usize = 20;
/// A moving mean is an outlier if it exceeds this many robust standard deviations. A normal variable exceeds this limit once in
/// 5e8 cases.
const OUTLIER_SCALES: f64 = 6.0;
/// Median absolute value of a standard normal variable.
const MEDIAN_OF_NORMAL: f64 = 0.6745;
/// Largest number of intervals of a joint in a record. If there are more, the model has an error, and no interval is
/// reported.
pub const MOST_INTERVALS: usize = 2;
/// Largest total duration of the intervals of a joint, as a share of the record. If the total duration is longer, no interval
/// is reported.
const LARGEST_LOG_SHARE: f64 = 0.3;

/// Finds the intervals in which the residuals of the parameters x are outliers, in the order of logs and time.
///
/// Fails when a record cannot be read.
pub fn standing_out<R: Records + ?Sized>(model: &Model, records: &R, x: &[f64]) -> Result<Vec<StandingOut>, Error> {
    let (n, p) = (model.n(), model.p());
    let thinned = records.thinned(MOST_THINNED_SAMPLES)?;
    let mut found = Vec::new();
    let dry = model.dry_friction(x);
    for (_, states) in &thinned.records {
        let bands: Vec<Band<f64>> = dry.iter().enumerate().map(|(j, dry)| band(states, j, *dry)).collect();
        let mut residuals = vec![Residual::default(); n];
        model.rows(states, 0..states.len(), |r, w| {
            for (j, residual) in residuals.iter_mut().enumerate() {
                let k = r * n + j;
                let error = states.tau[k] - dot(&w[j * p..(j + 1) * p], x);
                let dry = bands[j].dry_at(bands[j].slowness(states.dq[k]));
                let direction = states.direction[k].clamp(-1.0, 1.0);
                // low, high: the limits of w f in the file's head, with dry = w FS. So e - clamp(e, low, high) is the value
                // nearest to zero of e - w f.
                let [low, high] = [-BREAKAWAY_RATIO, BREAKAWAY_RATIO].map(|f| (f - direction) * dry);
                residual.whole.push(error);
                residual.beyond_friction.push(error - error.clamp(low, high));
            }
        });
        // Each joint is searched alone. A contact acts on several joints, so `merged` joins the intervals of the joints
        // afterwards.
        for (joint, residual) in residuals.iter().enumerate() {
            let times = times(states, residual);
            found.extend(times.into_iter().map(|(from, to, ratio)| StandingOut {
                joints: vec![joint],
                log: states.log,
                from,
                to,
                ratio,
            }));
        }
    }
    Ok(merged(found))
}

/// Joins intervals of one log that overlap or are less than a window apart, in the order of logs and time.
pub fn merged(mut found: Vec<StandingOut>) -> Vec<StandingOut> {
    found.sort_by(|a, b| a.log.cmp(&b.log).then(a.from.total_cmp(&b.from)));
    let mut merged: Vec<StandingOut> = Vec::new();
    for mut interval in found {
        match merged.last_mut().filter(|last| last.log == interval.log && interval.from <= last.to + WINDOW_S) {
            Some(last) => {
                (last.to, last.ratio) = (last.to.max(interval.to), last.ratio.max(interval.ratio));
                last.joints.append(&mut interval.joints);
                last.joints.sort_unstable();
                last.joints.dedup();
            }
            None => merged.push(interval),
        }
    }
    merged
}

/// Friction at breakaway divided by Coulomb friction, at most: the Stribeck effect [Armstrong-Helouvry, Dupont, Canudas de Wit 1994].
const BREAKAWAY_RATIO: f64 = 1.5;
/// A joint is slow if its speed is below this share of its rms speed.
const SLOW_SHARE_OF_SPEED: f64 = 0.1;

/// The band of dry friction of joint j. `dry`: dry friction FS of the joint, N m (N).
fn band(states: &States, j: usize, dry: f64) -> Band<f64> {
    let speeds = states.dq.iter().skip(j).step_by(states.n);
    let rms = (speeds.map(|v| v * v).sum::<f64>() / states.len().max(1) as f64).sqrt();
    Band { noise: 0.0, low_speed: 0.0, dry, speed: (SLOW_SHARE_OF_SPEED * rms).max(f64::MIN_POSITIVE) }
}

/// The residual of a joint, N m (N), and the part of the residual that dry friction at low speed does not explain.
#[derive(Clone, Debug, Default)]
struct Residual {
    whole: Vec<f64>,
    beyond_friction: Vec<f64>,
}

/// Intervals (start in s, end in s, ratio) of one record in which the residual of one joint is an outlier. ratio: largest
/// moving mean / robust standard deviation of the moving mean. Empty if there are too many intervals.
fn times(states: &States, residual: &Residual) -> Vec<(f64, f64, f64)> {
    let (Some(first), Some(last)) = (states.t.first(), states.t.last()) else { return Vec::new() };
    let half = (0.5 * WINDOW_S * (states.len() - 1) as f64 / (last - first)) as usize;
    if 2 * half + 1 < LEAST_WINDOW_SAMPLES || states.len() < LEAST_RECORD_HALF_WINDOWS * half {
        return Vec::new();
    }
    let means = |residual: &[f64]| -> Vec<f64> {
        residual.windows(2 * half + 1).map(|window| window.iter().sum::<f64>() / window.len() as f64).collect()
    };
    let mut sizes: Vec<f64> = means(&residual.whole).iter().map(|m| m.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let scale = sizes[sizes.len() / 2] / MEDIAN_OF_NORMAL;
    // Outliers that are at most one window apart belong to the same interval.
    let mut found: Vec<(f64, f64, f64)> = Vec::new();
    let mut before = None;
    let means = means(&residual.beyond_friction);
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
    fn one_push_is_one_interval() {
        let interval = |joint, log, from, to, ratio| StandingOut { joints: vec![joint], log, from, to, ratio };
        let found = merged(vec![
            interval(2, 0, 1.1, 2.0, 9.0),
            interval(0, 0, 1.0, 1.5, 30.0),
            interval(0, 0, 5.0, 6.0, 7.0),
            interval(1, 1, 5.5, 6.0, 8.0),
        ]);
        assert_eq!(found.len(), 3);
        let together = StandingOut { joints: vec![0, 2], log: 0, from: 1.0, to: 2.0, ratio: 30.0 };
        assert_eq!(found[0], together);
        let names = ["a", "b", "c"].map(String::from);
        let said = together.statement(&names, "x.csv");
        assert!(said.starts_with("the residual of a, c stands out from 1.0 to 2.0 s of x.csv, 30 times"), "{said}");
    }

    #[test]
    fn a_push_is_found_with_its_times() {
        let arm = Pendulum::new();
        let states = arm.states(1500);
        let (mut random, end) = (Random::new(8), states.t[1499]);
        let noise: Vec<f64> = (0..1500).map(|_| 0.01 * random.normal()).collect();
        let times = |residual: &[f64]| {
            times(&states, &Residual { whole: residual.to_vec(), beyond_friction: residual.to_vec() })
        };
        assert_eq!(times(&noise), []);
        let (from, to) = (0.4 * end, 0.4 * end + 0.5);
        let push = |t: f64| if t > from && t < to { 0.2 } else { 0.0 };
        let pushed: Vec<f64> = noise.iter().zip(&states.t).map(|(e, t)| e + push(*t)).collect();
        let [(found_from, found_to, ratio)] = times(&pushed)[..] else { panic!("{:?}", times(&pushed)) };
        // The moving mean makes the found interval longer than the push, by half a window at both ends.
        assert!((found_from - from).abs() < WINDOW_S && (found_to - to).abs() < WINDOW_S, "{found_from} {found_to}");
        assert!(ratio > OUTLIER_SCALES);
        let reversals: Vec<f64> =
            noise.iter().zip(&states.t).map(|(e, t)| e + if t.rem_euclid(2.0) < 0.3 { 0.2 } else { 0.0 }).collect();
        assert_eq!(times(&reversals), []);
    }
}
