//! The hypotheses of a model, and the torque that each adds a unit of: the columns h of `hypotheses`.

use linear_model::linear_model::Model;
use linear_model::states::States;

use crate::estimate::ledger::hypothesis::{Hypothesis, Open};

/// Step of the derivative by a position, rad (m).
const POSITION_STEP: f64 = 1e-4;

/// The hypotheses of a model.
pub(super) fn all(model: &Model, open: Open) -> Vec<Hypothesis> {
    let n = model.n();
    let turning = (0..n).filter(|&k| !model.regressor.is_prismatic(k)).map(Hypothesis::Zero);
    let scales = (0..n).filter(|_| n > 1).map(Hypothesis::Scale);
    let springs = (0..n).map(Hypothesis::Spring);
    let mounts = open.tilts.iter().map(|(axis, _)| Hypothesis::Mount(*axis));
    let rotors = open.rotors.iter().copied().map(Hypothesis::Rotor);
    let late = (0..n).map(Some).chain([None]).map(Hypothesis::Late);
    let faults = turning.chain(scales).chain(springs).chain(mounts).chain(rotors).chain((0..n).map(Hypothesis::Drift));
    let talk = (0..n).flat_map(|k| (0..n).filter(move |&i| i != k).map(move |i| Hypothesis::CrossTalk(k, i)));
    faults.chain(late).chain((0..n).map(Hypothesis::LoadFriction)).chain(talk).collect()
}

/// The columns of the hypotheses, sample by sample, n each.
pub(super) fn columns(model: &Model, states: &States, x: &[f64], all: &[Hypothesis], open: Open) -> Vec<Vec<f64>> {
    let (n, base) = (model.n(), model.regressor.parameters().len());
    // Y(q) x at sample r, with another q than the sample's where a zero is moved.
    let torques = |q: &[f64], r: usize, y: &mut [f64]| -> Vec<f64> {
        let at = r * n..(r + 1) * n;
        model.regressor.fill(q, &states.dq[at.clone()], &states.ddq[at], y);
        y.chunks_exact(base).map(|row| row.iter().zip(x).map(|(y, x)| y * x).sum()).collect()
    };
    let mut columns = vec![Vec::with_capacity(states.len() * n); all.len()];
    let mut y = vec![0.0; n * base];
    let first = states.t.first().copied().unwrap_or(0.0);
    let seconds = states.t.last().map_or(0.0, |last| last - first).max(f64::MIN_POSITIVE);
    for r in 0..states.len() {
        let along = (states.t[r] - first) / seconds - 0.5;
        let mut q = states.q[r * n..(r + 1) * n].to_vec();
        let here = torques(&q, r, &mut y);
        for (column, hypothesis) in columns.iter_mut().zip(all) {
            let only = |k: usize, x: f64| (0..n).map(move |j| if j == k { x } else { 0.0 });
            match *hypothesis {
                Hypothesis::Zero(k) => {
                    // h_j = d(Y_j x)/dq_k, by a central difference.
                    let position = q[k];
                    let mut moved = |by: f64| {
                        q[k] = position + by;
                        torques(&q, r, &mut y)
                    };
                    let (behind, before) = (moved(POSITION_STEP), moved(-POSITION_STEP));
                    q[k] = position;
                    column.extend(behind.iter().zip(before).map(|(a, b)| (a - b) / (2.0 * POSITION_STEP)));
                }
                Hypothesis::Scale(k) => column.extend(only(k, here[k])),
                Hypothesis::Spring(k) => column.extend(only(k, q[k])),
                Hypothesis::Mount(of) => {
                    let tilts = open.tilts.iter().filter(|(axis, _)| *axis == of);
                    tilts.for_each(|(_, torques)| column.extend(torques(&q)));
                }
                Hypothesis::Rotor(k) => column.extend(only(k, states.ddq[r * n + k])),
                Hypothesis::Drift(k) => column.extend(only(k, along * states.tau[r * n + k])),
                Hypothesis::Late(late) => column
                    .extend((0..n).map(|j| if late.is_none_or(|k| k == j) { -torque_rate(states, r, j) } else { 0.0 })),
                Hypothesis::LoadFriction(k) => column.extend(only(k, states.direction[r * n + k] * here[k].abs())),
                Hypothesis::CrossTalk(k, i) => column.extend(only(k, states.tau[r * n + i])),
            }
        }
    }
    columns
}

/// d tau_j/dt at sample r, by the samples before and behind, N m/s (N/s). Of a log so long that few of its samples are taken
/// it says little, and tells no delay.
fn torque_rate(states: &States, r: usize, j: usize) -> f64 {
    let (before, behind) = (r.saturating_sub(1), (r + 1).min(states.len() - 1));
    let seconds = states.t[behind] - states.t[before];
    let change = states.tau[behind * states.n + j] - states.tau[before * states.n + j];
    if seconds > 0.0 { change / seconds } else { 0.0 }
}
