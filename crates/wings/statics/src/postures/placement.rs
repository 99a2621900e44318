//! Estimates the zero errors and the base orientation (mount) with which the nominal bodies explain the postures.
//!
//! ```text
//! tau_j = sum_i g_i T_ij(q + z) + OFF_j     |g| nominal
//! ```
//! T_i: torque of the nominal bodies under a gravity of 1 m/s^2 along axis i of the base; z: zero errors; g: gravity; OFF:
//! offset. The method is Gauss-Newton for z and for two rotations of g about axes normal to g. A joint with an axis along nominal
//! gravity gets no zero error, because a rotation of the base would be equivalent.

use identification::estimate::hypothesis::Hypothesis;
use identification::estimate::log_check::Change;
use identification::estimate::options::Options;
use logs::Postures;
use nalgebra::{DMatrix, DVector, Rotation3, Vector3};

use crate::postures::fit::{PostureFit, ValueWithSigma};
use crate::postures::mistakes::{EXPLAINED, Free, Mistake, MistakeSearch};
use crate::postures::turned_joint::turned_joint;
use rist::Error;
use rist::Model;
use rist::describe::description::rounded_rpy;
use rist::fit::gravity_direction::{base, mounted};
use rist::fit::mount::{Tilt, axes};

/// In the search for another base orientation, a joint has no weight if its torque is below this fraction of the largest torque.
const SMALL_TORQUE: f64 = 1e-3;
/// Largest number of postures that are used in the search for mistakes.
const MAX_SEARCHED_POSTURES: usize = 400;
/// A zero error above this value (rad or m) is too large to be noise. After zero errors were corrected, no zero error above
/// this value may remain.
const FAR_ZERO: f64 = 0.1;
/// Largest number of steps in the search for zero errors and base orientation.
const MAX_STEPS: usize = 50;
/// Largest change of a zero error or an angle in one step, rad (m).
const LARGEST_STEP: f64 = 0.3;
/// The nominal bodies explain the postures if their residual is at most this number of standard deviations. The standard
/// deviations come from a fit of bodies with free parameters.
const EXPLAINED_TIMES: f64 = 2.0;
/// A zero error or a base rotation is significant if it exceeds this number of standard deviations.
const SIGNIFICANT_DEVIATIONS: f64 = 3.0;
/// A combination of zero errors and base rotation is not separable if its singular value is at most this fraction of the largest
/// one.
const NOT_SEPARABLE: f64 = 3e-5;
/// Largest number of times that a step is halved because it increases the residual.
const MAX_HALVINGS: i32 = 8;
/// The search ends if a step reduces the residual by less than this fraction.
const SETTLED_SHARE: f64 = 1e-9;
/// Step of the difference quotient for derivatives of the torques, rad. With this step, nine digits of the torques remain.
const DIFFERENCE_STEP: f64 = 1e-5;
/// A zero error has no effect on any torque if its column in the regressor is below this fraction of the largest column.
const IDLE_SHARE: f64 = 1e-8;

/// The zero errors and the base orientation with which the nominal bodies explain the postures.
pub struct ZerosAndMount {
    /// For each joint, the angle (length) that is added to its positions, with the standard deviation, rad (m).
    pub zeros: Vec<ValueWithSigma>,
    /// Orientation of the base: roll, pitch and yaw, rad.
    pub base: [f64; 3],
    /// Angle between the estimated and the nominal direction of gravity, with the standard deviation, rad.
    pub tilt: ValueWithSigma,
    /// Relative residuals of the torques: [nominal zeros and orientation, these zeros and this orientation].
    pub left: [f64; 2],
    /// Whether the residual with these zeros and this orientation is about as small as the residual of bodies with free
    /// parameters.
    pub explains: bool,
    /// The options that set these zeros; `None` if no zero error is significant.
    held: Option<String>,
}

