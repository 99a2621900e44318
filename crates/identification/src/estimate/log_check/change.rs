//! Changes of a log that undo faults, and the misfit: the error with which a robot description predicts the torques of the
//! changed log.
//!
//! T = Y(q', dq', ddq') X are the nominal torques of the changed motion. The torque of joint j is regressed on T_j and on the
//! columns F_j = [ddq_j, dq_j, direction_j, 1] (rotor, viscous and Coulomb friction, offset), which no description contains. The
//! slope of T_j is limited to 0.5 to 2 times the common scale of all joints.
//!
//! The misfit of a joint is the squared residual of this fit, divided by the squared residual of a fit by F_j alone. The misfit
//! is 0 if the description predicts the torque exactly, and 1 if the description explains nothing.

use generated::Eight;
use linear_model::regressor::Regressor;
use linear_model::states::States;

use crate::estimate::hypothesis::Hypothesis;
use crate::estimate::log_check::regression::Partial;

/// A change of a log that undoes one fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// The fault that is undone.
    pub of: Hypothesis,
    /// Size of the fault. For a wrong zero of a position: true minus logged position, rad. For a wrong scale of a torque: logged
    /// / true torque - 1. Otherwise 0.
    pub size: f64,
}

impl Change {
    /// Makes the change that undoes a fault without a size.
    pub(crate) fn of(of: Hypothesis) -> Change {
        Change { of, size: 0.0 }
    }

    /// Makes the change that adds the angle `angle`, rad, to the position of coordinate k.
    pub(super) fn turned(k: usize, angle: f64) -> Change {
        Change { of: Hypothesis::Zero(k), size: angle }
    }

    /// Applies the changes to one position of the robot. `q`: one entry per coordinate, rad (m).
    pub(super) fn move_positions(changes: &[Change], q: &mut [f64], regressor: &dyn Regressor) {
        let is_angle: Vec<bool> = (0..q.len()).map(|k| !regressor.is_prismatic(k)).collect();
        let (mut dq, mut ddq) = (vec![0.0; q.len()], vec![0.0; q.len()]);
        changes.iter().for_each(|change| change.of.undo_motion(change.size, &is_angle, q, &mut dq, &mut ddq));
    }

    /// Applies the changes to the samples `rows` of a log and returns these samples.
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
            // A fault changes the directions of motion (signs of velocities) like the velocities. But directions have no unit,
            // so they are not converted from degrees.
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

/// A robot description with inertials: it predicts torques for any motion.
pub(super) struct Description<'a> {
    pub regressor: &'a dyn Regressor,
    /// The nominal base parameters.
    pub parameters: &'a [f64],
}

impl Description<'_> {
    /// Nominal torques of the changed motion at the samples `rows`, N m (N): sample by sample, n per sample. The torques are
    /// without gravity if one of the changes is `GravityCompensated`.
    pub(super) fn torques(&self, states: &States, rows: &[usize], changes: &[Change]) -> Vec<f64> {
        let mut torques = self.moving(states, rows, changes, 1.0);
        if changes.iter().any(|change| change.of == Hypothesis::GravityCompensated) {
            let at_rest = self.moving(states, rows, changes, 0.0);
            torques.iter_mut().zip(at_rest).for_each(|(tau, gravity)| *tau -= gravity);
        }
        torques
    }

    /// Nominal torques of the changed motion at the samples `rows`, with gravity. `moves`: factor on velocities and
    /// accelerations (1: moving, 0: at rest).
    fn moving(&self, states: &States, rows: &[usize], changes: &[Change], moves: f64) -> Vec<f64> {
        let n = states.n;
        let is_angle: Vec<bool> = (0..n).map(|k| !self.regressor.is_prismatic(k)).collect();
        let non_zeros = self.regressor.non_zeros();
        let mut out = vec![0.0; rows.len() * n];
        let mut inputs = vec![0.0; SAMPLES_PER_PASS * 3 * n];
        let stride = non_zeros.len().max(1);
        let mut entries = vec![Eight::default(); SAMPLES_PER_PASS / 8 * stride];
        for (some, out) in rows.chunks(SAMPLES_PER_PASS).zip(out.chunks_mut((SAMPLES_PER_PASS * n).max(1))) {
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
            // The SIMD lanes after the last sample contain earlier samples. The results of these lanes are not read.
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

/// Number of samples whose regressors are computed in one call: eight blocks of eight SIMD lanes.
const SAMPLES_PER_PASS: usize = 64;

/// Bounds of the regression slope (measured / nominal torque) of a joint, relative to the common scale of all joints.
const SLOPE_RANGE: [f64; 2] = [0.5, 2.0];

/// Least number of used samples for which a joint is examined.
pub(super) const MIN_SAMPLES_PER_JOINT: usize = 60;

/// Column k of an array with n columns, stored row by row, at the samples `rows`.
pub(super) fn column(x: &[f64], n: usize, k: usize, rows: &[usize]) -> Vec<f64> {
    rows.iter().map(|&r| x[r * n + k]).collect()
}

/// Indices into `rows` of the samples at which joint j is used.
pub(super) fn used(states: &States, rows: &[usize], j: usize) -> Vec<usize> {
    (0..rows.len()).filter(|&i| states.used[rows[i] * states.n + j]).collect()
}

/// The misfit of each joint, 0 to 1: squared residual of the description in the changed log (`found`), divided by the squared
/// residual without the description in the unchanged log (`as_it_is`). `scale`: common scale of the torques of all joints.
pub(super) fn misfits(found: &[Partial], as_it_is: &[Partial], changes: &[Change], scale: f64) -> Vec<f64> {
    let misfit = |(j, p): (usize, &Partial)| {
        let slope = scale * (p.slope() / scale).clamp(SLOPE_RANGE[0], SLOPE_RANGE[1]);
        let of = torque_of(changes, j).0;
        match as_it_is[of].yy {
            whole if whole > 0.0 => (p.residual(slope) * p.yy / whole).min(MAX_MISFIT),
            _ if of == j => 0.0,
            // If the logged torque of a joint is constant, its column cannot be the torque of another joint.
            _ => MAX_MISFIT,
        }
    };
    found.iter().enumerate().map(misfit).collect()
}

/// Number of the joint whose columns in the unchanged log become the velocity of joint j. The changes are traced back from the
/// last to the first.
pub(super) fn motion_of(changes: &[Change], j: usize) -> usize {
    changes.iter().rev().fold(j, |j, change| change.of.motion_of(j))
}

/// Number of the joint whose column in the log contains the position of joint j.
pub(super) fn position_of(changes: &[Change], j: usize) -> usize {
    changes.iter().rev().fold(j, |j, change| change.of.position_of(j))
}

/// Number of the joint whose column in the log contains the torque of joint j, and the factor that corrects this column.
pub(super) fn torque_of(changes: &[Change], j: usize) -> (usize, f64) {
    changes.iter().rev().fold((j, 1.0), |(of, sign), change| {
        let (next, s) = change.of.torque_of(change.size, of);
        (next, sign * s)
    })
}

/// Upper bound of a misfit (squared residual, divided by the residual without the description): at 1 the description explains
/// nothing.
const MAX_MISFIT: f64 = 1.0;
