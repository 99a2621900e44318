//! Finds the common delay d of all torques relative to the motion, s, without the nominal parameters of the description.
//!
//! ```text
//! tau_j(t) = Y_j(t - d) X + a_j ddq_j(t - d) + b_j dq_j(t - d) + c_j direction_j + e_j |T_j| direction_j + o_j
//! ```
//! The unknowns are d, the base parameters X, and for each joint a rotor inertia a_j, viscous friction b_j, Coulomb friction
//! c_j, load friction e_j and an offset o_j. T_j is the torque explained without e_j. Without a_j, a rotor that the
//! description lacks would look like a delay. e_j is fitted because load friction changes sign with the velocity, as the
//! effect of a delay does.
//!
//! Y_j(t - d) is about Y_j - d dY_j/dt, so d is found by Gauss-Newton. The torques are regressed on the shifted columns, and on
//! the time derivative of the torque that these columns explain. Joints are weighted by 1 / residual. Rows within about 1 / f_c
//! of a reversal (|dq| < |ddq| / f_c; f_c: cut-off) are left out, because the filtered velocity does not show when a joint
//! sticks.

use linear_model::regressor::Regressor;
use linear_model::states::States;
use numerics::least_squares::solve;
use numerics::triangle::TriangleBuilder;
use numerics::vector::dot;

use crate::estimate::log_check::change::{MIN_SAMPLES_PER_JOINT, used};
use crate::estimate::log_check::samples::Samples;

/// The common delay of all torques, with its significance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lag {
    /// The delay, s; positive: the torques are late.
    pub seconds: f64,
    /// Share of the squared residual that the delay explains, 0 to 1; mean over the joints.
    pub share: f64,
}

/// A delay is reported only if it explains more than this share of the squared residual. In logs of real robots, chance alone
/// explains up to 0.05.
const SMALLEST_DELAY_SHARE: f64 = 0.15;
/// Delays shorter than this time are not reported, s.
const SHORTEST_DELAY_S: f64 = 0.003;
/// The search ends without a result if the delay exceeds this time, s.
const LONGEST_DELAY_S: f64 = 0.12;

const MAX_GAUSS_NEWTON_STEPS: usize = 14;
/// Longest Gauss-Newton step, s. The linearisation is valid for short steps only.
const LONGEST_GAUSS_NEWTON_STEP_S: f64 = 0.01;
/// The search has converged if a step is shorter than this time, s.
const SETTLED_STEP_S: f64 = 1e-4;

/// Least number of moving joints for which a common delay is searched; 1 if the robot has one joint only.
const LEAST_MOVING_JOINTS: usize = 2;

/// Largest number of joints for which a delay is searched. With more joints there are too many columns for a fast check.
const MAX_JOINTS_FOR_DELAY: usize = 8;

/// Number of columns of each joint in addition to the base parameters: velocity, acceleration, direction, load friction,
/// offset.
const OWN_COLUMNS: usize = 5;

/// Largest number of rows of a joint in the fit.
const MAX_ROWS_PER_JOINT: usize = 200;

