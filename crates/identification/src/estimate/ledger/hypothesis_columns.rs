//! The hypotheses of a model, and the torque that each adds a unit of: the columns h of `hypotheses`.

use linear_model::linear_model::Model;
use linear_model::states::States;

use crate::estimate::ledger::hypotheses::{Hypothesis, Open, Tilt};

/// Step of the derivative by a position, rad (m).
const POSITION_STEP: f64 = 1e-4;

/// The hypotheses of a model.
pub(super) fn all(model: &Model, open: Open) -> Vec<Hypothesis> {
    let n = model.n();
    let turning = (0..n).filter(|&k| !model.regressor.is_prismatic(k)).map(Hypothesis::Zero);
    let scales = (0..n).filter(|_| n > 1).map(Hypothesis::Scale);
    let springs = (0..n).map(Hypothesis::Spring);
    let mounts = (0..open.tilts.len()).map(Hypothesis::Mount);
    let rotors = open.rotors.iter().copied().map(Hypothesis::Rotor);
    let late = (0..n).map(Some).chain([None]).map(Hypothesis::Late);
    let faults = turning.chain(scales).chain(springs).chain(mounts).chain(rotors).chain((0..n).map(Hypothesis::Drift));
    let talk = (0..n).flat_map(|k| (0..n).filter(move |&i| i != k).map(move |i| Hypothesis::CrossTalk(k, i)));
    faults.chain(late).chain((0..n).map(Hypothesis::LoadFriction)).chain(talk).collect()
}

/// The columns of the hypotheses, sample by sample, n each.
pub(super) fn columns(model: &Model, states: &States, x: &[f64], all: &[Hypothesis], tilts: &[Tilt]) -> Vec<Vec<f64>> {
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
                Hypothesis::Mount(axis) => column.extend(tilts[axis](&q)),
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

/// d tau_j/dt at sample r, by the samples before and behind, N m/s (N/s).
fn torque_rate(states: &States, r: usize, j: usize) -> f64 {
    let (before, behind) = (r.saturating_sub(1), (r + 1).min(states.len() - 1));
    let seconds = states.t[behind] - states.t[before];
    let change = states.tau[behind * states.n + j] - states.tau[before * states.n + j];
    if seconds > 0.0 { change / seconds } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::ledger::hypotheses::{Tested, hypotheses};
    use crate::test_arm::Pendulum;
    use linear_model::friction::terms::FrictionTerm;
    use numerics::triangle::TriangleBuilder;

    /// The hypothesis as a fit tells it, of states whose torques `change` changes; and the relative error of the parameters
    /// of the fit without it and with it.
    fn told(of: &Hypothesis, change: impl Fn(&mut States)) -> (Tested, [f64; 2]) {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &FrictionTerm::STANDARD, &[]);
        let mut states = arm.states(1000);
        change(&mut states);
        let exact = [&arm.truth[..], &[0.0; 3]].concat();
        let mut rows = TriangleBuilder::new(exact.len());
        model.rows(&states, 0..states.len(), |r, w| rows.push(w, states.tau[r]));
        let x = rows.finish().solution();
        let found = hypotheses(&model, &[states][..], &x, &[1.0], Open::default()).unwrap();
        let found = found.into_iter().find(|tested| tested.of == *of).unwrap();
        let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
        let error = |with: f64| {
            let left = x.iter().zip(&found.effect).zip(&exact).map(|((x, effect), exact)| x + with * effect - exact);
            norm(&mut { left }) / norm(&mut exact.iter().copied())
        };
        let errors = [error(0.0), error(1.0)];
        (found, errors)
    }

    /// Torques that are logged one sample late: the time is told, with it the parameters are right, and no claim names it.
    #[test]
    fn late_torques_are_told() {
        let late = |states: &mut States| {
            states.tau.rotate_right(1);
            states.tau[0] = states.tau[1];
        };
        for joint in [None, Some(0)] {
            let (found, [without, with]) = told(&Hypothesis::Late(joint), late);
            // The slope by neighbours is wrong by (w h)^2/6 and the delay by its square: some per cent at 5.1 rad/s.
            assert!((found.value - 0.01).abs() < 5e-4, "{found:?}");
            assert!(found.is_told() && !found.is_found(), "{found:?}");
            // What is left goes with the square of the delay.
            assert!(with < 0.2 * without, "{without} {with}");
        }
        let (none, _) = told(&Hypothesis::Late(None), |_| {});
        assert!(none.value.abs() < 1e-4, "{none:?}");
    }

    /// Friction of a tenth of the load.
    #[test]
    fn friction_of_the_load_is_told() {
        let loaded = |states: &mut States| {
            let load: Vec<f64> = states.tau.iter().map(|tau| tau.abs()).collect();
            states.tau.iter_mut().zip(load).zip(&states.direction).for_each(|((tau, load), s)| *tau += 0.1 * s * load);
        };
        let (found, [without, with]) = told(&Hypothesis::LoadFriction(0), loaded);
        // The load is that of the fit without it.
        assert!((found.value - 0.1).abs() < 0.02 && found.is_told() && !found.is_found(), "{found:?}");
        assert!(with < 0.2 * without, "{without} {with}");
    }
}
