//! A pendulum on a cart-free pivot with rotor: the smallest arm that has everything, for tests.

use crate::regressor::Regressor;
use crate::signal::States;

/// tau = ZZ ddq + MX g cos q + MY g (-sin q).
pub struct Pendulum {
    coordinates: Vec<String>,
    parameters: Vec<String>,
    pub truth: [f64; 3],
}

impl Pendulum {
    pub fn new() -> Pendulum {
        Pendulum {
            coordinates: vec!["q1".into()],
            parameters: vec!["ZZ1".into(), "MX1".into(), "MY1".into()],
            truth: [0.3, 0.8, -0.1],
        }
    }

    /// Noise-free states of two harmonics, ten milliseconds apart.
    pub fn states(&self, len: usize) -> States {
        let mut states = States { n: 1, period: 0.01, ..States::default() };
        for r in 0..len {
            let t = 0.01 * r as f64;
            let (w1, w2) = (2.0, 5.1);
            let q = (w1 * t).sin() + 0.3 * (w2 * t).cos();
            let dq = w1 * (w1 * t).cos() - 0.3 * w2 * (w2 * t).sin();
            let ddq = -w1 * w1 * (w1 * t).sin() - 0.3 * w2 * w2 * (w2 * t).cos();
            let mut y = [0.0; 3];
            self.fill(&[q], &[dq], &[ddq], &mut y);
            states.t.push(t);
            states.q.push(q);
            states.dq.push(dq);
            states.ddq.push(ddq);
            states.tau.push(y.iter().zip(self.truth).map(|(a, b)| a * b).sum());
            states.used.push(true);
        }
        states
    }
}

impl Regressor for Pendulum {
    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn parameters(&self) -> &[String] {
        &self.parameters
    }

    fn fill(&self, q: &[f64], _: &[f64], ddq: &[f64], y: &mut [f64]) {
        let (s, c) = q[0].sin_cos();
        y.copy_from_slice(&[ddq[0], 9.81 * c, -9.81 * s]);
    }
}
