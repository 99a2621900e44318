//! The column of play (backlash): a gap of width b between the encoder of a joint, which is at its motor, and its link.
//!
//! The motor is ahead of the link by half of the gap, on the side that carries the torque of the bodies:
//! ```text
//! q = theta - (b/2) s      s = tanh((tau - f) / (c T)), or sign(tau - f) for c = 0
//! ```
//! q: position of the link; theta: logged position; s: side of the gap at which motor and link touch; tau: logged torque; f:
//! fitted friction and offset, which are at the motor; T: rms of tau - f; c: softness of the ends of the gap. When s changes
//! from -1 to 1, the logged position jumps by b. The low-pass of the positions smooths this jump, which gives a short velocity
//! and acceleration. So s must pass the same filter, and the column of the regressor for b is
//! ```text
//! h = -1/2 (dY x/dq_k s + dY x/d(dq_k) ds/dt + dY x/d(ddq_k) d2s/dt2)
//! ```
//! Y x: torque of the fitted model without play. The sign s comes from tau and not from Y x, because the acceleration of the
//! jump would change the sign of Y x.

use linear_model::linear_model::Model;
use linear_model::states::States;
use numerics::vector::dot;

use crate::signals::butterworth::Butterworth;
use crate::signals::differences::Differences;

/// Order of the low-pass of the signals, as in the default options.
const FILTER_ORDER: usize = 4;
/// A gap is tested if each of its two sides carries the torque in at least this share of the samples.
const LEAST_SHARE_OF_A_SIDE: f64 = 0.02;
/// Number of rounds of the iteration for the side s: the side of a gap gives the velocity of the link, and this velocity gives
/// the friction and so the side.
const ROUNDS: usize = 3;
/// Step of the width of a gap in the central difference of the torques, rad.
const STEP_RAD: f64 = 1e-4;

/// For each coordinate, the side of its gap that carries the torque, over the samples of one record.
#[derive(Default)]
pub(super) struct Sides(Vec<Option<Side>>);

/// Width and softness of the gap of one coordinate, as far as they are known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Backlash {
    /// The width b of the gap, rad; 0 if it is not known.
    pub width: f64,
    /// Softness c of the ends of the gap, as a share of the torque.
    pub softness: f64,
}

/// The filtered side s of a gap, from -1 to 1, with ds/dt, 1/s, and d2s/dt2, 1/s^2.
struct Side {
    side: Vec<f64>,
    rate: Vec<f64>,
    acceleration: Vec<f64>,
}

impl Sides {
    /// The sides s of the gaps of all coordinates. `x`: the fitted parameters; `gaps`: width and softness of each gap, as far
    /// as they are known. If the width of a gap is known, friction is computed with the velocity of the link instead of the
    /// motor. A coordinate has no side if its torque has nearly always the same sign. No coordinate has a side if there are too
    /// few samples for the filter.
    pub(super) fn of(model: &Model, states: &States, x: &[f64], gaps: &[Backlash]) -> Sides {
        let mut sides = Sides::at_velocities_of(model, states, x, gaps);
        if gaps.iter().all(|gap| gap.width == 0.0) {
            return sides;
        }
        let mut links = states.clone();
        for _ in 0..ROUNDS {
            for (k, (gap, side)) in gaps.iter().zip(&sides.0).enumerate() {
                let Some(side) = side else { continue };
                for r in 0..states.len() {
                    let (at, dq) = (r * states.n + k, states.dq[r * states.n + k]);
                    links.dq[at] = dq - 0.5 * gap.width * side.rate[r];
                    let turns = links.dq[at] * dq < 0.0;
                    links.direction[at] = if turns { links.dq[at].signum() } else { states.direction[at] };
                }
            }
            sides = Sides::at_velocities_of(model, &links, x, gaps);
        }
        sides
    }

