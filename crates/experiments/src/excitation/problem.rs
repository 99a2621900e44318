//! The search problem of a motion: the identification matrix W (regressor and friction columns) as a function of the coefficients
//! of the motion.
//!
//! The state (q, dq, ddq) at an instant is linear in the coefficients x, which are scaled and ordered joint after joint. Each row
//! of W is divided by the torque noise of its joint; locked joints have no rows.

use std::sync::Arc;

use linear_model::differentiable::{DifferentiableRegressor, DifferentiableTorques};
use linear_model::friction::terms::{FrictionTerm, columns_before, columns_of};

use crate::excitation::barrier::Barrier;
use crate::excitation::criterion::{Criterion, CriterionRows, SearchObjective, criterion};
use crate::excitation::distance_barrier::{DistanceBarrier, Seen};
use crate::excitation::gap_proof::Surroundings;
use crate::excitation::limits::{CoordinateLimits, LimitKind};
use crate::excitation::motion::MotionShape;
use crate::excitation::torque_barrier::TorqueBarrier;

/// The search problem of a motion: regressor, limits, criterion and basis functions.
#[derive(Clone)]
pub struct Problem<'a> {
    /// The regressor Y of the base parameters, with its derivatives by the state.
    pub regressor: &'a dyn DifferentiableRegressor,
    /// The friction terms that every joint has.
    pub friction: &'a [FrictionTerm],
    /// Limits of each coordinate.
    pub limits: &'a [CoordinateLimits],
    /// Standard deviation of the noise of one torque sample, N m (N), one per coordinate.
    pub noise: &'a [f64],
    /// The criterion that the search optimises.
    pub aim: SearchObjective,
    /// The barrier of the torque and power limits. `None`: they are not limited.
    pub torque: Option<&'a TorqueBarrier>,
    /// For each column of the identification matrix W (regressor and friction columns): whether the criterion includes it.
    pub columns: &'a [bool],
    /// The basis functions of the motion.
    pub shape: MotionShape,
    /// Number of instants in a period at which limits and criterion are evaluated.
    pub samples: usize,
    /// The bodies whose distances are limited. `None`: the description has no bodies.
    pub surroundings: Option<&'a dyn Surroundings>,
    /// Rows of prior information on the parameters (from an earlier identification), one entry per column of W, divided by the
    /// square root of the motion's number of samples. Empty: no prior information.
    pub prior: &'a [f64],
}

/// Number of instants in each blend (motion from rest or to rest) at which torques are evaluated.
pub(super) const TORQUE_INSTANTS_PER_BLEND: usize = 16;

/// A search problem with precomputed data that make its evaluations fast.
#[derive(Clone)]
pub struct Prepared<'a> {
    pub(super) problem: &'a Problem<'a>,
    barrier: Barrier,
    /// Indices of the coordinates that move.
    moving: Vec<usize>,
    /// Unit of each scaled coefficient of the motion (coefficient = scaled coefficient times unit), joint after joint.
    scale: Vec<f64>,
    /// Factors of a joint's coefficients in q, dq and ddq at each instant: first at the instants of the period, then at the
    /// instants of the blends (motions from rest and to rest).
    pub(super) instants: Vec<[Vec<f64>; 3]>,
    /// Factors by which the bounds of torques and powers are temporarily raised, one per instant; 1: not raised.
    reliefs: Vec<f64>,
    /// For each moving coordinate: the base parameters whose columns are included and not zero in its rows, as (column of the
    /// regressor Y, column of the identification matrix W).
    pub(super) base: Vec<Vec<(usize, usize)>>,
    /// For each coordinate: the included friction columns, as (index among the friction columns of the coordinate, column of the
    /// identification matrix W).
    pub(super) own: Vec<Vec<(usize, usize)>>,
    /// The torque function Y X (regressor times base parameters) for the torque barrier. `None` if there is no torque barrier.
    pub(super) torques: Option<Arc<dyn DifferentiableTorques + 'a>>,
    /// Number of threads of an evaluation; it does not change the result.
    pub(super) threads: usize,
    /// Number p of columns of the identification matrix W that the criterion includes.
    p: usize,
    /// The barrier of the distances between bodies. `None` if the description has no bodies.
    pub(super) space: Option<DistanceBarrier<'a>>,
    /// Rows of prior information in the included columns, p entries each. They are appended to the rows of the motion.
    prior: Vec<f64>,
}

