//! The dynamics that a simulation needs: the inertia matrix A, and the torque h without acceleration.
//!
//! tau = A(q) ddq + h(q, dq), without friction; h holds the centrifugal, Coriolis and gravity torques. They can be computed from
//! any [`Regressor`] with parameter values X, because Y(q, dq, ddq) is linear in ddq: h = Y(q, dq, 0) X, and column k of A is
//! (Y(q, dq, e_k) - Y(q, dq, 0)) X, with the unit vector e_k.

use linear_model::regressor::Regressor;

use crate::motion::reference_motion::Reference;

/// Computes the inertia matrix and the bias torque (Coriolis, centrifugal, gravity) of a robot.
pub trait Dynamics: Sync {
    /// Number of coordinates of the robot.
    fn n_coordinates(&self) -> usize;

    /// Writes the inertia matrix A (n x n, row by row, kg m^2) and the bias torque h (n entries, N m) at q (rad), dq (rad/s).
    fn fill(&self, q: &[f64], dq: &[f64], inertia: &mut [f64], bias: &mut [f64]);

    /// Writes the inertia matrix and the bias torque of several states (q, dq), one state after the other.
    fn fill_each(&self, states: &[(&[f64], &[f64])], inertia: &mut [f64], bias: &mut [f64]) {
        let n = self.n_coordinates();
        let room = inertia.chunks_exact_mut((n * n).max(1)).zip(bias.chunks_exact_mut(n.max(1)));
        states.iter().zip(room).for_each(|((q, dq), (inertia, bias))| self.fill(q, dq, inertia, bias));
    }
}

/// The dynamics computed from a regressor and values of its base parameters.
pub struct RegressorDynamics<'a> {
    regressor: &'a dyn Regressor,
    parameters: Vec<f64>,
}

impl<'a> RegressorDynamics<'a> {
    /// Makes the dynamics. `parameters`: one value per column of the regressor; missing values count as zero.
    pub fn new(regressor: &'a dyn Regressor, mut parameters: Vec<f64>) -> RegressorDynamics<'a> {
        parameters.resize(regressor.parameters().len(), 0.0);
        RegressorDynamics { regressor, parameters }
    }
}

impl Dynamics for RegressorDynamics<'_> {
    fn n_coordinates(&self) -> usize {
        self.regressor.coordinates().len()
    }

    fn fill(&self, q: &[f64], dq: &[f64], inertia: &mut [f64], bias: &mut [f64]) {
        let (n, p) = (self.n_coordinates(), self.parameters.len());
        let mut y = vec![0.0; n * p];
        let mut ddq = vec![0.0; n];
        let row = |y: &[f64], i: usize| y[i * p..(i + 1) * p].iter().zip(&self.parameters).map(|(y, x)| y * x).sum();
        self.regressor.fill(q, dq, &ddq, &mut y);
        // The torque without acceleration (bias torque) is h = Y(q, dq, 0) X; Y: regressor, X: parameters.
        for i in 0..n {
            bias[i] = row(&y, i);
        }
        // Column k of the inertia matrix is Y(q, dq, e_k) X - h. Y: regressor; X: parameters; e_k: unit vector; h: bias torque.
        for k in 0..n {
            ddq[k] = 1.0;
            self.regressor.fill(q, dq, &ddq, &mut y);
            ddq[k] = 0.0;
            for i in 0..n {
                let torque: f64 = row(&y, i);
                inertia[i * n + k] = torque - bias[i];
            }
        }
    }
}

/// Number of instants at which the dynamics are evaluated in one call.
const INSTANTS_PER_CALL: usize = 64;

/// The torque A(q) ddq + h(q, dq) along a reference motion (N m) as `[coordinate][instant]`. A: inertia matrix; h: bias torque.
pub fn torques(dynamics: &dyn Dynamics, reference: &Reference) -> Vec<Vec<f64>> {
    let (n, count) = (dynamics.n_coordinates(), reference.q.first().map_or(0, Vec::len));
    let (mut inertia, mut bias) = (vec![0.0; INSTANTS_PER_CALL * n * n], vec![0.0; INSTANTS_PER_CALL * n]);
    let mut found = vec![Vec::with_capacity(count); n];
    let at = |series: &[Vec<f64>], i: usize| series.iter().map(|x| x[i]).collect::<Vec<f64>>();
    for first in (0..count).step_by(INSTANTS_PER_CALL) {
        let instants = first..count.min(first + INSTANTS_PER_CALL);
        let states: Vec<(Vec<f64>, Vec<f64>)> =
            instants.clone().map(|i| (at(&reference.q, i), at(&reference.dq, i))).collect();
        let asked: Vec<(&[f64], &[f64])> = states.iter().map(|(q, dq)| (&q[..], &dq[..])).collect();
        let m = asked.len();
        dynamics.fill_each(&asked, &mut inertia[..m * n * n], &mut bias[..m * n]);
        for (k, i) in instants.enumerate() {
            let ddq = at(&reference.ddq, i);
            let (a, h) = (&inertia[k * n * n..][..n * n], &bias[k * n..][..n]);
            for (row, series) in found.iter_mut().enumerate() {
                series.push(h[row] + a[row * n..(row + 1) * n].iter().zip(&ddq).map(|(a, x)| a * x).sum::<f64>());
            }
        }
    }
    found
}

/// The torque Y(q, dq, ddq) X at one state, N m, one entry per coordinate. Y: regressor; X: `parameters`.
pub fn torque(regressor: &dyn Regressor, parameters: &[f64], q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<f64> {
    let (n, p) = (regressor.coordinates().len(), regressor.parameters().len());
    let mut y = vec![0.0; n * p];
    regressor.fill(q, dq, ddq, &mut y);
    y.chunks_exact(p.max(1)).map(|row| row.iter().zip(parameters).map(|(y, x)| y * x).sum()).collect()
}

/// The torque Y X along a reference motion, N m, one series per coordinate. Y: regressor; X: `parameters`.
pub fn inverse_dynamics(regressor: &dyn Regressor, parameters: &[f64], reference: &Reference) -> Vec<Vec<f64>> {
    let n = reference.q.len();
    let mut series = vec![Vec::new(); n];
    let at = |x: &[Vec<f64>], i: usize| x.iter().map(|x| x[i]).collect::<Vec<f64>>();
    for i in 0..reference.q.first().map_or(0, Vec::len) {
        let tau = torque(regressor, parameters, &at(&reference.q, i), &at(&reference.dq, i), &at(&reference.ddq, i));
        series.iter_mut().zip(tau).for_each(|(s, t)| s.push(t));
    }
    series
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A mass on a rail without gravity; the number is the mass, kg.
    pub(crate) struct Mass(pub(crate) f64);

    impl Dynamics for Mass {
        fn n_coordinates(&self) -> usize {
            1
        }

        fn fill(&self, _: &[f64], _: &[f64], inertia: &mut [f64], bias: &mut [f64]) {
            (inertia[0], bias[0]) = (self.0, 0.0);
        }
    }
}
