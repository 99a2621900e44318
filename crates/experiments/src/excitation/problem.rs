//! What is asked of a motion, and the rows of an identification as a function of its coefficients.
//!
//! The state at an instant is linear in the coefficients x, scaled joint after joint. Rows are over the noise of their joint;
//! locked joints have none.

use std::sync::Arc;

use linear_model::differentiable::{DifferentiableRegressor, DifferentiableTorques};
use linear_model::friction::terms::{FrictionTerm, columns_before, columns_of};

use crate::excitation::barrier::Barrier;
use crate::excitation::criterion::{Aim, Criterion, JointRows, criterion};
use crate::excitation::gap_proof::Surroundings;
use crate::excitation::limits::{CoordinateLimits, LimitKind};
use crate::excitation::motion::Shape;
use crate::excitation::space_wall::{Seen, SpaceWall};
use crate::excitation::torque_wall::TorqueWall;

/// What is asked of a motion.
#[derive(Clone)]
pub struct Problem<'a> {
    /// The base regressor with its derivatives.
    pub regressor: &'a dyn DifferentiableRegressor,
    /// Friction columns of every joint.
    pub friction: &'a [FrictionTerm],
    /// One per coordinate.
    pub limits: &'a [CoordinateLimits],
    /// N m (N) a sample, one per coordinate.
    pub noise: &'a [f64],
    /// The aim of the search.
    pub aim: Aim,
    /// The limits of torque and power, where there are any.
    pub torque: Option<&'a TorqueWall>,
    /// Which columns count.
    pub columns: &'a [bool],
    /// What the motion is a sum of.
    pub shape: Shape,
    /// Instants a period at which limits and information are looked at.
    pub samples: usize,
    /// The distances that bodies must keep, where the description has any.
    pub surroundings: Option<&'a dyn Surroundings>,
    /// Rows of information that is known already, over all columns of the model, as a share of one sample of the
    /// motion.
    pub prior: &'a [f64],
}

/// Instants in a blend at which torques are looked at.
pub(super) const TORQUE_INSTANTS_PER_BLEND: usize = 16;

/// A problem with what every evaluation needs.
#[derive(Clone)]
pub struct Prepared<'a> {
    pub(super) problem: &'a Problem<'a>,
    barrier: Barrier,
    /// Coordinates that move.
    moving: Vec<usize>,
    /// Unit of each scaled coefficient, joint after joint.
    scale: Vec<f64>,
    /// q, dq, ddq at each instant per unit of the coefficients: those of the period, then those of the blends.
    pub(super) instants: Vec<[Vec<f64>; 3]>,
    /// What the bounds of torques and powers are times, one per instant.
    reliefs: Vec<f64>,
    /// By moving coordinate: the base columns that count and are not zero in its rows, as (place in Y, place in W).
    pub(super) base: Vec<Vec<(usize, usize)>>,
    /// By coordinate: its friction columns that count, as (place among its own, place in W).
    pub(super) own: Vec<Vec<(usize, usize)>>,
    /// The torques of the wall, where there is one.
    pub(super) torques: Option<Arc<dyn DifferentiableTorques + 'a>>,
    /// Threads of an evaluation; its result does not depend on them.
    pub(super) threads: usize,
    /// Columns of W.
    p: usize,
    /// The wall of the distances between bodies.
    pub(super) space: Option<SpaceWall<'a>>,
    /// What is known already as rows below those of the S instants, p wide.
    prior: Vec<f64>,
}

