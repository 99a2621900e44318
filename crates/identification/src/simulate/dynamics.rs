//! A robot as simulation sees it: the inertia matrix, and the torque without acceleration.
//!
//! tau = A(q) ddq + h(q, dq), friction not included; h holds the centrifugal, Coriolis and gravity
//! torques. Any [`Regressor`] with parameter values is such a robot: with Y(q, dq, ddq) linear in
//! ddq, h = Y(q, dq, 0) X and column k of A is (Y(q, dq, e_k) - Y(q, dq, 0)) X.

use crate::experiments::exciting_trajectory::Reference;
use crate::model::regressor::Regressor;

/// Inertia matrix and bias torque of a robot.
pub trait Dynamics: Sync {
    /// Number of coordinates.
    fn n_coordinates(&self) -> usize;

    /// Writes A (n x n, row by row, kg m^2) and h (n, N m) at q (rad), dq (rad/s).
    fn fill(&self, q: &[f64], dq: &[f64], inertia: &mut [f64], bias: &mut [f64]);
}

/// The dynamics of a regressor with given base parameters.
pub struct RegressorDynamics<'a> {
    regressor: &'a dyn Regressor,
    parameters: Vec<f64>,
}

impl<'a> RegressorDynamics<'a> {
    /// `parameters`: one value a column of the regressor; missing ones count as zero.
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
        for i in 0..n {
            bias[i] = row(&y, i);
        }
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

/// tau = Y(q, dq, ddq) X at one instant, N m.
pub fn torque(regressor: &dyn Regressor, parameters: &[f64], q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<f64> {
    let (n, p) = (regressor.coordinates().len(), regressor.parameters().len());
    let mut y = vec![0.0; n * p];
    regressor.fill(q, dq, ddq, &mut y);
    y.chunks_exact(p.max(1)).map(|row| row.iter().zip(parameters).map(|(y, x)| y * x).sum()).collect()
}

/// Torque of the model along a reference, N m, one series a coordinate.
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
mod tests {
    use super::*;
    use crate::algebra::positive_definite::solve_positive;
    use crate::tree_robot::TreeRobot;

    #[test]
    fn regressor_and_recursion_agree() {
        let robot = TreeRobot::r3(true);
        let by_regressor = RegressorDynamics::new(&robot, robot.truth.clone());
        let (q, dq) = ([0.3, -0.7, 1.1], [0.9, -1.3, 0.4]);
        let (mut a, mut h, mut b, mut g) = ([0.0; 9], [0.0; 3], [0.0; 9], [0.0; 3]);
        by_regressor.fill(&q, &dq, &mut a, &mut h);
        Dynamics::fill(&robot, &q, &dq, &mut b, &mut g);
        // Torques of some 10 N m carried through the regrouping, found numerically to 1e-11.
        for (x, y) in a.iter().zip(&b).chain(h.iter().zip(&g)) {
            assert!((x - y).abs() < 1e-9, "{x} {y}");
        }
        assert!((a[1] - a[3]).abs() < 1e-12 && a[0] > 0.0);
    }

    #[test]
    fn base_parameters_of_the_benchmark() {
        let robot = TreeRobot::r3(true);
        let names = "ZZ1 XX2 XY2 XZ2 YZ2 ZZ2 MX2 MY2 XX3 XY3 XZ3 YZ3 ZZ3 MX3 MY3";
        let found: Vec<String> = robot.parameters().iter().map(|p| p.name.to_string()).collect();
        assert_eq!(found.join(" "), names);
        let values = [
            0.29288, -0.09336, -0.00070, 0.00200, 0.00004, 0.09814, 0.40000, 0.01200, -0.05673, 0.00260, 0.00630,
            0.00084, 0.06277, 0.24000, -0.01800,
        ];
        // The table is printed to five decimals.
        for (x, v) in robot.truth.iter().zip(values) {
            assert!((x - v).abs() < 6e-6, "{x} {v}");
        }
        assert_eq!(TreeRobot::r3(false).parameters().len(), 13);
    }

    #[test]
    fn solves_a_positive_system() {
        let (mut a, mut b) = ([4.0, 1.0, 1.0, 3.0], [1.0, 2.0]);
        assert!(solve_positive(&mut a, &mut b));
        assert!((b[0] - 1.0 / 11.0).abs() < 1e-15 && (b[1] - 7.0 / 11.0).abs() < 1e-15);
        assert!(!solve_positive(&mut [-1.0], &mut [1.0]));
    }
}
