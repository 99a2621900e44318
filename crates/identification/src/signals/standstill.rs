//! Detects when a joint is at standstill.
//!
//! Stiction is not in the model. A joint at rest can carry any torque up to its Coulomb friction, so its rows do not fit the
//! model and are left out. A slow reversal is not a standstill. With constant acceleration, the joint spends half of the time in
//! the quarter of its path that is nearest to the turning point. A joint that sticks at the turning point spends most of the time
//! there.

use std::ops::Range;

/// A joint is at standstill if its position stays within [`STANDSTILL_BAND`] for this time, s.
const STANDSTILL_SPAN_S: f64 = 0.2;

/// Width of the position band of a standstill, rad (m): the path that is covered in [`STANDSTILL_SPAN_S`] at 1e-3 rad/s (m/s).
/// This speed is called the speed of the band.
const STANDSTILL_BAND: f64 = 2e-4;

/// A reversal with constant acceleration goes from speed v to -v in the time T. The path of this reversal to the turning point
/// is v T times this factor.
const CONSTANT_ACCELERATION_DEPTH: f64 = 0.25;

/// Least path of a reversal to its turning point, divided by the path with constant acceleration. A shorter path is a standstill.
const LEAST_DEPTH_SHARE: f64 = 0.6;

/// A position is near the turning point if the distance between them is at most this share of the whole path.
const TURNING_PATH_SHARE: f64 = 0.25;

/// A reversal spends at most this share of its time near the turning point: half for constant acceleration, plus a margin for
/// other accelerations. A motion with a larger share is a standstill.
const REVERSAL_TIME_SHARE: f64 = 0.6;

/// For each sample of a position q, rad (m), whether the joint is at standstill. `period`: time between samples, s.
///
/// The joint is at standstill in a span in which its position stays within the band. Adjacent spans are merged. A merged span
/// that is a reversal is not a standstill.
pub fn standstill(q: &[f64], period: f64) -> Vec<bool> {
    let span = ((STANDSTILL_SPAN_S / period).ceil() as usize).max(2);
    let mut still = vec![false; q.len()];
    let mut first = 0;
    let mut slow = 0..0;
    while first + span <= q.len() {
        let length = stay(&q[first..], span);
        if length < span {
            first += 1;
            continue;
        }
        if first > slow.end {
            mark(q, slow, span, &mut still);
            slow = first..first;
        }
        first += length;
        slow.end = first;
    }
    mark(q, slow, span, &mut still);
    still
}

/// The number of samples from the start of q for which the position stays within the band; 0 if this number is less than
/// `span`.
fn stay(q: &[f64], span: usize) -> usize {
    if (q[span - 1] - q[0]).abs() > STANDSTILL_BAND {
        return 0;
    }
    let (mut low, mut high) = (q[0], q[0]);
    let mut stays = |&x: &f64| {
        (low, high) = (low.min(x), high.max(x));
        high - low <= STANDSTILL_BAND
    };
    q.iter().take_while(|x| stays(x)).count()
}

fn mark(q: &[f64], slow: Range<usize>, span: usize, still: &mut [bool]) {
    // The motion before and after a record is unknown. So a slow range at an end of a record counts as standstill.
    let is_inside = slow.start >= span && slow.end + span <= q.len();
    let is_turn = is_inside && [1.0, -1.0].iter().any(|sign| is_reversal(&q[slow.clone()], *sign, span));
    still[slow].fill(!is_turn);
}

/// Whether the samples q are a reversal without rest, at the smallest position (`sign` 1) or at the largest position (`sign` -1).
fn is_reversal(q: &[f64], sign: f64, span: usize) -> bool {
    let depth = |x: f64| sign * x;
    let (Some(&first), Some(&last)) = (q.first(), q.last()) else { return false };
    let bottom = q.iter().map(|x| depth(*x)).fold(f64::INFINITY, f64::min);
    // The path to the turning point, from the first or the last sample, whichever is nearer to the turning point.
    let path = depth(first).min(depth(last)) - bottom;
    let expected = CONSTANT_ACCELERATION_DEPTH * STANDSTILL_BAND * q.len() as f64 / span as f64;
    if path < LEAST_DEPTH_SHARE * expected {
        return false;
    }
    let within = |share: f64| q.iter().filter(|x| depth(**x) - bottom <= share * path).count() as f64;
    within(TURNING_PATH_SHARE) < REVERSAL_TIME_SHARE * within(1.0)
}

