//! Helpers for unit tests: the pendulum and the candidates of `experiments`, and a control loop for the pendulum.

use experiments::motion::profile::Profile;
use experiments::plan::candidates::{CandidateGrid, MotionLimits};
use linear_model::friction::terms::sign;
use linear_model::states::States;

use numerics::information_matrix::WeightedRows;
use random::Random;

use crate::simulated_loop::Simulator;
pub(crate) use pendulum::Pendulum;

#[path = "../../../experiments/src/pendulum.rs"]
mod pendulum;
#[path = "../../../experiments/src/plan/test_plans.rs"]
pub(crate) mod test_plans;
#[path = "../../../identification/src/test_states.rs"]
mod test_states;

/// The pendulum with a stiff PD controller. The reference has two harmonics, and the sampling period is 10 ms.
pub(crate) struct Loop {
    pub samples: usize,
}

impl Simulator for Loop {
    fn simulate(&self, x: &[f64]) -> Result<States, logs::Error> {
        // The equation of motion is ZZ ddq + 9.81 (MX cos q - MY sin q) = tau, with the inertia ZZ and the first moments MX, MY.
        // tau is the torque of the PD controller.
        let (zz, mx, my) = (x[0], x[1], x[2]);
        let gravity = |q: f64| 9.81 * (mx * q.cos() - my * q.sin());
        let reference =
            |t: f64| ((2.0 * t).sin() + 0.3 * (5.1 * t).cos(), 2.0 * (2.0 * t).cos() - 1.53 * (5.1 * t).sin());
        let control = |t: f64, q: f64, dq: f64| {
            let (r, dr) = reference(t);
            400.0 * (r - q) + 20.0 * (dr - dq)
        };
        let (mut q, mut dq) = reference(0.0);
        let mut states = States { n: 1, period: 0.01, ..States::default() };
        for i in 0..self.samples {
            let t = 0.01 * i as f64;
            let tau = control(t, q, dq);
            // Stores a sample: the state, and ddq from the equation of motion.
            states.t.push(t);
            states.q.push(q);
            states.dq.push(dq);
            states.direction.push(sign(dq));
            states.ddq.push((tau - gravity(q)) / zz);
            states.tau.push(tau);
            states.used.push(true);
            // Integrates by the Runge-Kutta method of order 4, with twenty steps per sample.
            let steps = 20;
            let h = 0.01 / f64::from(steps);
            for k in 0..steps {
                let t = t + h * f64::from(k);
                let f = |t: f64, q: f64, dq: f64| (dq, (control(t, q, dq) - gravity(q)) / zz);
                let a = f(t, q, dq);
                let b = f(t + 0.5 * h, q + 0.5 * h * a.0, dq + 0.5 * h * a.1);
                let c = f(t + 0.5 * h, q + 0.5 * h * b.0, dq + 0.5 * h * b.1);
                let d = f(t + h, q + h * c.0, dq + h * c.1);
                q += h / 6.0 * (a.0 + 2.0 * b.0 + 2.0 * c.0 + d.0);
                dq += h / 6.0 * (a.1 + 2.0 * b.1 + 2.0 * c.1 + d.1);
            }
        }
        Ok(states)
    }
}
