//! Changes that undo what may have been done to a log, and how well a description then predicts the torques.
//!
//! T = Y(q', dq', ddq') X with the changed motion. Joint j's torque is compared with T_j beside the columns F_j =
//! [ddq_j, dq_j, direction_j, 1] that no description has (rotor, friction, offset). The slope may be between half and
//! twice the scale of all joints. What is then left of the torque is the misfit of the joint: 0 where the description
//! predicts it, 1 where it might as well be absent.

use generated::Eight;
use linear_model::regressor::Regressor;
use linear_model::states::States;

use crate::estimate::passport::finding::Columns;
use crate::estimate::passport::regression::Partial;

/// One change of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Change {
    /// The position of a joint is larger by this angle, rad.
    Turned(usize, f64),
    /// The motion of a joint has the other sign.
    Mirrored(usize),
    /// The torque of a joint has the other sign.
    Opposed(usize),
    /// Motion and torque of a joint have the other sign.
    Reversed(usize),
    /// Motions and torques of two joints are exchanged.
    SwappedJoints(usize, usize),
    /// Positions, velocities and accelerations of two joints are exchanged.
    SwappedMotions(usize, usize),
    /// Only the positions of two joints are exchanged.
    SwappedPositions(usize, usize),
    /// Only the velocities and accelerations of two joints are exchanged.
    SwappedVelocities(usize, usize),
    /// Only the torques of two joints are exchanged.
    SwappedTorques(usize, usize),
    /// The angles are in degrees.
    Degrees,
    /// Gravity is not in the torques.
    Weightless,
}

use Change::*;

/// One degree, rad.
const DEGREE_RAD: f64 = std::f64::consts::PI / 180.0;

impl Change {
    /// Which columns it exchanges, where it exchanges all of a kind.
    pub(super) fn exchanges(self) -> Option<Columns> {
        match self {
            SwappedJoints(..) => Some(Columns::All),
            SwappedMotions(..) => Some(Columns::Motions),
            SwappedTorques(..) => Some(Columns::Torques),
            _ => None,
        }
    }

    /// The same exchange of velocities, of a change that exchanges positions.
    pub(super) fn of_velocities(self) -> Change {
        match self {
            SwappedPositions(k, l) => SwappedVelocities(k, l),
            other => other,
        }
    }

    /// Applies it to the motion of one instant.
    fn motion(self, is_angle: &[bool], q: &mut [f64], dq: &mut [f64], ddq: &mut [f64]) {
        match self {
            Turned(k, by) => q[k] += by,
            Mirrored(k) | Reversed(k) => [q, dq, ddq].into_iter().for_each(|x| x[k] = -x[k]),
            SwappedMotions(k, l) | SwappedJoints(k, l) => [q, dq, ddq].into_iter().for_each(|x| x.swap(k, l)),
            SwappedPositions(k, l) => q.swap(k, l),
            SwappedVelocities(k, l) => [dq, ddq].into_iter().for_each(|x| x.swap(k, l)),
            Degrees => {
                for x in [q, dq, ddq] {
                    x.iter_mut().zip(is_angle).filter(|(_, angle)| **angle).for_each(|(x, _)| *x *= DEGREE_RAD);
                }
            }
            Opposed(_) | SwappedTorques(..) | Weightless => {}
        }
    }

    /// A log at the instants `rows` with these changes done.
    pub(super) fn all_done(changes: &[Change], log: &States, rows: &[usize], regressor: &dyn Regressor) -> States {
        let n = log.n;
        let is_angle: Vec<bool> = (0..n).map(|k| !regressor.is_prismatic(k)).collect();
        let mut done = States { n, ..States::default() };
        for &r in rows {
            let of = |x: &[f64]| x[r * n..(r + 1) * n].to_vec();
            let (mut q, mut dq, mut ddq) = (of(&log.q), of(&log.dq), of(&log.ddq));
            changes.iter().for_each(|change| change.motion(&is_angle, &mut q, &mut dq, &mut ddq));
            done.t.push(log.t[r]);
            [(&mut done.q, q), (&mut done.dq, dq), (&mut done.ddq, ddq)].into_iter().for_each(|(all, x)| all.extend(x));
            for j in 0..n {
                let (moves, (of, sign)) = (motion_of(changes, j), torque_of(changes, j));
                done.tau.push(sign * log.tau[r * n + of]);
                // The sign of a column of friction changes nothing that it explains.
                done.direction.push(log.direction[r * n + moves]);
                done.used.push(log.used[r * n + moves]);
            }
        }
        done
    }

    /// The column of the log that is the torque of joint j, and its sign.
    fn torque(self, j: usize) -> (usize, f64) {
        match self {
            Opposed(k) | Reversed(k) if k == j => (j, -1.0),
            SwappedTorques(k, l) | SwappedJoints(k, l) if k == j => (l, 1.0),
            SwappedTorques(k, l) | SwappedJoints(k, l) if l == j => (k, 1.0),
            _ => (j, 1.0),
        }
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
        if changes.contains(&Weightless) {
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
                changes.iter().for_each(|change| change.motion(&is_angle, q, dq, ddq));
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

/// The joint whose velocity in the log is that of joint j.
///
/// The change done last is met first. Changes of sign do not matter, because they change no span of columns.
pub(super) fn motion_of(changes: &[Change], j: usize) -> usize {
    changes.iter().rev().fold(j, |j, change| match *change {
        SwappedMotions(k, l) | SwappedJoints(k, l) | SwappedVelocities(k, l) if k == j => l,
        SwappedMotions(k, l) | SwappedJoints(k, l) | SwappedVelocities(k, l) if l == j => k,
        _ => j,
    })
}

/// Which column of the log is the torque of joint j, and its sign.
pub(super) fn torque_of(changes: &[Change], j: usize) -> (usize, f64) {
    changes.iter().rev().fold((j, 1.0), |(of, sign), change| {
        let (next, s) = change.torque(of);
        (next, sign * s)
    })
}

/// Largest misfit: a description that makes it worse might as well be absent.
const MAX_MISFIT: f64 = 1.0;