/// Finds the common delay of the torques of all joints. `None` if the delay is too short or too long, if it explains too
/// little, or if the robot has too many joints or too few moving joints.
pub(super) fn common_lag(regressor: &dyn Regressor, samples: &Samples, rows: &[usize]) -> Option<Lag> {
    let n = samples.kept.n;
    if n > MAX_JOINTS_FOR_DELAY {
        return None;
    }
    let mut joints: Vec<DelayRows> = (0..n).filter_map(|j| DelayRows::of(regressor, samples, rows, j)).collect();
    // If only one joint moves, friction and delay are correlated, and no other joint confirms the delay.
    if joints.len() < n.min(LEAST_MOVING_JOINTS) {
        return None;
    }
    // In the first fit, joints are weighted by 1 / |torque|; in later fits, by 1 / |residual|.
    let mut seconds = 0.0;
    let at_first = fit(&joints, n, seconds)?;
    joints.iter_mut().zip(&at_first.squares).for_each(|(joint, square)| joint.weight = 1.0 / square.sqrt());
    let at_first = fit(&joints, n, seconds)?;
    let mut found = at_first.clone();
    for _ in 0..MAX_GAUSS_NEWTON_STEPS {
        if found.step.abs() < SETTLED_STEP_S {
            break;
        }
        seconds += found.step.clamp(-LONGEST_GAUSS_NEWTON_STEP_S, LONGEST_GAUSS_NEWTON_STEP_S);
        if seconds.abs() > LONGEST_DELAY_S {
            return None;
        }
        found = fit(&joints, n, seconds)?;
    }
    let shares = found.squares.iter().zip(&at_first.squares).map(|(now, first)| 1.0 - now / first);
    let share = shares.sum::<f64>() / joints.len() as f64;
    (share > SMALLEST_DELAY_SHARE && seconds.abs() > SHORTEST_DELAY_S).then_some(Lag { seconds, share })
}

/// The rows of one joint, without the rows near reversals of the joint.
struct DelayRows {
    joint: usize,
    weight: f64,
    rows: Vec<DelayRow>,
}

struct DelayRow {
    /// Entries of the regressor row Y_j, then dq_j and ddq_j. `rates`: time derivatives of these entries.
    columns: Vec<f64>,
    rates: Vec<f64>,
    direction: f64,
    tau: f64,
}

/// The result of a fit with a fixed delay.
#[derive(Clone)]
struct DelayResidual {
    /// Sum of squared residuals of each joint that has rows, (N m)^2 or N^2.
    squares: Vec<f64>,
    /// The Gauss-Newton step to add to the delay, s.
    step: f64,
}

impl DelayRows {
    /// Collects the rows of joint j. `None` if the joint moves in too few samples or has no torque.
    fn of(regressor: &dyn Regressor, samples: &Samples, rows: &[usize], j: usize) -> Option<DelayRows> {
        let (kept, n, p) = (&samples.kept, samples.kept.n, regressor.parameters().len());
        let near = |r: usize| if kept.cutoff > 0.0 { kept.ddq[r * n + j].abs() / kept.cutoff } else { 0.0 };
        let moves = |r: &usize| kept.dq[r * n + j].abs() > near(*r);
        let chosen: Vec<usize> = used(kept, rows, j).into_iter().map(|i| rows[i]).filter(moves).collect();
        let columns = |states: &States, r: usize| -> Vec<f64> {
            let at = r * n..(r + 1) * n;
            let mut y = vec![0.0; n * p];
            regressor.fill(&states.q[at.clone()], &states.dq[at.clone()], &states.ddq[at], &mut y);
            [&y[j * p..(j + 1) * p], &[states.dq[r * n + j], states.ddq[r * n + j]]].concat()
        };
        let row = |&r: &usize| {
            let (before, after) = (columns(&samples.before, r), columns(&samples.after, r));
            DelayRow {
                columns: columns(kept, r),
                rates: after.iter().zip(before).map(|(after, before)| (after - before) / samples.span[r]).collect(),
                direction: kept.direction[r * n + j],
                tau: kept.tau[r * n + j],
            }
        };
        let found: Vec<DelayRow> =
            chosen.iter().step_by(chosen.len().div_ceil(MAX_ROWS_PER_JOINT).max(1)).map(row).collect();
        let size = found.iter().map(|row| row.tau * row.tau).sum::<f64>().sqrt();
        (found.len() >= MIN_SAMPLES_PER_JOINT && size > 0.0).then_some(DelayRows {
            joint: j,
            weight: 1.0 / size,
            rows: found,
        })
    }
}