/// Finds the joints that are at standstill in all samples, and returns `used`. The velocities and accelerations (`rates`) of
/// these joints are set to zero, and their positions to the mean. Otherwise noise would determine parameters that depend only
/// on the motion of these joints. `n`: number of joints.
pub(crate) fn rest(used: Vec<bool>, n: usize, q: &mut [f64], rates: [&mut Vec<f64>; 2]) -> Vec<bool> {
    let rests: Vec<usize> = (0..n).filter(|j| !used.iter().skip(*j).step_by(n).any(|used| *used)).collect();
    let samples = used.len() / n.max(1);
    for &j in &rests {
        let mean = q.iter().skip(j).step_by(n).sum::<f64>() / samples.max(1) as f64;
        q.iter_mut().skip(j).step_by(n).for_each(|x| *x = mean);
    }
    for x in rates {
        rests.iter().for_each(|j| x.iter_mut().skip(*j).step_by(n).for_each(|x| *x = 0.0));
    }
    used
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rest_is_found_and_reversals_are_not() {
        let period = 0.01;
        // The joint rests for 1 s, swings for 2 s at up to 0.05 rad/s, and rests again.
        let position = |i: usize| {
            let t = (i as f64 * period - 1.0).clamp(0.0, 2.0);
            0.3 + 0.05 / std::f64::consts::PI * (1.0 - (std::f64::consts::PI * t).cos())
        };
        let q: Vec<f64> = (0..400).map(position).collect();
        let still = standstill(&q, period);
        let moving = |r: Range<usize>| still[r].iter().filter(|s| !**s).count();
        assert_eq!(moving(0..100), 0);
        // The reversal at 2 s is not a standstill. Start and end of the swing are slow and are not checked.
        assert_eq!(moving(120..280), 160);
        assert_eq!(moving(300..400), 0);
        // At ten times the speed of the band there is no standstill. In a record shorter than the span there is no standstill
        // either.
        let slow: Vec<f64> = (0..500).map(|i| 1e-2 * period * i as f64).collect();
        assert!(!standstill(&slow, period).contains(&true));
        assert!(!standstill(&[1.0; 10], period).contains(&true));
    }

    #[test]
    fn slow_reversals_are_kept_and_rests_at_them_are_not() {
        let (period, swing) = (0.01, 20.0);
        let position = |t: f64, rest: f64| {
            let phase = t.rem_euclid(0.5 * swing + rest).min(0.5 * swing) / (0.5 * swing);
            let is_back = (t / (0.5 * swing + rest)).floor().rem_euclid(2.0) == 1.0;
            let way = 0.5 - 0.5 * (std::f64::consts::PI * phase).cos();
            0.02 * if is_back { 1.0 - way } else { way }
        };
        let still_time = |rest: f64| {
            let q: Vec<f64> = (0..6000).map(|i| position(5.0 + i as f64 * period, rest)).collect();
            standstill(&q, period).iter().filter(|s| **s).count() as f64 * period
        };
        assert_eq!(still_time(0.0), 0.0);
        // There are five or six reversals in 60 s, each with a rest. For a second before and after each rest, the joint is slower
        // than 1e-3 rad/s, the speed of the band.
        for rest in [1.0, 2.0] {
            let found = still_time(rest);
            assert!((5.0 * rest..6.0 * (rest + 2.5)).contains(&found), "{rest}: {found}");
        }
        // A joint that continues in the same direction has stopped, not turned.
        let stop: Vec<f64> = (0..1000).map(|i| 0.05 * (period * i as f64 - 5.0).powi(3)).collect();
        assert!(standstill(&stop, period).contains(&true));
    }

    #[test]
    fn joints_that_rest_throughout_do_not_move() {
        let used = vec![true, false, false, true, false, true];
        let mut q = vec![0.0, 0.5, 0.0, 1.0, 0.75, 1.0];
        let (mut dq, mut ddq) = (vec![0.1, 0.2, 0.3, 0.4, 0.5, 0.6], vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(rest(used.clone(), 3, &mut q, [&mut dq, &mut ddq]), used);
        assert_eq!(q, [0.0, 0.625, 0.0, 1.0, 0.625, 1.0]);
        assert_eq!(dq, [0.1, 0.0, 0.3, 0.4, 0.0, 0.6]);
        assert_eq!(ddq, [1.0, 0.0, 3.0, 4.0, 0.0, 6.0]);
    }
}