impl<'a> Prepared<'a> {
    /// Computes what all starts share.
    pub fn new(problem: &'a Problem<'a>) -> Prepared<'a> {
        let shape = &problem.shape;
        let moving: Vec<usize> = (0..problem.limits.len()).filter(|&k| problem.limits[k].locked.is_none()).collect();
        let limits: Vec<&CoordinateLimits> = moving.iter().map(|&k| &problem.limits[k]).collect();
        // Rows that give q, dq and ddq from the coefficients: N instants of the period, more of the blends.
        let of_blends = (0..TORQUE_INSTANTS_PER_BLEND).map(|i| i as f64 / (TORQUE_INSTANTS_PER_BLEND - 1) as f64);
        let [q, dq, ddq] = [0, 1, 2].map(|k| shape.rows(k, problem.samples, of_blends.clone()));
        let instants: Vec<[Vec<f64>; 3]> = q.into_iter().zip(dq).zip(ddq).map(|((q, dq), ddq)| [q, dq, ddq]).collect();
        let (n, base) = (problem.limits.len(), problem.regressor.parameters().len());
        // The columns that can be told apart, numbered anew: base parameters, then friction joint by joint.
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
            space: problem.surroundings.map(|s| SpaceWall::new(s, shape)),
            problem,
        }
    }

    /// The same, whose evaluations share so many threads.
    pub(super) fn with_threads(self, threads: usize) -> Prepared<'a> {
        Prepared { threads, ..self }
    }

    /// The barrier of the limits.
    pub fn barrier(&self) -> &Barrier {
        &self.barrier
    }

    /// Coordinates that move.
    pub fn moving(&self) -> &[usize] {
        &self.moving
    }

    /// Columns that count.
    pub fn p(&self) -> usize {
        self.p
    }

    /// Unit of each scaled coefficient, joint after joint.
    pub(super) fn scale(&self) -> &[f64] {
        &self.scale
    }

    /// Coefficients of all coordinates that move.
    pub(super) fn size(&self) -> usize {
        self.scale.len()
    }

    /// What the bounds of torques and powers are times, one per instant.
    pub(super) fn reliefs(&self) -> &[f64] {
        &self.reliefs
    }

    /// Looks at torques at these instants too, each with what its bounds are times.
    pub(super) fn watch(&mut self, instants: impl IntoIterator<Item = ([Vec<f64>; 3], f64)>) {
        for (rows, relief) in instants {
            self.instants.push(rows);
            self.reliefs.push(relief);
        }
    }

    /// From the slopes along q, dq, ddq of each coordinate at an instant to those along the coefficients, which are added.
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

    /// The coefficients of every coordinate.
    pub fn joints(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let m = self.m();
        let rest = |l: &CoordinateLimits| [&[l.locked.unwrap_or(0.0)][..], &vec![0.0; m - 1]].concat();
        let mut joints: Vec<Vec<f64>> = self.problem.limits.iter().map(rest).collect();
        for ((&k, x), scale) in self.moving.iter().zip(x.chunks_exact(m)).zip(self.scale.chunks_exact(m)) {
            joints[k] = x.iter().zip(scale).map(|(x, s)| x * s).collect();
        }
        joints
    }

    /// The scaled coefficients of a motion.
    pub fn scaled(&self, joints: &[Vec<f64>]) -> Vec<f64> {
        let all = self.moving.iter().flat_map(|&k| &joints[k]);
        all.zip(&self.scale).map(|(x, s)| x / s).collect()
    }

    /// The positions of all coordinates of the motion x, by a row of the basis.
    pub(super) fn positions(&self, x: &[f64], row: &[f64]) -> Vec<f64> {
        let m = self.m();
        let mut q: Vec<f64> = self.problem.limits.iter().map(|l| l.locked.unwrap_or(0.0)).collect();
        for (j, &k) in self.moving.iter().enumerate() {
            let terms = row.iter().zip(&x[j * m..]).zip(&self.scale[j * m..]);
            q[k] = terms.map(|((b, x), s)| b * x * s).sum();
        }
        q
    }

    /// The least room between bodies above its bound, m, with its gap, where any come near.
    pub fn nearest(&self, seen: &Seen, x: &[f64]) -> Option<(f64, usize)> {
        self.space.as_ref()?.nearest(seen, &|row| self.positions(x, row))
    }

    /// Whether such a room is enough to begin a descent with.
    pub fn is_inside(&self, nearest: Option<(f64, usize)>) -> bool {
        self.space.as_ref().is_none_or(|space| space.is_inside(nearest))
    }

    /// The least room at the centre of the motion alone.
    pub fn nearest_at_centre(&self, x: &[f64]) -> Option<(f64, usize)> {
        let mut nearest = None;
        self.space.as_ref()?.nearest_at(&self.positions(x, &[1.0]), &mut None, &mut nearest);
        nearest
    }

    /// Adds a slope along a row of the basis to the gradient along the coefficients of the j-th moving coordinate.
    pub(super) fn add_slope(&self, j: usize, row: &[f64], slope: f64, gradient: &mut [f64]) {
        let m = self.m();
        let place = gradient[j * m..][..m].iter_mut().zip(row).zip(&self.scale[j * m..]);
        place.for_each(|((g, b), s)| *g += slope * b * s);
    }

    /// The greatest torque or power of the motion x over its bound, with its coordinate and limit, where there are bounds.
    pub fn greatest_torque(&self, x: &[f64]) -> Option<(f64, usize, LimitKind)> {
        let wall = self.problem.torque?;
        let (states, rigid) = self.states_and_torques(x);
        wall.greatest(self.problem.limits, &states, &rigid)
    }

    /// J of the rows of motions, together with what is known; `None` where they have not full rank.
    pub(super) fn criterion_of_rows(&self, rows: Vec<JointRows>) -> Option<Criterion> {
        criterion(self.problem.aim, rows, &self.prior, self.p, self.problem.samples, self.threads)
    }
}

/// The rows of what is known in the columns that count, scaled to as many samples as there are instants.
fn known_rows(problem: &Problem) -> Vec<f64> {
    let factor = (problem.samples as f64).sqrt();
    let rows = problem.prior.chunks_exact(problem.columns.len().max(1));
    rows.flat_map(|row| row.iter().zip(problem.columns).filter(|(_, counts)| **counts).map(|(x, _)| factor * x))
        .collect()
}
