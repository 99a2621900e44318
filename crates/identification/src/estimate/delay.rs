//! Finds the delay of the torques relative to the positions, s: the delay with the smallest residual of the fit.
//!
//! Each trial delay shifts the torques by linear interpolation before they are filtered. Rows within 1 / f_c of a reversal of
//! their joint are left out (f_c: cut-off of the low-pass). The reason is that a joint sticks at a reversal and its friction
//! changes sign, but the filtered velocity does not show when. With these rows, friction twice as large as the torque of
//! inertia would shift the result by 3.6 ms at a cut-off of 16 Hz.
//!
//! However, the rows near reversals contain most information on the delay. At a cut-off of 3.7 Hz, 0.27 s on each side of a
//! reversal are left out. The other rows have nearly constant speed, and their residual is the same for every delay. So the delay
//! is rejected if it raises the residual of all rows; then the search is repeated with all rows.

use linear_model::regressor::Regressor;
use linear_model::states::States;
use logs::{Error, LogSource};

use crate::estimate::held_out::residuals;
use crate::estimate::options::Options;
use crate::estimators::weighted::fit;
use crate::rows::observation::Observation;
use crate::signals::records::{Records, SourceRecords};

/// The result of a search for the delay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delay {
    /// The delay, s; positive if the torques are late.
    pub seconds: f64,
    /// Relative residual |tau - W X| / |tau| with this delay, on the rows that were searched.
    pub residual: f64,
    /// Relative residual |tau - W X| / |tau| without a delay, on the rows that were searched.
    pub residual_without: f64,
    /// True if all rows were searched; false if rows near reversals of their joint were left out.
    pub of_all_rows: bool,
    /// Whether the delay is at the end of the search interval. Then the minimum of the residual is outside or does not exist.
    pub at_the_end: bool,
}

/// Longest delay of the coarse search, in both directions, s: a whole number of steps of [`COARSE_DELAY_STEP_S`].
const LONGEST_SEARCHED_DELAY_S: f64 = 0.248;
/// A delay that was found without the rows near reversals is rejected if it multiplies the residual of all rows by more than
/// this factor. Dry friction alone multiplies this residual by less.
const CONTRADICTED_RESIDUAL_RATIO: f64 = 1.05;
const COARSE_DELAY_STEP_S: f64 = 0.004;
/// The fine search ends when its interval is shorter than this length, s.
const FINE_DELAY_WIDTH_S: f64 = 1e-4;
/// The fine search continues one coarse step beyond `LONGEST_SEARCHED_DELAY_S`. A delay is at the end of the search if it
/// exceeds `LONGEST_SEARCHED_DELAY_S` by more than this share of that step.
const END_STEP_SHARE: f64 = 0.9;

/// Records in which the rows within 1 / f_c of a reversal of their joint are marked as not used (f_c: cut-off of the
/// low-pass).
struct AwayFromReversals<'a>(&'a SourceRecords<'a>);

impl Records for AwayFromReversals<'_> {
    fn each(&self, take: &mut dyn FnMut(&States)) -> Result<(), Error> {
        self.0.each(&mut |states| {
            let mut kept = states.clone();
            for joint in 0..states.n {
                leave_out_reversals(&mut kept, joint);
            }
            take(&kept);
        })
    }
}

/// Marks the rows of a joint as not used if they are within 1 / f_c of a reversal, that is, of a change of sign of the joint's
/// velocity (f_c: cut-off of the low-pass, Hz).
fn leave_out_reversals(states: &mut States, joint: usize) {
    let margin = if states.cutoff > 0.0 { 1.0 / states.cutoff } else { 0.0 };
    let (n, len) = (states.n, states.len());
    let speed = |r: usize| states.dq[r * n + joint];
    let turns = (1..len).filter(|&r| speed(r - 1) * speed(r) <= 0.0);
    let turns: Vec<f64> = turns.map(|r| 0.5 * (states.t[r - 1] + states.t[r])).collect();
    let mut first = 0;
    for r in 0..len {
        while first < turns.len() && turns[first] < states.t[r] - margin {
            first += 1;
        }
        let near = turns.get(first).is_some_and(|turn| *turn <= states.t[r] + margin);
        states.used[r * n + joint] &= !near;
    }
}

