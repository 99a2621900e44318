//! Zeros and mount that explain postures by the bodies of the description.
//!
//! ```text
//! tau_j = sum_i g_i T_ij(q + z) + OFF_j     |g| as described
//! ```
//! T_i is the torque of the described bodies under gravity along axis i of the base, one; Gauss-Newton in z and in two turns
//! of g across it. A joint whose axis is along gravity as described has no zero: a mount beside it would be turned with it.

use identification::estimate::hypothesis::Hypothesis;
use identification::estimate::options::Options;
use identification::estimate::passport::Change;
use logs::Postures;
use nalgebra::{DMatrix, DVector, Rotation3, Vector3};

use crate::postures::fit::{Fit, Told};
use crate::postures::mistakes::{EXPLAINED, Free, Look as Held, Mistake};
use crate::postures::turned_joint::turned_joint;
use rist::Error;
use rist::Model;
use rist::describe::description::rounded_rpy;
use rist::fit::gravity_direction::{base, mounted};
use rist::fit::mount::{Tilt, axes};

/// Torques of a joint below this share of those of the largest are of no weight in another mount.
const SMALL_TORQUE: f64 = 1e-3;
/// The most postures that mistakes are looked for in.
const LOOKED_AT: usize = 400;
/// A zero that is left where zeros are held is none of noise, rad (m).
const FAR: f64 = 0.1;
/// Steps until the search for zeros and mount is given up.
const MOST_STEPS: usize = 50;
/// rad, the largest change in a step.
const LARGEST_STEP: f64 = 0.3;
/// Bodies of the description explain postures that they leave at most so many times the deviation of free bodies.
const EXPLAINED_TIMES: f64 = 2.0;
/// A zero or mount below this many deviations is none.
const TELLING_DEVIATIONS: f64 = 3.0;
/// Zeros and mount are told together where the singular value of each direction has more than this share of the largest.
const UNTOLD_UNKNOWN: f64 = 3e-5;
/// A step that leaves more is halved so often.
const MOST_HALVINGS: i32 = 8;
/// Steps that mend a smaller share end the search.
const SETTLED_SHARE: f64 = 1e-9;
/// rad, the step of a difference: torques that far apart keep nine digits.
const DIFFERENCE_STEP: f64 = 1e-5;
/// A joint moves no torque where its column is below this share of the largest.
const IDLE_SHARE: f64 = 1e-8;

/// Zeros and mount that explain the postures by the bodies of the description.
pub struct Placed {
    /// rad (m), to be added to the positions of each joint, with its deviation.
    pub zeros: Vec<Told>,
    /// rad, roll, pitch and yaw of the base.
    pub base: [f64; 3],
    /// rad, by which gravity is turned from where it is described, with its deviation.
    pub tilt: Told,
    /// Shares of the torques that the description leaves as it is, and with zeros and mount.
    pub left: [f64; 2],
    /// Whether it then leaves no more than bodies of its own would explain.
    pub explains: bool,
    /// The options that hold the zeros, where there are any.
    held: Option<String>,
}

