//! States of the pendulum, for the unit tests.

use linear_model::friction::terms::sign;
use linear_model::regressor::Regressor;
use linear_model::states::States;

use super::Pendulum;

impl Pendulum {
    /// Noise-free states of a motion with two frequencies, `len` samples at 10 ms.
    pub(crate) fn states(&self, len: usize) -> States {
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
            states.direction.push(sign(dq));
            states.ddq.push(ddq);
            states.tau.push(y.iter().zip(self.truth).map(|(a, b)| a * b).sum());
            states.used.push(true);
        }
        states
    }
}