/// Finds the delay of the torques with the smallest residual of the fit, to 0.1 ms.
///
/// Fails if a log cannot be read or prepared, for the reasons of `identify`.
pub fn estimate_delay(regressor: &dyn Regressor, logs: &[LogSource], options: &Options) -> Result<Delay, Error> {
    let model = options.linear_model(regressor);
    let mut options = options.clone();
    let mut search = |delay: f64, away: bool| -> Result<(f64, usize), Error> {
        options.signal.delay = delay;
        let records = SourceRecords::new(regressor, logs, &options.preparation())?;
        let observation = match away {
            true => Observation::of_records(&model, &AwayFromReversals(&records), None)?,
            false => Observation::of_records(&model, &records, None)?,
        };
        if options.signal.order > 0 {
            // The cut-off follows from the motion, which the delay of the torques does not change. So the cut-off of the first
            // trial is used for all trial delays.
            options.signal.cutoff.get_or_insert(observation.cutoff);
        }
        let joints = observation.joints(|_| true);
        let (solution, _) = fit(&joints, options.weights);
        Ok((residuals(&model, &joints, &solution.x).total, joints.iter().map(|t| t.rows).sum()))
    };
    // If nearly every row is near a reversal, too few other rows remain for a fit. Then all rows are searched.
    let has_rows = search(0.0, true)?.1 > model.p();
    let away = lowest(&mut |delay| search(delay, has_rows).map(|found| found.0), !has_rows)?;
    let (with, without) = (search(away.seconds, false)?.0, search(0.0, false)?.0);
    if !has_rows || away.at_the_end || with <= CONTRADICTED_RESIDUAL_RATIO * without {
        return Ok(away);
    }
    lowest(&mut |delay| search(delay, false).map(|found| found.0), true)
}

/// Finds the delay with the smallest residual, by a coarse search and then a fine one. `residual`: function from a delay, s,
/// to the relative residual.
fn lowest(residual: &mut impl FnMut(f64) -> Result<f64, Error>, of_all_rows: bool) -> Result<Delay, Error> {
    let residual_without = residual(0.0)?;
    let mut best = downhill(residual, residual_without)?;
    let found = golden_section(residual, best.0 - COARSE_DELAY_STEP_S, best.0 + COARSE_DELAY_STEP_S)?;
    if found.1 < best.1 {
        best = found;
    }
    // The fine search extends one step beyond the longest delay of the coarse search.
    let at_the_end = best.0.abs() > LONGEST_SEARCHED_DELAY_S + END_STEP_SHARE * COARSE_DELAY_STEP_S;
    Ok(Delay { seconds: best.0, residual: best.1, residual_without, of_all_rows, at_the_end })
}

impl Delay {
    /// Names the rows that were searched, for a report.
    pub fn rows(&self) -> &'static str {
        if self.of_all_rows { "of all rows" } else { "away from reversals" }
    }
}

/// Coarse search: returns the best delay of a grid, s, and its residual. `without`: residual without a delay.
///
/// The search starts at zero and continues in each direction as long as the residual decreases, because the residual has one
/// minimum and most delays are short.
fn downhill(residual: &mut impl FnMut(f64) -> Result<f64, Error>, without: f64) -> Result<(f64, f64), Error> {
    let mut best = (0.0, without);
    for direction in [COARSE_DELAY_STEP_S, -COARSE_DELAY_STEP_S] {
        let mut steps = 1;
        while f64::from(steps) * COARSE_DELAY_STEP_S <= LONGEST_SEARCHED_DELAY_S {
            let delay = f64::from(steps) * direction;
            let r = residual(delay)?;
            if r < best.1 {
                best = (delay, r);
            } else if steps > 1 {
                break;
            }
            steps += 1;
        }
    }
    Ok(best)
}

