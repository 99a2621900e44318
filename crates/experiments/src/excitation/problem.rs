//! What is asked of a motion, and the rows of an identification as a function of its coefficients.
//!
//! The state at an instant is linear in the coefficients x, scaled joint after joint. Rows are over the noise of their joint;
//! locked joints have none.

use linear_model::differentiable::DifferentiableRegressor;
use linear_model::friction::terms::{FrictionTerm, columns_before, columns_of};

use crate::excitation::barrier::Barrier;
use crate::excitation::columns::{SIGN_TURN_SHARE, friction_columns};
use crate::excitation::criterion::{Aim, criterion};
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
const TORQUE_INSTANTS_PER_BLEND: usize = 16;

/// A problem with what every evaluation needs.
pub struct Prepared<'a> {
    pub(super) problem: &'a Problem<'a>,
    barrier: Barrier,
    /// Coordinates that move.
    moving: Vec<usize>,
    /// Unit of each scaled coefficient, joint after joint.
    scale: Vec<f64>,
    /// q, dq, ddq at each instant per unit of the coefficients: those of the period, then those of the blends.
    pub(super) instants: Vec<[Vec<f64>; 3]>,
    /// Base columns that count.
    pub(super) base: Vec<usize>,
    /// By coordinate: its friction columns that count, as (place among its own, place in W).
    pub(super) own: Vec<Vec<(usize, usize)>>,
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
        let instants = q.into_iter().zip(dq).zip(ddq).map(|((q, dq), ddq)| [q, dq, ddq]).collect();
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
        Prepared {
            barrier: Barrier::new(shape, problem.samples, &limits),
            scale: limits.iter().flat_map(|l| shape.units(l)).collect(),
            moving,
            instants,
            base: base_columns,
            own,
            p,
            prior: known_rows(problem),
            space: problem.surroundings.map(|s| SpaceWall::new(s, shape)),
            problem,
        }
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

    /// q, dq, ddq at the instants, one after the other.
    pub(super) fn states(&self, x: &[f64]) -> Vec<f64> {
        let (n, m) = (self.problem.limits.len(), self.m());
        let mut states = vec![0.0; self.instants.len() * 3 * n];
        for (rows, state) in self.instants.iter().zip(states.chunks_exact_mut(3 * n)) {
            for (k, limits) in self.problem.limits.iter().enumerate() {
                state[k] = limits.locked.unwrap_or(0.0);
            }
            for (j, &k) in self.moving.iter().enumerate() {
                for (d, row) in rows.iter().enumerate() {
                    let terms = row.iter().zip(&x[j * m..]).zip(&self.scale[j * m..]);
                    state[d * n + k] = terms.map(|((b, x), s)| b * x * s).sum();
                }
            }
        }
        states
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

    pub(super) fn filled(&self, states: &[f64]) -> Vec<f64> {
        let size = self.problem.limits.len() * self.problem.regressor.parameters().len();
        let mut y = vec![0.0; self.instants.len() * size];
        self.problem.regressor.fill_many(states, &mut y);
        y
    }

    /// The greatest torque or power of the motion x over its bound, with its coordinate and limit, where there are bounds.
    pub fn greatest_torque(&self, x: &[f64]) -> Option<(f64, usize, LimitKind)> {
        let wall = self.problem.torque?;
        let states = self.states(x);
        wall.greatest(self.problem.limits, &states, &self.filled(&states))
    }

    /// The rows of W, p wide, and the slopes of the friction columns.
    ///
    /// The rows are those of the instants of a period, then those of what is known. The slopes are in the order of the
    /// instants, coordinate by coordinate.
    pub(super) fn rows(&self, states: &[f64], y: &[f64]) -> (Vec<f64>, Vec<Vec<[f64; 3]>>) {
        let problem = self.problem;
        let (n, b) = (problem.limits.len(), problem.regressor.parameters().len());
        let samples = problem.samples;
        let mut w = vec![0.0; samples * self.moving.len() * self.p];
        let mut slopes = Vec::with_capacity(samples * self.moving.len());
        let mut rows = w.chunks_exact_mut(self.p.max(1));
        for (state, y) in states.chunks_exact(3 * n).zip(y.chunks_exact(n * b)).take(samples) {
            for &i in &self.moving {
                let mut friction = vec![[0.0; 3]; columns_of(problem.friction, i)];
                let turn = SIGN_TURN_SHARE * problem.limits[i].velocity;
                friction_columns(problem.friction, i, state[n + i], state[2 * n + i], turn, &mut friction);
                if let Some(row) = rows.next() {
                    let noise = problem.noise[i];
                    for (x, &c) in row.iter_mut().zip(&self.base) {
                        *x = y[i * b + c] / noise;
                    }
                    for &(t, at) in &self.own[i] {
                        row[at] = friction[t][0] / noise;
                    }
                }
                slopes.push(friction);
            }
        }
        w.extend(&self.prior);
        (w, slopes)
    }

    /// J of a motion; `None` where its rows have not full rank.
    pub fn criterion(&self, x: &[f64]) -> Option<f64> {
        let states = self.states(x);
        let (w, _) = self.rows(&states, &self.filled(&states));
        Some(criterion(self.problem.aim, w, self.p, self.problem.samples)?.value)
    }
}

/// The rows of what is known in the columns that count, scaled to as many samples as there are instants.
fn known_rows(problem: &Problem) -> Vec<f64> {
    let factor = (problem.samples as f64).sqrt();
    let rows = problem.prior.chunks_exact(problem.columns.len().max(1));
    rows.flat_map(|row| row.iter().zip(problem.columns).filter(|(_, counts)| **counts).map(|(x, _)| factor * x))
        .collect()
}