/// Estimates zero errors and base orientation, starting from the nominal values. `None` if the model has no bodies, or if its
/// loops are solved numerically.
pub(super) fn placed(
    model: &Model,
    postures: &Postures,
    torques: &[DVector<f64>],
    deviations: &[f64],
    options: &Options,
) -> Result<Option<ZerosAndMount>, Error> {
    let described = Vector3::from(model.robot.gravity_number());
    let is_described = model.robot.links.iter().any(|link| link.inertial.is_some());
    if !is_described || !model.robot.passive.is_empty() || described.norm() == 0.0 {
        return Ok(None);
    }
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let axes: Option<Vec<Tilt>> = axes.into_iter().map(|axis| Tilt::of(&model.robot, axis)).collect();
    let Some(axes) = axes else { return Ok(None) };
    let turns = turns(model);
    let search = PlacementSearch { axes, postures, torques, deviations, turns: &turns };
    let SearchEnd { zeros, gravity, fit, left } = search.found(described)?;
    let n = torques.len();
    let misfit = left[1] / (postures.q.len() * n) as f64;
    // The relative residual of all torques, without weights. Weights would hide errors: a joint that a fit of free bodies
    // explains badly has a large standard deviation.
    let share = |zeros: &[f64], gravity: &Vector3<f64>| {
        let left: f64 =
            search.residuals(zeros, gravity, usize::MAX).iter().map(|x| x.add_scalar(-x.mean()).norm_squared()).sum();
        (left / torques.iter().map(|x| x.norm_squared()).sum::<f64>().max(f64::MIN_POSITIVE)).sqrt()
    };
    let after = share(&zeros, &gravity);
    let with_sigma = |k: usize, value: f64| fit.identified[k].map(|(_, deviation)| (value, deviation));
    let zeros_told: Vec<ValueWithSigma> = zeros.iter().enumerate().map(|(k, zero)| with_sigma(k, *zero)).collect();
    let changes: Vec<Change> = zeros_told
        .iter()
        .enumerate()
        .filter(|(_, zero)| is_identifiable(zero))
        .map(|(k, zero)| Change { of: Hypothesis::Zero(k), size: zero.map_or(0.0, |zero| zero.0) })
        .collect();
    let undoing = options.undoing(&changes, &postures.names, &turns);
    let tilt = match (fit.identified[n], fit.identified[n + 1]) {
        (Some((_, a)), Some((_, b))) => Some((gravity.angle(&described), a.max(b))),
        _ => None,
    };
    Ok(Some(ZerosAndMount {
        zeros: zeros_told,
        held: undoing.and_then(|undoing| undoing.remedy_added_to(options)),
        base: rounded_rpy(&base(model, &gravity), 5),
        tilt,
        left: [share(&vec![0.0; n], &described), after],
        explains: misfit.sqrt() < EXPLAINED_TIMES && after < EXPLAINED,
    }))
}

