//! Computes the regressor, the torques and the rows of W at the instants of a motion, and their derivatives by the states.
//!
//! Forward: the coefficients x give the states s = (q, dq, ddq) at each instant, rad (m), s. The states give the torques tau =
//! Y X (N m or N) at all instants (Y: regressor, X: its parameters), and the rows W = [Y, friction] / noise at the instants of
//! a period. Backward, from the derivatives of a function L by tau and W:
//!
//! dL/ds = sum_i dL/dtau_i dtau_i/ds + sum_ic dL/dW_ic dW_ic/ds
//!
//! A small group of states passes through all steps while its data are in the processor cache, because the whole regressor of a
//! chain of thirty joints at all instants exceeds every cache.

use crate::excitation::columns::{SIGN_TURN_SHARE, friction_columns};
use crate::excitation::criterion::CriterionRows;
use crate::excitation::problem::Prepared;
use crate::excitation::torque_barrier::EnforcedDrive;
use linear_model::friction::terms::columns_of;
use processor::in_parallel;

/// Number of states (instants) whose functions and derivatives are computed together in SIMD lanes.
const STATES_PER_GROUP: usize = 8;

/// The rows of the identification matrix W (regressor and friction columns) at all instants of a period.
pub(super) struct RegressorRows {
    /// The rows of W, separately for each moving coordinate.
    pub(super) of_joints: Vec<CriterionRows>,
    /// For each moving coordinate: its friction columns as [value, derivative by dq, derivative by ddq], instant after instant.
    pub(super) friction: Vec<Vec<[f64; 3]>>,
}