/// Zeros and mount from those of the description; `None` where it has no bodies, or loops that are solved numerically.
pub(super) fn placed(
    model: &Model,
    postures: &Postures,
    torques: &[DVector<f64>],
    deviations: &[f64],
    options: &Options,
) -> Result<Option<Placed>, Error> {
    let described = Vector3::from(model.robot.gravity_number());
    let is_described = model.robot.links.iter().any(|link| link.inertial.is_some());
    if !is_described || !model.robot.passive.is_empty() || described.norm() == 0.0 {
        return Ok(None);
    }
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let axes: Option<Vec<Tilt>> = axes.into_iter().map(|axis| Tilt::of(&model.robot, axis)).collect();
    let Some(axes) = axes else { return Ok(None) };
    let turns = turns(model);
    let search = Search { axes, postures, torques, deviations, turns: &turns };
    let Found { zeros, gravity, fit, left } = search.found(described)?;
    let n = torques.len();
    let misfit = left[1] / (postures.q.len() * n) as f64;
    // Of all torques alike: a joint that free bodies explain badly has a large deviation.
    let share = |zeros: &[f64], gravity: &Vector3<f64>| {
        let left: f64 =
            search.residuals(zeros, gravity, usize::MAX).iter().map(|x| x.add_scalar(-x.mean()).norm_squared()).sum();
        (left / torques.iter().map(|x| x.norm_squared()).sum::<f64>().max(f64::MIN_POSITIVE)).sqrt()
    };
    let after = share(&zeros, &gravity);
    let told = |k: usize, value: f64| fit.told[k].map(|(_, deviation)| (value, deviation));
    let zeros_told: Vec<Told> = zeros.iter().enumerate().map(|(k, zero)| told(k, *zero)).collect();
    let changes: Vec<Change> = zeros_told
        .iter()
        .enumerate()
        .filter(|(_, zero)| tells(zero))
        .map(|(k, zero)| Change { of: Hypothesis::Zero(k), size: zero.map_or(0.0, |zero| zero.0) })
        .collect();
    let undoing = options.undoing(&changes, &postures.names, &turns);
    let tilt = match (fit.told[n], fit.told[n + 1]) {
        (Some((_, a)), Some((_, b))) => Some((gravity.angle(&described), a.max(b))),
        _ => None,
    };
    Ok(Some(Placed {
        zeros: zeros_told,
        held: undoing.and_then(|undoing| undoing.remedy_beside(options)),
        base: rounded_rpy(&base(model, &gravity), 5),
        tilt,
        left: [share(&vec![0.0; n], &described), after],
        explains: misfit.sqrt() < EXPLAINED_TIMES && after < EXPLAINED,
    }))
}

/// Mistakes of the columns by the bodies of the description; none where it has no bodies, or loops that are solved numerically.
/// `placed`: zeros and mount, which are looked at here where they explain nothing, or are not told.
pub(super) fn looks_for_mistakes(
    model: &Model,
    (postures, torques): (&Postures, &[DVector<f64>]),
    free: Free,
    options: &Options,
    placed: Option<&Placed>,
) -> Result<Vec<Mistake>, Error> {
    let gravity = Vector3::from(model.robot.gravity_number());
    let is_described = model.robot.links.iter().any(|link| link.inertial.is_some());
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let axes: Option<Vec<Tilt>> = axes.into_iter().map(|axis| Tilt::of(&model.robot, axis)).collect();
    let Some(axes) = axes.filter(|_| is_described && model.robot.passive.is_empty()) else { return Ok(Vec::new()) };
    // Large tables say no more, and take long.
    let step = postures.q.len().div_ceil(LOOKED_AT);
    let some = Postures { q: postures.q.iter().step_by(step).cloned().collect(), ..postures.clone() };
    let torques: Vec<DVector<f64>> =
        torques.iter().map(|x| DVector::from_iterator(some.q.len(), x.iter().step_by(step).copied())).collect();
    // Joints alike, but for those that gravity does not move: what nothing explains yet has no deviation.
    let sizes: Vec<f64> = torques.iter().map(|x| x.add_scalar(-x.mean()).norm()).collect();
    let least = SMALL_TORQUE * sizes.iter().fold(0.0, |m: f64, x| m.max(*x));
    let deviations: Vec<f64> = sizes.iter().map(|x| x.max(least).max(f64::MIN_POSITIVE)).collect();
    let turns = turns(model);
    let search = Search { axes, postures: &some, torques: &torques, deviations: &deviations, turns: &turns };
    let mount = match placed {
        Some(placed) if !placed.explains || !placed.differs() => {
            let found = search.gravity_alone()? * gravity.norm();
            Some((found, mounted(rounded_rpy(&base(model, &found), 5))))
        }
        _ => None,
    };
    let described = |q: &[f64], gravity: &Vector3<f64>| search.under(q, gravity);
    let (postures, torques, turns) = (&some, &torques[..], &turns[..]);
    Ok(Held { postures, torques, described: &described, free, options, turns, gravity, mount }.mistakes())
}

