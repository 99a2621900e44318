//! Torques that are logged late, or early, whatever the description: what is left of a joint's torque goes with the
//! rate of what its own row of the regressor explains.
//!
//! tau_j(t) = P_j(t - d), P_j = Y_j X_j + b dq_j + c direction_j + e, so that to first order
//! ```text
//! tau_j = P_j - d dP_j/dt
//! ```
//! X_j, b, c, e are fitted for each joint; then tau_j is regressed on dP_j/dt beside all these columns, the turns of the
//! friction and friction that grows with the load, which turns round with the joint as late torques do. Rows within
//! 1 / f_c of a reversal are left out (|dq| < |ddq| / f_c): the filtered velocity does not know when a joint sticks.

use crate::algebra::least_squares::solve;
use crate::algebra::triangle::Accumulator;
use crate::algebra::vector::dot;
use crate::estimate::passport::change::{FEWEST, column, used};
use crate::estimate::passport::regression::{Basis, Partial};
use crate::estimate::passport::samples::Samples;
use crate::model::regressor::Regressor;
use crate::model::states::States;

/// A delay of all torques.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lag {
    /// s; positive: the torques are late.
    pub seconds: f64,
    /// Share of what is left of the torques that it explains.
    pub share: f64,
}

/// The share that a delay must explain, and s it must be long. Measured robots have up to 0.05 by chance.
const LATE: f64 = 0.15;
const LEAST: f64 = 0.003;

/// Joints differ by less than this share of the delay.
const SPREAD: f64 = 0.5;

/// The delay on which the joints agree; `None` where there is none, or they do not.
pub fn common_lag(regressor: &dyn Regressor, samples: &Samples, rows: &[usize]) -> Option<Lag> {
    let n = samples.kept.n;
    let found: Vec<Lag> = (0..n).filter_map(|j| lag(regressor, samples, rows, j)).collect();
    let sum: f64 = found.iter().map(|f| f.share).sum();
    let seconds = found.iter().map(|f| f.seconds * f.share).sum::<f64>() / sum;
    let share = sum / found.len() as f64;
    let spread = found.iter().map(|f| f.share * (f.seconds - seconds).powi(2)).sum::<f64>() / sum;
    let is_clear = found.len() >= n.min(2) && share > LATE && seconds.abs() > LEAST;
    (is_clear && spread.sqrt() < SPREAD * seconds.abs()).then_some(Lag { seconds, share })
}

/// The delay of joint j; `None` where it moves in too few samples.
fn lag(regressor: &dyn Regressor, samples: &Samples, rows: &[usize], j: usize) -> Option<Lag> {
    let (kept, n, p) = (&samples.kept, samples.kept.n, regressor.parameters().len());
    let near = |r: usize| if kept.cutoff > 0.0 { kept.ddq[r * n + j].abs() / kept.cutoff } else { 0.0 };
    let moves = |r: &usize| kept.dq[r * n + j].abs() > near(*r);
    let rows: Vec<usize> = used(kept, rows, j).into_iter().map(|i| rows[i]).filter(moves).collect();
    if rows.len() < FEWEST.max(3 * p / 2) {
        return None;
    }
    let row = |states: &States, r: usize| -> Vec<f64> {
        let at = r * n..(r + 1) * n;
        let mut y = vec![0.0; n * p];
        regressor.fill(&states.q[at.clone()], &states.dq[at.clone()], &states.ddq[at], &mut y);
        let mut row = y[j * p..(j + 1) * p].to_vec();
        row.extend([states.dq[r * n + j], states.direction[r * n + j], 1.0]);
        row
    };
    let now: Vec<Vec<f64>> = rows.iter().map(|&r| row(kept, r)).collect();
    let tau = column(&kept.tau, n, j, &rows);
    let mut accumulator = Accumulator::new(p + 3);
    now.iter().zip(&tau).for_each(|(row, tau)| accumulator.push(row, *tau));
    let mut x = solve(&accumulator.finish()).x;
    let explained: Vec<f64> = now.iter().map(|row| dot(row, &x)).collect();
    // The direction jumps where it turns: that is a column of its own.
    x[p + 1] = 0.0;
    let rate = |&r: &usize| (dot(&row(&samples.after, r), &x) - dot(&row(&samples.before, r), &x)) / samples.span[r];
    let rates: Vec<f64> = rows.iter().map(rate).collect();

    let mut columns: Vec<Vec<f64>> = (0..p + 3).map(|c| now.iter().map(|row| row[c]).collect()).collect();
    let direction = |states: &States, r: usize| states.direction[r * n + j];
    let turn = |&r: &usize| (direction(&samples.after, r) - direction(&samples.before, r)) / samples.span[r];
    columns.push(rows.iter().map(turn).collect());
    columns.push(rows.iter().zip(&explained).map(|(&r, torque)| torque.abs() * direction(kept, r)).collect());
    let basis = Basis::of(columns);
    let partial = Partial::of(&basis.without(tau), &basis.without(rates));
    Some(Lag { seconds: -partial.slope(), share: partial.share() })
}