/// Mistakes in the columns of a table of postures, found with the nominal bodies. Empty if the model has no bodies, or if its
/// loops are solved numerically. `placed`: the estimated zero errors and base orientation. If these do not explain the postures
/// or are not significant, large zero errors and other base orientations are also tested here.
pub(super) fn looks_for_mistakes(
    model: &Model,
    (postures, torques): (&Postures, &[DVector<f64>]),
    free: Free,
    options: &Options,
    placed: Option<&ZerosAndMount>,
) -> Result<Vec<Mistake>, Error> {
    let gravity = Vector3::from(model.robot.gravity_number());
    let is_described = model.robot.links.iter().any(|link| link.inertial.is_some());
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let axes: Option<Vec<Tilt>> = axes.into_iter().map(|axis| Tilt::of(&model.robot, axis)).collect();
    let Some(axes) = axes.filter(|_| is_described && model.robot.passive.is_empty()) else { return Ok(Vec::new()) };
    // Only some of the postures are used, because a large table would take long and give no more information.
    let step = postures.q.len().div_ceil(MAX_SEARCHED_POSTURES);
    let some = Postures { q: postures.q.iter().step_by(step).cloned().collect(), ..postures.clone() };
    let torques: Vec<DVector<f64>> =
        torques.iter().map(|x| DVector::from_iterator(some.q.len(), x.iter().step_by(step).copied())).collect();
    // There are no standard deviations before a fit, so all joints have equal weights, except joints with nearly no gravity
    // torque.
    let sizes: Vec<f64> = torques.iter().map(|x| x.add_scalar(-x.mean()).norm()).collect();
    let least = SMALL_TORQUE * sizes.iter().fold(0.0, |m: f64, x| m.max(*x));
    let deviations: Vec<f64> = sizes.iter().map(|x| x.max(least).max(f64::MIN_POSITIVE)).collect();
    let turns = turns(model);
    let search = PlacementSearch { axes, postures: &some, torques: &torques, deviations: &deviations, turns: &turns };
    let mount = match placed {
        Some(placed) if !placed.explains || !placed.differs() => {
            let found = search.gravity_alone()? * gravity.norm();
            Some((found, mounted(rounded_rpy(&base(model, &found), 5))))
        }
        _ => None,
    };
    let described = |q: &[f64], gravity: &Vector3<f64>| search.under(q, gravity);
    let (postures, torques, turns) = (&some, &torques[..], &turns[..]);
    Ok(MistakeSearch { postures, torques, described: &described, free, options, turns, gravity, mount }.mistakes())
}

/// Whether each joint is revolute.
fn turns(model: &Model) -> Vec<bool> {
    (0..model.regressor().coordinates().len()).map(|k| !model.regressor().is_prismatic(k)).collect()
}

/// For each joint: the columns of the unknowns, and the residuals of the joint's torques.
type JointColumns = (Vec<DMatrix<f64>>, Vec<DVector<f64>>);

/// The result of a search for zero errors and gravity.
struct SearchEnd {
    zeros: Vec<f64>,
    gravity: Vector3<f64>,
    /// The last Gauss-Newton step, from which the standard deviations follow.
    fit: PostureFit,
    /// Sum of the squared residuals, each divided by the variance of its joint: [at the nominal values, at the result].
    left: [f64; 2],
}

struct PlacementSearch<'a> {
    axes: Vec<Tilt>,
    postures: &'a Postures,
    torques: &'a [DVector<f64>],
    deviations: &'a [f64],
    /// Whether each joint is revolute.
    turns: &'a [bool],
}