/// Whether each joint turns.
fn turns(model: &Model) -> Vec<bool> {
    (0..model.regressor().coordinates().len()).map(|k| !model.regressor().is_prismatic(k)).collect()
}

/// The columns of each joint, and what is left of its torques.
type Look = (Vec<DMatrix<f64>>, Vec<DVector<f64>>);

/// The end of a search.
struct Found {
    zeros: Vec<f64>,
    gravity: Vector3<f64>,
    /// The last step, with the deviations.
    fit: Fit,
    /// What is left as described and so, in squares over the deviations.
    left: [f64; 2],
}

struct Search<'a> {
    axes: Vec<Tilt>,
    postures: &'a Postures,
    torques: &'a [DVector<f64>],
    deviations: &'a [f64],
    /// Whether each joint turns.
    turns: &'a [bool],
}

impl Search<'_> {
    /// Zeros and gravity, step by step, none of which leaves more than the one before.
    fn found(&self, described: Vector3<f64>) -> Result<Found, Error> {
        let n = self.torques.len();
        let (mut zeros, mut gravity) = (vec![0.0; n], described);
        let (as_described, left_as_described) = self.look(&zeros, &gravity);
        let before = self.left(&left_as_described);
        let idle = idle(&as_described, n);
        let mut left = before;
        // A robot on a ceiling is one whose shoulder is off by half a turn: the mount alone is tried first.
        let by_mount = self.gravity_alone()? * described.norm();
        let left_by_mount = self.left(&self.residuals(&zeros, &by_mount, usize::MAX));
        if left_by_mount < before {
            (gravity, left) = (by_mount, left_by_mount);
        }
        // And so is a joint alone: from far away the steps end beside it.
        if before > EXPLAINED_TIMES.powi(2) * (n * self.postures.q.len()) as f64 {
            for k in (0..n).filter(|k| self.turns[*k] && !idle.contains(k)) {
                let alone = |zero: f64| (0..n).map(|j| if j == k { zero } else { 0.0 }).collect::<Vec<_>>();
                let of_some = |zero: f64| self.left(&self.residuals(&alone(zero), &described, LOOKED_AT));
                let Some(zero) = turned_joint(&of_some) else { continue };
                let left_by_zero = self.left(&self.residuals(&alone(zero), &described, usize::MAX));
                if left_by_zero < left {
                    (zeros, gravity, left) = (alone(zero), described, left_by_zero);
                }
            }
        }
        let mut fit = self.step(&zeros, &gravity, &idle)?;
        for _ in 0..MOST_STEPS {
            let angle = |k: usize, share: f64| share * fit.solution[k].clamp(-LARGEST_STEP, LARGEST_STEP);
            let [first, second] = axes(&gravity).map(|(_, axis)| axis);
            let at = |share: f64| {
                let moved: Vec<f64> = zeros.iter().enumerate().map(|(k, zero)| zero + angle(k, share)).collect();
                let turned = Rotation3::new(first * angle(n, share) + second * angle(n + 1, share)) * gravity;
                let left = self.left(&self.residuals(&moved, &turned, usize::MAX));
                (moved, turned, left)
            };
            let tried = (0..MOST_HALVINGS).map(|k| at(0.5_f64.powi(k))).find(|(.., moved)| *moved < left);
            let Some((moved, turned, less)) = tried else { break };
            let is_settled = left - less < SETTLED_SHARE * left;
            (zeros, gravity, left) = (moved, turned, less);
            fit = self.step(&zeros, &gravity, &idle)?;
            if is_settled {
                break;
            }
        }
        Ok(Found { zeros, gravity, fit, left: [before, left] })
    }

    /// What mends zeros and mount, and offsets of the torques.
    fn step(&self, zeros: &[f64], gravity: &Vector3<f64>, idle: &[usize]) -> Result<Fit, Error> {
        let (mut columns, left) = self.look(zeros, gravity);
        columns.iter_mut().for_each(|c| idle.iter().for_each(|&k| c.column_mut(k).fill(0.0)));
        Fit::weighted(&columns, &left, self.deviations, UNTOLD_UNKNOWN)
    }

    /// N m (N) of each joint at a position under gravity.
    fn under(&self, q: &[f64], gravity: &Vector3<f64>) -> Vec<f64> {
        let by_axis: Vec<Vec<f64>> = self.axes.iter().map(|tilt| tilt.torques(q)).collect();
        (0..q.len()).map(|j| (0..3).map(|i| gravity[i] * by_axis[i][j]).sum()).collect()
    }

    /// What is left of the torques of postures, of so many at most.
    fn residuals(&self, zeros: &[f64], gravity: &Vector3<f64>, most: usize) -> Vec<DVector<f64>> {
        let step = self.postures.q.len().div_ceil(most).max(1);
        let rows = self.postures.q.iter().step_by(step);
        let torques = rows.map(|q| self.under(&q.iter().zip(zeros).map(|(q, z)| q + z).collect::<Vec<_>>(), gravity));
        let torques: Vec<Vec<f64>> = torques.collect();
        let joint = |j: usize| DVector::from_fn(torques.len(), |r, _| self.torques[j][r * step] - torques[r][j]);
        (0..zeros.len()).map(joint).collect()
    }

    /// Columns of the zeros, of the two turns, of the offsets.
    fn look(&self, zeros: &[f64], gravity: &Vector3<f64>) -> Look {
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

    /// The sum of squares, each joint over its deviation.
    fn squares(&self, left: &[DVector<f64>]) -> f64 {
        left.iter().zip(self.deviations).map(|(x, d)| x.norm_squared() / (d * d)).sum()
    }

    /// What is left of the torques beside an offset of each joint, in squares over the deviations.
    fn left(&self, left: &[DVector<f64>]) -> f64 {
        let without_offset: Vec<DVector<f64>> = left.iter().map(|x| x.add_scalar(-x.mean())).collect();
        self.squares(&without_offset)
    }

    /// The direction of gravity in the frame of the base, zeros as they are: the torques are linear in it.
    fn gravity_alone(&self) -> Result<Vector3<f64>, Error> {
        let n = self.torques.len();
        let mut columns = vec![DMatrix::zeros(self.postures.q.len(), 3 + n); n];
        for (r, q) in self.postures.q.iter().enumerate() {
            for (i, tilt) in self.axes.iter().enumerate() {
                tilt.torques(q).iter().zip(&mut columns).for_each(|(torque, columns)| columns[(r, i)] = *torque);
            }
            columns.iter_mut().enumerate().for_each(|(j, columns)| columns[(r, 3 + j)] = 1.0);
        }
        let fit = Fit::weighted(&columns, self.torques, self.deviations, UNTOLD_UNKNOWN)?;
        let found = Vector3::new(fit.solution[0], fit.solution[1], fit.solution[2]);
        Ok(found.try_normalize(f64::MIN_POSITIVE).unwrap_or(Vector3::z()))
    }
}