impl<'a> Prepared<'a> {
    /// Precomputes the data that all starts (descents from different initial motions) of a search share.
    pub fn new(problem: &'a Problem<'a>) -> Prepared<'a> {
        let shape = &problem.shape;
        let moving: Vec<usize> = (0..problem.limits.len()).filter(|&k| problem.limits[k].locked.is_none()).collect();
        let limits: Vec<&CoordinateLimits> = moving.iter().map(|&k| &problem.limits[k]).collect();
        // Factors of a joint's coefficients in q, dq and ddq: first at the instants of the period, then at the instants of the
        // blends (motions from rest and to rest).
        let of_blends = (0..TORQUE_INSTANTS_PER_BLEND).map(|i| i as f64 / (TORQUE_INSTANTS_PER_BLEND - 1) as f64);
        let [q, dq, ddq] = [0, 1, 2].map(|k| shape.rows(k, problem.samples, of_blends.clone()));
        let instants: Vec<[Vec<f64>; 3]> = q.into_iter().zip(dq).zip(ddq).map(|((q, dq), ddq)| [q, dq, ddq]).collect();
        let (n, base) = (problem.limits.len(), problem.regressor.parameters().len());
        // The included columns of the identification matrix W are renumbered: base parameters first, then friction joint by
        // joint.
        let base_columns: Vec<usize> = (0..base).filter(|&c| problem.columns[c]).collect();
        let mut p = base_columns.len();
        let mut own = vec![Vec::new(); n];
        for (i, own) in own.iter_mut().enumerate() {
            let first = base + columns_before(problem.friction, i);
            for t in 0..columns_of(problem.friction, i) {
                if problem.columns[first + t] {
                    own.push((t, p));
                    p += 1;
                }
            }
        }
        let mut of_rows = vec![vec![]; n];
        for (i, c) in problem.regressor.non_zeros() {
            if let Ok(at) = base_columns.binary_search(&c) {
                of_rows[i].push((c, at));
            }
        }
        let base_of_rows = moving.iter().map(|&i| std::mem::take(&mut of_rows[i])).collect();
        Prepared {
            barrier: Barrier::new(shape, problem.samples, &limits),
            scale: limits.iter().flat_map(|l| shape.units(l)).collect(),
            moving,
            reliefs: vec![1.0; instants.len()],
            instants,
            base: base_of_rows,
            own,
            torques: problem.torque.map(|wall| Arc::from(problem.regressor.torques(&wall.parameters))),
            threads: 1,
            p,
            prior: known_rows(problem),
            space: problem.surroundings.map(|s| DistanceBarrier::new(s, shape)),
            problem,
        }
    }

    /// The prepared problem, with evaluations on `threads` threads.
    pub(super) fn with_threads(self, threads: usize) -> Prepared<'a> {
        Prepared { threads, ..self }
    }

    /// The barrier of the kinematic limits.
    pub fn barrier(&self) -> &Barrier {
        &self.barrier
    }

    /// Indices of the coordinates that move.
    pub fn moving(&self) -> &[usize] {
        &self.moving
    }

    /// Number p of columns of the identification matrix W that the criterion includes.
    pub fn p(&self) -> usize {
        self.p
    }

    /// Unit of each scaled coefficient of the motion (coefficient = scaled coefficient times unit), joint after joint.
    pub(super) fn scale(&self) -> &[f64] {
        &self.scale
    }

    /// Number of coefficients of all moving coordinates together.
    pub(super) fn size(&self) -> usize {
        self.scale.len()
    }

    /// Factors by which the bounds of torques and powers are temporarily raised, one per instant; 1: not raised.
    pub(super) fn reliefs(&self) -> &[f64] {
        &self.reliefs
    }

    /// Adds instants at which torques are evaluated. For each: factors of a joint's coefficients in q, dq, ddq, and the factor by
    /// which the torque bounds are raised.
    pub(super) fn watch(&mut self, instants: impl IntoIterator<Item = ([Vec<f64>; 3], f64)>) {
        for (rows, relief) in instants {
            self.instants.push(rows);
            self.reliefs.push(relief);
        }
    }

    /// Adds derivatives by the coefficients to `gradient` (chain rule). `of_state`: derivatives by q, dq, ddq of each coordinate
    /// at one instant; `rows`: the factors of a joint's coefficients in q, dq, ddq at this instant.
    pub(super) fn add_slopes(&self, rows: &[Vec<f64>; 3], of_state: &[f64], gradient: &mut [f64]) {
        let n = self.problem.limits.len();
        for (j, &k) in self.moving.iter().enumerate() {
            for (d, row) in rows.iter().enumerate() {
                self.add_slope(j, row, of_state[d * n + k], gradient);
            }
        }
    }

    fn m(&self) -> usize {
        self.problem.shape.size()
    }

    /// The coefficients of every coordinate in their own units, from the scaled coefficients x. A locked coordinate has its
    /// constant position as the centre.
    pub fn joints(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let m = self.m();
        let rest = |l: &CoordinateLimits| [&[l.locked.unwrap_or(0.0)][..], &vec![0.0; m - 1]].concat();
        let mut joints: Vec<Vec<f64>> = self.problem.limits.iter().map(rest).collect();
        for ((&k, x), scale) in self.moving.iter().zip(x.chunks_exact(m)).zip(self.scale.chunks_exact(m)) {
            joints[k] = x.iter().zip(scale).map(|(x, s)| x * s).collect();
        }
        joints
    }

    /// The scaled coefficients x of a motion with the coefficients `joints`.
    pub fn scaled(&self, joints: &[Vec<f64>]) -> Vec<f64> {
        let all = self.moving.iter().flat_map(|&k| &joints[k]);
        all.zip(&self.scale).map(|(x, s)| x / s).collect()
    }

    /// The positions of all coordinates at one instant of a motion. x: its scaled coefficients; `row`: factors of a joint's
    /// coefficients in the position at this instant.
    pub(super) fn positions(&self, x: &[f64], row: &[f64]) -> Vec<f64> {
        let m = self.m();
        let mut q: Vec<f64> = self.problem.limits.iter().map(|l| l.locked.unwrap_or(0.0)).collect();
        for (j, &k) in self.moving.iter().enumerate() {
            let terms = row.iter().zip(&x[j * m..]).zip(&self.scale[j * m..]);
            q[k] = terms.map(|((b, x), s)| b * x * s).sum();
        }
        q
    }

    /// The pair of bodies nearest to its bound along the motion with the scaled coefficients x: distance minus bound (m) and
    /// index of the pair (gap). `None` if no bodies are near each other.
    pub fn nearest(&self, seen: &Seen, x: &[f64]) -> Option<(f64, usize)> {
        self.space.as_ref()?.nearest(seen, &|row| self.positions(x, row))
    }

    /// Whether the distance of the nearest pair of bodies is large enough for the start of a descent. `nearest`: from
    /// [`Prepared::nearest`].
    pub fn is_inside(&self, nearest: Option<(f64, usize)>) -> bool {
        self.space.as_ref().is_none_or(|space| space.is_inside(nearest))
    }

    /// The pair of bodies nearest to its bound if all joints are at the centre of the motion with the scaled coefficients x:
    /// distance minus bound (m) and index of the pair (gap).
    pub fn nearest_at_centre(&self, x: &[f64]) -> Option<(f64, usize)> {
        let mut nearest = None;
        self.space.as_ref()?.nearest_at(&self.positions(x, &[1.0]), &mut None, &mut nearest);
        nearest
    }

    /// Adds to `gradient` the derivatives by the coefficients of the j-th moving coordinate. `slope`: derivative by q, dq or ddq;
    /// `row`: factors of a joint's coefficients in this quantity.
    pub(super) fn add_slope(&self, j: usize, row: &[f64], slope: f64, gradient: &mut [f64]) {
        let m = self.m();
        let place = gradient[j * m..][..m].iter_mut().zip(row).zip(&self.scale[j * m..]);
        place.for_each(|((g, b), s)| *g += slope * b * s);
    }

    /// The greatest ratio of a torque or power to its bound over all instants of a motion, with its coordinate and kind of limit.
    /// x: scaled coefficients of the motion. `None` if torques and powers are not limited.
    pub fn greatest_torque(&self, x: &[f64]) -> Option<(f64, usize, LimitKind)> {
        let wall = self.problem.torque?;
        let (states, rigid) = self.states_and_torques(x);
        wall.greatest(self.problem.limits, &states, &rigid)
    }

    /// The criterion J of the regressor rows of a motion, together with the prior information. `None` if the rows do not have
    /// full rank.
    pub(super) fn criterion_of_rows(&self, rows: Vec<CriterionRows>) -> Option<Criterion> {
        criterion(self.problem.aim, rows, &self.prior, self.p, self.problem.samples, self.threads)
    }
}

/// The rows of prior information in the included columns, multiplied by the square root of the number of samples, because the
/// criterion J divides W'W by this number.
fn known_rows(problem: &Problem) -> Vec<f64> {
    let factor = (problem.samples as f64).sqrt();
    let rows = problem.prior.chunks_exact(problem.columns.len().max(1));
    rows.flat_map(|row| row.iter().zip(problem.columns).filter(|(_, counts)| **counts).map(|(x, _)| factor * x))
        .collect()
}