impl PlacementSearch<'_> {
    /// Searches zero errors and gravity with the smallest residual, by Gauss-Newton steps that reduce the residual.
    /// `described`: nominal gravity, where the search starts.
    fn found(&self, described: Vector3<f64>) -> Result<SearchEnd, Error> {
        let n = self.torques.len();
        let (mut zeros, mut gravity) = (vec![0.0; n], described);
        let (as_described, left_as_described) = self.look(&zeros, &gravity);
        let before = self.residual_squares(&left_as_described);
        let idle = idle(&as_described, n);
        let mut left = before;
        // A robot on a ceiling has the same torques as a robot whose shoulder zero is wrong by half a turn. Of these two
        // explanations, a change of the base orientation alone is tried first.
        let by_mount = self.gravity_alone()? * described.norm();
        let left_by_mount = self.residual_squares(&self.residuals(&zeros, &by_mount, usize::MAX));
        if left_by_mount < before {
            (gravity, left) = (by_mount, left_by_mount);
        }
        // Then a zero error of each single joint is tried: Gauss-Newton from a start far from the solution would end at a local
        // minimum.
        if before > EXPLAINED_TIMES.powi(2) * (n * self.postures.q.len()) as f64 {
            for k in (0..n).filter(|k| self.turns[*k] && !idle.contains(k)) {
                let alone = |zero: f64| (0..n).map(|j| if j == k { zero } else { 0.0 }).collect::<Vec<_>>();
                let of_some =
                    |zero: f64| self.residual_squares(&self.residuals(&alone(zero), &described, MAX_SEARCHED_POSTURES));
                let Some(zero) = turned_joint(&of_some) else { continue };
                let left_by_zero = self.residual_squares(&self.residuals(&alone(zero), &described, usize::MAX));
                if left_by_zero < left {
                    (zeros, gravity, left) = (alone(zero), described, left_by_zero);
                }
            }
        }
        let mut fit = self.step(&zeros, &gravity, &idle)?;
        // Gauss-Newton. A step that increases the residual is halved.
        for _ in 0..MAX_STEPS {
            let angle = |k: usize, share: f64| share * fit.solution[k].clamp(-LARGEST_STEP, LARGEST_STEP);
            let [first, second] = axes(&gravity).map(|(_, axis)| axis);
            let at = |share: f64| {
                let moved: Vec<f64> = zeros.iter().enumerate().map(|(k, zero)| zero + angle(k, share)).collect();
                let turned = Rotation3::new(first * angle(n, share) + second * angle(n + 1, share)) * gravity;
                let left = self.residual_squares(&self.residuals(&moved, &turned, usize::MAX));
                (moved, turned, left)
            };
            let tried = (0..MAX_HALVINGS).map(|k| at(0.5_f64.powi(k))).find(|(.., moved)| *moved < left);
            let Some((moved, turned, less)) = tried else { break };
            let is_settled = left - less < SETTLED_SHARE * left;
            (zeros, gravity, left) = (moved, turned, less);
            fit = self.step(&zeros, &gravity, &idle)?;
            if is_settled {
                break;
            }
        }
        Ok(SearchEnd { zeros, gravity, fit, left: [before, left] })
    }

    /// One Gauss-Newton step for zero errors, gravity direction and torque offsets. `idle`: joints that get no zero error.
    fn step(&self, zeros: &[f64], gravity: &Vector3<f64>, idle: &[usize]) -> Result<PostureFit, Error> {
        let (mut columns, left) = self.look(zeros, gravity);
        columns.iter_mut().for_each(|c| idle.iter().for_each(|&k| c.column_mut(k).fill(0.0)));
        PostureFit::weighted(&columns, &left, self.deviations, NOT_SEPARABLE)
    }

    /// For each joint, its torque at the position `q` under gravity, N m (N).
    fn under(&self, q: &[f64], gravity: &Vector3<f64>) -> Vec<f64> {
        let by_axis: Vec<Vec<f64>> = self.axes.iter().map(|tilt| tilt.torques(q)).collect();
        (0..q.len()).map(|j| (0..3).map(|i| gravity[i] * by_axis[i][j]).sum()).collect()
    }

    /// For each joint, the residuals of its torques, at no more than `most` postures.
    fn residuals(&self, zeros: &[f64], gravity: &Vector3<f64>, most: usize) -> Vec<DVector<f64>> {
        let step = self.postures.q.len().div_ceil(most).max(1);
        let rows = self.postures.q.iter().step_by(step);
        let torques = rows.map(|q| self.under(&q.iter().zip(zeros).map(|(q, z)| q + z).collect::<Vec<_>>(), gravity));
        let torques: Vec<Vec<f64>> = torques.collect();
        let joint = |j: usize| DVector::from_fn(torques.len(), |r, _| self.torques[j][r * step] - torques[r][j]);
        (0..zeros.len()).map(joint).collect()
    }

    /// For each joint, the columns of the zero errors, of the two rotations of gravity, and of the offsets; and the residuals.
    fn look(&self, zeros: &[f64], gravity: &Vector3<f64>) -> JointColumns {
        let n = zeros.len();
        let turns = axes(gravity).map(|(_, axis)| axis.cross(gravity));
        let mut columns = vec![DMatrix::zeros(self.postures.q.len(), 2 * n + 2); n];
        for (r, q) in self.postures.q.iter().enumerate() {
            let q: Vec<f64> = q.iter().zip(zeros).map(|(q, z)| q + z).collect();
            for k in 0..n {
                let at = |step: f64| {
                    let mut moved = q.clone();
                    moved[k] += step;
                    self.under(&moved, gravity)
                };
                let (ahead, behind) = (at(DIFFERENCE_STEP), at(-DIFFERENCE_STEP));
                (0..n).for_each(|j| columns[j][(r, k)] = (ahead[j] - behind[j]) / (2.0 * DIFFERENCE_STEP));
            }
            for (k, turn) in turns.iter().enumerate() {
                let by = self.under(&q, turn);
                (0..n).for_each(|j| columns[j][(r, n + k)] = by[j]);
            }
            (0..n).for_each(|j| columns[j][(r, n + 2 + j)] = 1.0);
        }
        (columns, self.residuals(zeros, gravity, usize::MAX))
    }

    /// The sum of squares of the residuals, each divided by the standard deviation of its joint.
    fn squares(&self, left: &[DVector<f64>]) -> f64 {
        left.iter().zip(self.deviations).map(|(x, d)| x.norm_squared() / (d * d)).sum()
    }

    /// The sum of squares of the residuals, each divided by the standard deviation of its joint, after removing the mean of each
    /// joint.
    fn residual_squares(&self, left: &[DVector<f64>]) -> f64 {
        let without_offset: Vec<DVector<f64>> = left.iter().map(|x| x.add_scalar(-x.mean())).collect();
        self.squares(&without_offset)
    }

    /// The direction of gravity in the base frame for nominal zeros. The torques are linear in this direction, so linear least
    /// squares gives it.
    fn gravity_alone(&self) -> Result<Vector3<f64>, Error> {
        let n = self.torques.len();
        let mut columns = vec![DMatrix::zeros(self.postures.q.len(), 3 + n); n];
        for (r, q) in self.postures.q.iter().enumerate() {
            for (i, tilt) in self.axes.iter().enumerate() {
                tilt.torques(q).iter().zip(&mut columns).for_each(|(torque, columns)| columns[(r, i)] = *torque);
            }
            columns.iter_mut().enumerate().for_each(|(j, columns)| columns[(r, 3 + j)] = 1.0);
        }
        let fit = PostureFit::weighted(&columns, self.torques, self.deviations, NOT_SEPARABLE)?;
        let found = Vector3::new(fit.solution[0], fit.solution[1], fit.solution[2]);
        Ok(found.try_normalize(f64::MIN_POSITIVE).unwrap_or(Vector3::z()))
    }
}