/// Fits all joints with columns delayed by `seconds`. `None` if there are no rows, or if the residual of a joint is zero.
fn fit(joints: &[DelayRows], n: usize, seconds: f64) -> Option<DelayResidual> {
    let base = joints.first()?.rows.first()?.columns.len() - 2;
    // The unknowns are the base parameters, then the five own columns of each joint, then the step of the delay.
    let (width, own) = (base + OWN_COLUMNS * n + 1, |joint: usize| base + OWN_COLUMNS * joint);
    let shifted = |row: &DelayRow| -> Vec<f64> {
        row.columns.iter().zip(&row.rates).map(|(y, rate)| y - seconds * rate).collect()
    };
    let entries = |joint: usize, row: &DelayRow, load: f64, rate: f64| -> Vec<f64> {
        let (shifted, mut all) = (shifted(row), vec![0.0; width]);
        all[..base].copy_from_slice(&shifted[..base]);
        let columns = [shifted[base], shifted[base + 1], row.direction, load * row.direction, 1.0];
        all[own(joint)..own(joint + 1)].copy_from_slice(&columns);
        all[width - 1] = rate;
        all
    };
    let solved = |columns: &dyn Fn(usize, &DelayRow) -> Vec<f64>| {
        let mut accumulator = TriangleBuilder::new(width);
        for DelayRows { joint, weight, rows } in joints {
            for row in rows {
                let weighted: Vec<f64> = columns(*joint, row).iter().map(|x| weight * x).collect();
                accumulator.push(&weighted, weight * row.tau);
            }
        }
        solve(&accumulator.finish()).x
    };
    // Three fits: the first, without load friction, gives the load; the second gives the parameters x; the third gives the
    // step of the delay.
    let unloaded = solved(&|joint, row| entries(joint, row, 0.0, 0.0));
    let load = |joint: usize, row: &DelayRow| dot(&entries(joint, row, 0.0, 0.0), &unloaded).abs();
    let x = solved(&|joint, row| entries(joint, row, load(joint, row), 0.0));
    let rate = |joint: usize, row: &DelayRow| {
        let moved = dot(&row.rates[..base], &x[..base]) + dot(&row.rates[base..], &x[own(joint)..own(joint) + 2]);
        -moved
    };
    let step = solved(&|joint, row| entries(joint, row, load(joint, row), rate(joint, row)))[width - 1];
    let rest = |joint: usize, row: &DelayRow| (row.tau - dot(&entries(joint, row, load(joint, row), 0.0), &x)).powi(2);
    let squares: Vec<f64> = joints.iter().map(|j| j.rows.iter().map(|row| rest(j.joint, row)).sum()).collect();
    squares.iter().all(|square: &f64| *square > 0.0).then_some(DelayResidual { squares, step })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;
    use random::Random;

    /// Samples of a pendulum with friction and noise. The torques are delayed by `by` samples of 10 ms.
    fn late(by: usize) -> Samples {
        let (mut states, mut random) = (Pendulum::new().states(900), Random::new(3));
        let torque = |states: &States, r: usize| states.tau[r] + 0.4 * states.dq[r] + 0.2 * states.direction[r];
        let tau: Vec<f64> =
            (0..900_usize).map(|r| torque(&states, r.saturating_sub(by)) + 0.01 * random.normal()).collect();
        states.tau = tau;
        Samples::of([states].as_slice(), 1).unwrap()
    }

    #[test]
    fn late_torques_are_found_and_others_are_not() {
        let look = |by: usize| {
            let samples = late(by);
            common_lag(&Pendulum::new(), &samples, &samples.every(1))
        };
        assert_eq!(look(0), None);
        for by in [1, 2] {
            let seconds = 0.01 * by as f64;
            let found = look(by).unwrap_or_else(|| panic!("no delay of {seconds} s"));
            // The tolerance is a third of the delay: the time derivatives are differences over 20 ms, and friction changes sign
            // with the velocity.
            assert!((found.seconds / seconds - 1.0).abs() < 0.33 && found.share > 0.5, "{found:?}");
        }
    }
}