/// The joints that move no torque.
fn idle(columns: &[DMatrix<f64>], n: usize) -> Vec<usize> {
    let size = |k: usize| columns.iter().map(|c| c.column(k).norm_squared()).sum::<f64>().sqrt();
    let sizes: Vec<f64> = (0..n).map(size).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    (0..n).filter(|&k| sizes[k] <= IDLE_SHARE * largest).collect()
}

/// Whether a value is several of its deviations.
fn tells(told: &Told) -> bool {
    told.is_some_and(|(value, deviation)| value.abs() > TELLING_DEVIATIONS * deviation)
}

impl Placed {
    /// Whether a zero or the mount differs from the description.
    pub fn differs(&self) -> bool {
        self.zeros.iter().chain([&self.tilt]).any(tells)
    }

    /// Whether no zero is far away.
    pub(super) fn is_near(&self) -> bool {
        !self.zeros.iter().any(|told| tells(told) && told.is_some_and(|(zero, _)| zero.abs() > FAR))
    }

    /// The lines that hold what was found, the mount before the zeros.
    pub fn remedy(&self) -> String {
        let mount = tells(&self.tilt).then(|| mounted(self.base));
        mount.into_iter().chain(self.held.clone()).collect::<Vec<_>>().join("; and ")
    }
}
