//! Changes that undo what may have been done to a log, and how well a description then predicts the torques.
//!
//! T = Y(q', dq', ddq') X with the changed motion. Joint j's torque is compared with T_j beside the columns F_j =
//! [ddq_j, dq_j, direction_j, 1] that no description has (rotor, friction, offset). The slope may be between half and
//! twice the scale of all joints. What is then left of the torque is the misfit of the joint: 0 where the description
//! predicts it, 1 where it might as well be absent.

use generated::Eight;
use linear_model::regressor::Regressor;
use linear_model::states::States;

use crate::estimate::hypothesis::Hypothesis;
use crate::estimate::passport::regression::Partial;

/// One change of a log: a fault that is undone, and its size where it has one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// The fault.
    pub of: Hypothesis,
    /// By how much a zero makes the position larger, rad; the torque of a wrong scale over the right one, less one; else 0.
    pub size: f64,
}

impl Change {
    /// Of a fault without a size.
    pub(crate) fn of(of: Hypothesis) -> Change {
        Change { of, size: 0.0 }
    }

    /// The position of coordinate k is larger by this angle, rad.
    pub(super) fn turned(k: usize, angle: f64) -> Change {
        Change { of: Hypothesis::Zero(k), size: angle }
    }

    /// Positions of all coordinates with these changes done.
    pub(super) fn move_positions(changes: &[Change], q: &mut [f64], regressor: &dyn Regressor) {
        let is_angle: Vec<bool> = (0..q.len()).map(|k| !regressor.is_prismatic(k)).collect();
        let (mut dq, mut ddq) = (vec![0.0; q.len()], vec![0.0; q.len()]);
        changes.iter().for_each(|change| change.of.undo_motion(change.size, &is_angle, q, &mut dq, &mut ddq));
    }

    /// A log at the instants `rows` with these changes done.
    pub(super) fn all_done(changes: &[Change], log: &States, rows: &[usize], regressor: &dyn Regressor) -> States {
        let n = log.n;
        let is_angle: Vec<bool> = (0..n).map(|k| !regressor.is_prismatic(k)).collect();
        let mut done = States { n, ..States::default() };
        for &r in rows {
            let of = |x: &[f64]| x[r * n..(r + 1) * n].to_vec();
            let (mut q, mut dq, mut ddq) = (of(&log.q), of(&log.dq), of(&log.ddq));
            changes.iter().for_each(|change| change.of.undo_motion(change.size, &is_angle, &mut q, &mut dq, &mut ddq));
            done.t.push(log.t[r]);
            [(&mut done.q, q), (&mut done.dq, dq), (&mut done.ddq, ddq)].into_iter().for_each(|(all, x)| all.extend(x));
            // Directions are exchanged and signed as velocities are; they have no unit.
            let (mut direction, mut still) = (of(&log.direction), [vec![0.0; n], vec![0.0; n]]);
            let [q, ddq] = &mut still;
            changes.iter().for_each(|change| change.of.undo_motion(0.0, &vec![false; n], q, &mut direction, ddq));
            done.direction.extend(direction);
            for j in 0..n {
                let (of, factor) = torque_of(changes, j);
                done.tau.push(factor * log.tau[r * n + of]);
                done.used.push(log.used[r * n + motion_of(changes, j)]);
            }
        }
        done
    }
}

/// A description: its torque at any motion.
pub(super) struct Description<'a> {
    pub regressor: &'a dyn Regressor,
    /// Base parameters.
    pub parameters: &'a [f64],
}