/// Golden-section search: returns the delay between a and b, s, with the smallest residual, and this residual.
///
/// c and d are the inner points, a < c < d < b. Each step drops the part of the interval beyond the inner point with the
/// larger residual.
fn golden_section(
    residual: &mut impl FnMut(f64) -> Result<f64, Error>,
    mut a: f64,
    mut b: f64,
) -> Result<(f64, f64), Error> {
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut c, mut d) = (b - golden * (b - a), a + golden * (b - a));
    let (mut fc, mut fd) = (residual(c)?, residual(d)?);
    while b - a > FINE_DELAY_WIDTH_S {
        if fc < fd {
            (b, d, fd) = (d, c, fc);
            c = b - golden * (b - a);
            fc = residual(c)?;
        } else {
            (a, c, fc) = (c, d, fd);
            d = a + golden * (b - a);
            fd = residual(d)?;
        }
    }
    let middle = 0.5 * (a + b);
    Ok((middle, residual(middle)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::signal_options::Signal;
    use crate::test_arm::{Pendulum, log};
    use logs::{Effort, Log};
    use random::Random;

    /// Simulates a pendulum with dry friction under a PD controller of 1 kHz. The pendulum sticks at each reversal.
    ///
    /// The torque of a row acts from the time of the row until 1 ms later. So the mean time of this torque is 0.5 ms after the
    /// time of the row. `late`: number of rows by which the logged torques are delayed.
    fn sticking(late: i32) -> Log {
        let (zz, mx, my, viscous, coulomb) = (0.3, 0.8, -0.1, 0.3, 1.5);
        let reference =
            |t: f64| ((2.0 * t).sin() + 0.3 * (5.1 * t).cos(), 2.0 * (2.0 * t).cos() - 1.53 * (5.1 * t).sin());
        let ((mut q, mut v), mut random) = (reference(0.0), Random::new(11));
        let (h, parts, count) = (1e-3, 20, 20_000);
        let (mut t, mut position, mut torque) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..count {
            let (r, dr) = reference(f64::from(i) * h);
            let tau = 400.0 * (r - q) + 20.0 * (dr - v);
            t.push(f64::from(i) * h);
            position.push(q + 1e-5 * random.normal());
            torque.push(tau + 0.02 * random.normal());
            for _ in 0..parts {
                let free = tau - 9.81 * (mx * q.cos() - my * q.sin()) - viscous * v;
                let dry = if v == 0.0 { free.clamp(-coulomb, coulomb) } else { coulomb * v.signum() };
                let next = v + h / f64::from(parts) * (free - dry) / zz;
                // The pendulum stops when the velocity changes sign. The next step decides whether the pendulum sticks.
                v = if v * next < 0.0 { 0.0 } else { next };
                q += h / f64::from(parts) * v;
            }
        }
        let at = |i: i32| torque[(i - late).clamp(0, count - 1) as usize];
        let tau = (0..count).map(at).collect();
        log(t, vec![position], vec![tau], Effort::Torque)
    }

    #[test]
    fn the_delay_is_found_beside_dry_friction() {
        let arm = Pendulum::new();
        let of = |late: i32, cutoff: Option<f64>| {
            let options = Options { signal: Signal { cutoff, ..Signal::default() }, ..Options::default() };
            estimate_delay(&arm, &[LogSource::Held(sticking(late))], &options).unwrap()
        };
        for (late, cutoff) in
            [(1, None), (5, None), (11, None), (21, None), (-9, None), (100, None), (5, Some(10.0)), (5, Some(40.0))]
        {
            let (found, expected) = (of(late, cutoff), 1e-3 * f64::from(late) - 5e-4);
            assert!((found.seconds - expected).abs() < 3e-4, "{late} {cutoff:?}: {found:?}");
            assert!(found.residual <= found.residual_without && !found.at_the_end, "{found:?}");
        }
        assert!(of(270, None).at_the_end);
    }
}