/// Indices of the joints whose zero error has no effect on any torque.
fn idle(columns: &[DMatrix<f64>], n: usize) -> Vec<usize> {
    let size = |k: usize| columns.iter().map(|c| c.column(k).norm_squared()).sum::<f64>().sqrt();
    let sizes: Vec<f64> = (0..n).map(size).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    (0..n).filter(|&k| sizes[k] <= IDLE_SHARE * largest).collect()
}

/// Whether a value differs significantly from zero. `None` counts as no difference.
fn is_identifiable(value: &ValueWithSigma) -> bool {
    value.is_some_and(|(value, deviation)| value.abs() > SIGNIFICANT_DEVIATIONS * deviation)
}

impl ZerosAndMount {
    /// Whether a zero error or the base orientation differs significantly from the nominal value.
    pub fn differs(&self) -> bool {
        self.zeros.iter().chain([&self.tilt]).any(is_identifiable)
    }

    /// Whether no significant zero error exceeds [`FAR_ZERO`].
    pub(super) fn is_near(&self) -> bool {
        !self.zeros.iter().any(|value| is_identifiable(value) && value.is_some_and(|(zero, _)| zero.abs() > FAR_ZERO))
    }

    /// The options that set the base orientation and the zeros.
    pub fn remedy(&self) -> String {
        let mount = is_identifiable(&self.tilt).then(|| mounted(self.base));
        mount.into_iter().chain(self.held.clone()).collect::<Vec<_>>().join("; and ")
    }
}