impl Prepared<'_> {
    /// Number of entries of the regressor Y of one state.
    fn entries(&self) -> usize {
        self.problem.limits.len() * self.problem.regressor.parameters().len()
    }

    /// The states (q, dq, ddq) of a motion at these instants, one after the other. x: scaled coefficients of the motion.
    pub(super) fn states_at(&self, instants: &[[Vec<f64>; 3]], x: &[f64]) -> Vec<f64> {
        let mut states = vec![0.0; instants.len() * self.state_width()];
        self.fill_states(instants, &self.by_coefficient(x), &mut states);
        states
    }

    /// The coefficients of a motion in their own units, from its scaled coefficients x. They are ordered by coefficient, then by
    /// moving coordinate, so that SIMD lanes process several coordinates at once.
    fn by_coefficient(&self, x: &[f64]) -> Vec<f64> {
        let (m, moving) = (self.problem.shape.size(), self.moving().len());
        let scaled: Vec<f64> = x.iter().zip(self.scale()).map(|(x, scale)| x * scale).collect();
        (0..m * moving).map(|at| scaled[at % moving * m + at / moving]).collect()
    }

    fn fill_states(&self, instants: &[[Vec<f64>; 3]], coefficients: &[f64], states: &mut [f64]) {
        let (n, moving) = (self.problem.limits.len(), self.moving());
        let mut of_moving = vec![0.0; moving.len()];
        for (rows, state) in instants.iter().zip(states.chunks_exact_mut(3 * n)) {
            for (k, limits) in self.problem.limits.iter().enumerate() {
                state[k] = limits.locked.unwrap_or(0.0);
            }
            for (d, row) in rows.iter().enumerate() {
                of_moving.fill(0.0);
                for (b, coefficients) in row.iter().zip(coefficients.chunks_exact(moving.len())) {
                    of_moving.iter_mut().zip(coefficients).for_each(|(sum, x)| *sum += b * x);
                }
                moving.iter().zip(&of_moving).for_each(|(k, x)| state[d * n + k] = *x);
            }
        }
    }

    /// The states (q, dq, ddq) of a motion at all its instants, and the torques Y X of each coordinate without friction, N m (N).
    /// x: scaled coefficients of the motion. Without a torque barrier the torques are zero.
    pub(super) fn states_and_torques(&self, x: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (width, n) = (self.state_width(), self.problem.limits.len());
        let coefficients = self.by_coefficient(x);
        let mut states = vec![0.0; self.instants.len() * width];
        let mut rigid = vec![0.0; self.instants.len() * n];
        let count = self.states_of_a_thread(&states);
        let parts = self.instants.chunks(count).zip(states.chunks_mut(count * width)).zip(rigid.chunks_mut(count * n));
        in_parallel(parts.collect(), self.threads, |((instants, states), rigid): ((&[_], &mut [f64]), &mut [f64])| {
            self.fill_states(instants, &coefficients, states);
            if let Some(torques) = &self.torques {
                torques.fill_many(states, rigid);
            }
        });
        (states, rigid)
    }

    /// The torques Y X (regressor times base parameters, without friction) at these states, one state after the other, N m (N).
    /// Without a torque barrier they are zero.
    pub(super) fn rigid_torques(&self, states: &[f64]) -> Vec<f64> {
        let mut rigid = vec![0.0; states.len() / self.state_width() * self.problem.limits.len()];
        if let Some(torques) = &self.torques {
            torques.fill_many(states, &mut rigid);
        }
        rigid
    }

    /// Derivatives of a function by the states, from `weights`, its derivatives by the torque of each coordinate (reverse mode).
    pub(super) fn torques_pulled_back(&self, states: &[f64], weights: &[f64]) -> Vec<f64> {
        let mut through = vec![0.0; states.len()];
        let Some(torques) = &self.torques else { return through };
        let (width, n) = (self.state_width(), self.problem.limits.len());
        let count = self.states_of_a_thread(states);
        let parts = states.chunks(count * width).zip(weights.chunks(count * n)).zip(through.chunks_mut(count * width));
        in_parallel(parts.collect(), self.threads, |((states, weights), through): ((&[f64], &[f64]), &mut [f64])| {
            torques.pull_back(states, weights, through);
        });
        through
    }

    /// The regressor Y at the instants of a period, one instant after the other. `None` if an entry is not finite.
    pub(super) fn filled(&self, states: &[f64]) -> Option<Vec<f64>> {
        let (width, entries) = (self.state_width(), self.entries());
        let states = self.of_period(states);
        let mut y = vec![0.0; states.len() / width * entries];
        let count = self.states_of_a_thread(states);
        let parts = states.chunks(count * width).zip(y.chunks_mut((count * entries).max(1)));
        let are_finite = in_parallel(parts.collect(), self.threads, |(states, y): (&[f64], &mut [f64])| {
            self.problem.regressor.fill_many(states, y);
            // The loop has no early exit, so that the compiler vectorises it.
            y.iter().fold(true, |are_finite, y| are_finite & y.is_finite())
        });
        are_finite.into_iter().all(|is_finite| is_finite).then_some(y)
    }

    /// The rows of the identification matrix W (regressor and friction columns) of each moving coordinate, at the instants of a
    /// period. `y`: regressor at these instants.
    pub(super) fn rows(&self, states: &[f64], y: &[f64]) -> RegressorRows {
        let problem = self.problem;
        let (n, b) = (problem.limits.len(), problem.regressor.parameters().len());
        let of_joint = |(base, &i): (&Vec<(usize, usize)>, &usize)| {
            let mut rows = CriterionRows::new(base.iter().chain(&self.own[i]).map(|(_, at)| *at).collect());
            let columns = columns_of(problem.friction, i);
            let mut friction = vec![[0.0; 3]; columns * problem.samples];
            let turn = SIGN_TURN_SHARE * problem.limits[i].reachable_velocity();
            for (r, (state, y)) in states.chunks_exact(3 * n).zip(y.chunks_exact(n * b)).enumerate() {
                let friction = &mut friction[r * columns..][..columns];
                friction_columns(problem.friction, i, state[n + i], state[2 * n + i], turn, friction);
                let noise = problem.noise[i];
                let of_friction = self.own[i].iter().map(|&(t, _)| friction[t][0] / noise);
                rows.push(base.iter().map(|&(c, _)| y[i * b + c] / noise).chain(of_friction));
            }
            (rows, friction)
        };
        let joints: Vec<(&Vec<(usize, usize)>, &usize)> = self.base.iter().zip(self.moving()).collect();
        let (of_joints, friction) = in_parallel(joints, self.threads, of_joint).into_iter().unzip();
        RegressorRows { of_joints, friction }
    }

    /// The criterion J of the motion with the scaled coefficients x. `None` if its regressor rows do not have full rank.
    pub(crate) fn criterion(&self, x: &[f64]) -> Option<f64> {
        let (states, _) = self.states_and_torques(x);
        let RegressorRows { of_joints, .. } = self.rows(&states, &self.filled(&states)?);
        Some(self.criterion_of_rows(of_joints)?.value)
    }

    /// Derivatives of the criterion J by the states of a period, in reverse mode. `rows`: rows of the identification matrix W
    /// with the derivatives of J by their entries.
    pub(super) fn rows_pulled_back(&self, states: &[f64], rows: &RegressorRows) -> Vec<f64> {
        let (width, entries) = (self.state_width(), self.entries());
        let states = self.of_period(states);
        let mut through = vec![0.0; states.len()];
        let count = self.states_of_a_thread(states);
        let parts = states.chunks(count * width).zip(through.chunks_mut(count * width)).enumerate().collect();
        in_parallel(parts, self.threads, |(part, (states, through)): (usize, (&[f64], &mut [f64]))| {
            let mut weights = vec![0.0; STATES_PER_GROUP * entries];
            let groups = states.chunks(STATES_PER_GROUP * width).zip(through.chunks_mut(STATES_PER_GROUP * width));
            for (group, (states, through)) in groups.enumerate() {
                let first = part * count + group * STATES_PER_GROUP;
                let weights = &mut weights[..states.len() / width * entries];
                weights.fill(0.0);
                self.add_row_slopes(rows, first, weights);
                self.problem.regressor.pull_back(states, weights, through);
                self.add_friction_slopes(rows, first, through);
            }
        });
        through
    }

    /// Adds to `weights` (the derivatives of the criterion J by the entries of the regressor Y) the derivatives by the rows of W,
    /// for the states of a group. `first`: number of the first state of the group.
    fn add_row_slopes(&self, rows: &RegressorRows, first: usize, weights: &mut [f64]) {
        let (n, b) = (self.problem.limits.len(), self.problem.regressor.parameters().len());
        for ((joint, &i), base) in rows.of_joints.iter().zip(self.moving()).zip(&self.base) {
            for (&(c, _), slopes) in base.iter().zip(joint.slopes(first).into_iter().flatten()) {
                let place = slopes.iter().enumerate();
                place.for_each(|(r, slope)| weights[(r * n + i) * b + c] += slope / self.problem.noise[i]);
            }
        }
    }

    /// Adds to `through` the derivatives of the criterion J by the states that come from the friction columns, for the states of
    /// a group. `first`: number of the first state of the group.
    fn add_friction_slopes(&self, rows: &RegressorRows, first: usize, through: &mut [f64]) {
        let n = self.problem.limits.len();
        for (j, (joint, &i)) in rows.of_joints.iter().zip(self.moving()).enumerate() {
            let columns = columns_of(self.problem.friction, i);
            let of_own = joint.slopes(first).into_iter().flatten().skip(self.base[j].len());
            for (&(t, _), slopes) in self.own[i].iter().zip(of_own) {
                for (r, slope) in slopes.iter().enumerate() {
                    let [_, along_dq, along_ddq] = rows.friction[j][(first + r) * columns + t];
                    through[r * 3 * n + n + i] += slope / self.problem.noise[i] * along_dq;
                    through[r * 3 * n + 2 * n + i] += slope / self.problem.noise[i] * along_ddq;
                }
            }
        }
    }

    /// The gradient of each torque or power in `held` by the coefficients of the motion, one after the other.
    pub(super) fn drive_slopes(&self, states: &[f64], held: &[EnforcedDrive]) -> Vec<f64> {
        let (n, width) = (self.problem.limits.len(), self.state_width());
        let at: Vec<f64> = held.iter().flat_map(|held| &states[held.instant * width..][..width]).copied().collect();
        let mut weights = vec![0.0; held.len() * n];
        held.iter().zip(weights.chunks_exact_mut(n)).for_each(|(held, w)| w[held.coordinate] = held.along[0]);
        let mut through = if held.is_empty() { vec![] } else { self.torques_pulled_back(&at, &weights) };
        let mut slopes = vec![0.0; held.len() * self.size()];
        let rows = slopes.chunks_exact_mut(self.size()).zip(through.chunks_exact_mut(width));
        for (held, (slopes, through)) in held.iter().zip(rows) {
            through[n + held.coordinate] += held.along[1];
            self.add_slopes(&self.instants[held.instant], through, slopes);
        }
        slopes
    }

    /// The part of `states` at the instants of the period, without the blends (motions from rest and to rest).
    fn of_period<'s>(&self, states: &'s [f64]) -> &'s [f64] {
        &states[..states.len().min(self.problem.samples * self.state_width())]
    }

    /// Number of entries of one state (q, dq, ddq) of all coordinates.
    fn state_width(&self) -> usize {
        3 * self.problem.limits.len()
    }

    /// Number of states that each thread processes, a multiple of the group size.
    fn states_of_a_thread(&self, states: &[f64]) -> usize {
        let count = states.len() / self.state_width().max(1);
        count.div_ceil(self.threads.max(1)).max(1).next_multiple_of(STATES_PER_GROUP)
    }
}