    fn at_velocities_of(model: &Model, states: &States, x: &[f64], gaps: &[Backlash]) -> Sides {
        let (n, p, base) = (model.n(), model.p(), model.regressor.parameters().len());
        let mut carried = vec![Vec::with_capacity(states.len()); n];
        model.rows(states, 0..states.len(), |r, w| {
            for (j, carried) in carried.iter_mut().enumerate() {
                let friction = dot(&w[j * p + base..(j + 1) * p], &x[base..p]);
                carried.push(states.tau[r * n + j] - friction);
            }
        });
        let differences = Differences::new(&states.t);
        let one = |(k, carried): (usize, Vec<f64>)| {
            let positive = carried.iter().filter(|x| **x > 0.0).count() as f64 / carried.len().max(1) as f64;
            if !(LEAST_SHARE_OF_A_SIDE..=1.0 - LEAST_SHARE_OF_A_SIDE).contains(&positive) {
                return None;
            }
            let soft =
                gaps.get(k).map_or(0.0, |gap| gap.softness) * (dot(&carried, &carried) / carried.len() as f64).sqrt();
            let sides = match soft > 0.0 {
                true => carried.iter().map(|x| (x / soft).tanh()).collect(),
                false => mean_signs(&carried),
            };
            let side = filter(states)?.zero_phase(vec![sides]).remove(0);
            let rate = differences.of(&side);
            Some(Side { acceleration: differences.of(&rate), side, rate })
        };
        Sides(carried.into_iter().enumerate().map(one).collect())
    }

    /// The column of coordinate k at sample r, per width of the gap: n numbers. `torques`: the torques of the bodies for a
    /// position, velocity and acceleration of the robot.
    pub(super) fn column(
        &self,
        states: &States,
        r: usize,
        k: usize,
        mut torques: impl FnMut([&[f64]; 3]) -> Vec<f64>,
    ) -> Vec<f64> {
        let n = states.n;
        let Some(of) = &self.0[k] else { return vec![0.0; n] };
        let at = r * n..(r + 1) * n;
        let mut moved = |width: f64| {
            let [mut q, mut dq, mut ddq] = [&states.q, &states.dq, &states.ddq].map(|x| x[at.clone()].to_vec());
            q[k] -= 0.5 * width * of.side[r];
            dq[k] -= 0.5 * width * of.rate[r];
            ddq[k] -= 0.5 * width * of.acceleration[r];
            torques([&q, &dq, &ddq])
        };
        let (more, less) = (moved(STEP_RAD), moved(-STEP_RAD));
        more.iter().zip(less).map(|(more, less)| (more - less) / (2.0 * STEP_RAD)).collect()
    }
}

/// The low-pass that was applied to the positions of a record, at the rate of the samples of the record. `None` if the
/// positions were not filtered, or if there are too few samples.
fn filter(states: &States) -> Option<Butterworth> {
    let seconds = states.t.last().zip(states.t.first()).map_or(0.0, |(last, first)| last - first);
    let rate = states.len().saturating_sub(1) as f64 / seconds.max(f64::MIN_POSITIVE);
    if states.cutoff > 0.0 { Butterworth::low_pass(FILTER_ORDER, states.cutoff, rate) } else { None }
}

/// The sign of the logged torque of coordinate k, filtered like the torque, one number per sample.
pub(super) fn signs_of_torque(states: &States, k: usize) -> Vec<f64> {
    let signs = mean_signs(&states.tau.iter().skip(k).step_by(states.n).copied().collect::<Vec<f64>>());
    match filter(states) {
        Some(filter) => filter.zero_phase(vec![signs]).remove(0),
        None => signs,
    }
}

/// The mean sign of a signal around each sample, from the previous sample to the next. Between samples the signal is taken as
/// linear.
fn mean_signs(x: &[f64]) -> Vec<f64> {
    let between = |a: f64, b: f64| {
        if a * b < 0.0 { (a + b) / (a.abs() + b.abs()) } else { (a + b).signum() }
    };
    let last = x.len().saturating_sub(1);
    let mean = |i: usize| 0.5 * (between(x[i.saturating_sub(1)], x[i]) + between(x[i], x[(i + 1).min(last)]));
    (0..x.len()).map(mean).collect()
}