impl Description<'_> {
    /// Its torques at the instants `rows` of the changed log, sample by sample, n each.
    pub(super) fn torques(&self, states: &States, rows: &[usize], changes: &[Change]) -> Vec<f64> {
        let mut torques = self.moving(states, rows, changes, 1.0);
        if changes.iter().any(|change| change.of == Hypothesis::GravityCompensated) {
            let at_rest = self.moving(states, rows, changes, 0.0);
            torques.iter_mut().zip(at_rest).for_each(|(tau, gravity)| *tau -= gravity);
        }
        torques
    }

    /// The same; `moves` is 1, or 0 for the torques that hold the robot at rest where it is.
    fn moving(&self, states: &States, rows: &[usize], changes: &[Change], moves: f64) -> Vec<f64> {
        let n = states.n;
        let is_angle: Vec<bool> = (0..n).map(|k| !self.regressor.is_prismatic(k)).collect();
        let non_zeros = self.regressor.non_zeros();
        let mut out = vec![0.0; rows.len() * n];
        let mut inputs = vec![0.0; INSTANTS_PER_PASS * 3 * n];
        let stride = non_zeros.len().max(1);
        let mut entries = vec![Eight::default(); INSTANTS_PER_PASS / 8 * stride];
        for (some, out) in rows.chunks(INSTANTS_PER_PASS).zip(out.chunks_mut((INSTANTS_PER_PASS * n).max(1))) {
            for (input, &r) in inputs.chunks_exact_mut(3 * n).zip(some) {
                let at = r * n..(r + 1) * n;
                let (q, rates) = input.split_at_mut(n);
                let (dq, ddq) = rates.split_at_mut(n);
                q.copy_from_slice(&states.q[at.clone()]);
                dq.copy_from_slice(&states.dq[at.clone()]);
                ddq.copy_from_slice(&states.ddq[at]);
                changes.iter().for_each(|change| change.of.undo_motion(change.size, &is_angle, q, dq, ddq));
                dq.iter_mut().chain(ddq).for_each(|x| *x *= moves);
            }
            // The lanes past the end hold earlier instants, and nobody reads what they give.
            let groups = some.len().div_ceil(8);
            let entries = &mut entries[..groups * stride];
            self.regressor.fill_blocks(&inputs[..groups * 8 * 3 * n], stride, entries);
            for (group, out) in entries.chunks_exact(stride).zip(out.chunks_mut(8 * n)) {
                let mut torques = vec![[0.0; 8]; n];
                for (entry, &(j, c)) in group.iter().zip(&non_zeros) {
                    let (sum, x) = (&mut torques[j], self.parameters[c]);
                    for lane in 0..8 {
                        sum[lane] += entry.0[lane] * x;
                    }
                }
                for (lane, out) in out.chunks_exact_mut(n).enumerate() {
                    out.iter_mut().zip(&torques).for_each(|(out, torque)| *out = torque[lane]);
                }
            }
        }
        out
    }
}

/// Instants whose regressors are made together: eight for each lane of the widest processor.
const INSTANTS_PER_PASS: usize = 64;

/// Joints with fewer samples than this say nothing.
pub(super) const MIN_SAMPLES_PER_JOINT: usize = 60;

/// Column k of an array with n columns, at the chosen samples.
pub(super) fn column(x: &[f64], n: usize, k: usize, rows: &[usize]) -> Vec<f64> {
    rows.iter().map(|&r| x[r * n + k]).collect()
}

/// The places among `rows` of the samples at which joint j counts.
pub(super) fn used(states: &States, rows: &[usize], j: usize) -> Vec<usize> {
    (0..rows.len()).filter(|&i| states.used[rows[i] * states.n + j]).collect()
}

/// The misfit of each joint: what is left of its torque, as a share of what its own columns leave of it in the log as
/// it is.
///
/// A slope within a factor of two of `scale` is allowed.
pub(super) fn misfits(found: &[Partial], as_it_is: &[Partial], changes: &[Change], scale: f64) -> Vec<f64> {
    let misfit = |(j, p): (usize, &Partial)| {
        let slope = scale * (p.slope() / scale).clamp(0.5, 2.0);
        let of = torque_of(changes, j).0;
        match as_it_is[of].yy {
            whole if whole > 0.0 => (p.left(slope) * p.yy / whole).min(MAX_MISFIT),
            _ if of == j => 0.0,
            // The torque of a joint that stood still explains that of no other.
            _ => MAX_MISFIT,
        }
    };
    found.iter().enumerate().map(misfit).collect()
}

/// The joint whose velocity in the log is that of joint j. The change done last is met first.
pub(super) fn motion_of(changes: &[Change], j: usize) -> usize {
    changes.iter().rev().fold(j, |j, change| change.of.motion_of(j))
}

/// The joint whose position in the log is that of joint j.
pub(super) fn position_of(changes: &[Change], j: usize) -> usize {
    changes.iter().rev().fold(j, |j, change| change.of.position_of(j))
}

/// Which column of the log is the torque of joint j, and the factor of it.
pub(super) fn torque_of(changes: &[Change], j: usize) -> (usize, f64) {
    changes.iter().rev().fold((j, 1.0), |(of, sign), change| {
        let (next, s) = change.of.torque_of(change.size, of);
        (next, sign * s)
    })
}

/// Largest misfit: a description that makes it worse might as well be absent.
const MAX_MISFIT: f64 = 1.0;
