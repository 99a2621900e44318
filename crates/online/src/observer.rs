//! Observer of the external torque of one joint, by the generalised momentum.
//!
//! ```text
//! dp/dt = tau - friction + b + tau_ext          b = C^T dq - g
//! first order     r = K / (s + K) tau_ext                           [De Luca, Albu-Schaeffer, Haddadin, Hirzinger 2006]
//! second order    r = w^2 / (s^2 + 2 z w s + w^2) tau_ext,  z = 1/sqrt(2)
//! ```
//! Neither accelerations nor the inverse of the inertia matrix are needed. The joints are independent of each other, so each
//! joint has its own observer. The integration is implicit, so it is stable for every gain and period:
//!
//! ```text
//! first order     r' = (r + K (p' - p - known T)) / (1 + K T)
//! second order    v' = (v + w^2 (p' - p - known T - r T)) / (1 + 2 z w T + w^2 T^2),   r' = r + v' T
//! ```
//! T: period; known: mean of tau - friction + b over the period; a prime marks the new value. The same filter applied to the
//! columns of a regressor gives the filtered regressor, for which no acceleration is needed either.

use crate::real::Real;

/// The filter of an observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order<R> {
    /// First order, with its gain K, 1/s: time constant 1/K.
    First(R),
    /// Second order, with its natural frequency w (rad/s) and damping 1/sqrt(2).
    Second(R),
}

/// Observer of the external torque of one joint. External torque is positive if it pushes the joint in its positive direction.
#[derive(Clone, Copy, Debug)]
pub struct Observer<R> {
    order: Order<R>,
    momentum: R,
    known: R,
    torque: R,
    /// Rate of `torque`; used by the second order only.
    slope: R,
    has_started: bool,
}

impl<R: Real> Observer<R> {
    /// Makes an observer that starts at an external torque of zero.
    pub fn new(order: Order<R>) -> Observer<R> {
        let zero = R::ZERO;
        Observer { order, momentum: zero, known: zero, torque: zero, slope: zero, has_started: false }
    }

    /// Starts again at an external torque of zero, for example after a gap of the measurements.
    pub fn reset(&mut self) {
        *self = Observer::new(self.order);
    }

    /// The external torque, N m (N).
    pub fn torque(&self) -> R {
        self.torque
    }

    /// Takes the sample of a cycle and returns the external torque, N m (N). `momentum`: p, kg m^2/s (kg m/s); `known`: torque
    /// of the motor minus friction plus b, N m (N); `period`: time since the previous sample, s.
    ///
    /// A sample that contains NaN or infinity, and a period that is not positive, are not used: the observer starts again with the
    /// next sample.
    pub fn step(&mut self, momentum: R, known: R, period: R) -> R {
        if !(momentum.is_finite() && known.is_finite() && period.is_finite()) {
            self.reset();
            return self.torque;
        }
        if self.has_started && period > R::ZERO {
            let impulse = R::of(0.5) * (known + self.known) * period;
            let unexplained = momentum - self.momentum - impulse;
            match self.order {
                Order::First(gain) => {
                    self.torque = (self.torque + gain * unexplained) / (R::ONE + gain * period);
                }
                Order::Second(w) => {
                    let (step, damping) = (w * period, R::of(core::f64::consts::SQRT_2) * w * period);
                    let driven = self.slope + w * w * (unexplained - self.torque * period);
                    self.slope = driven / (R::ONE + damping + step * step);
                    self.torque = self.torque + self.slope * period;
                }
            }
        }
        (self.momentum, self.known, self.has_started) = (momentum, known, true);
        self.torque
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    extern crate std;

    /// Simulates a pendulum with an observer, by small explicit steps: m l^2 ddq = tau - m g l sin q - f dq + tau_ext.
    fn pendulum(order: Order<f64>, external: impl Fn(f64) -> f64, period: f64) -> std::vec::Vec<(f64, f64)> {
        let (m, l, f) = (2.0, 0.5, 0.3);
        let (mut q, mut dq, mut observer) = (0.4_f64, 0.0_f64, Observer::new(order));
        let mut found = std::vec::Vec::new();
        let inner = 50;
        for k in 0..(1.0 / period) as usize {
            let tau = 3.0 * (5.0 * k as f64 * period).sin();
            let known = tau - f * dq - m * 9.81 * l * q.sin();
            found.push((k as f64 * period, observer.step(m * l * l * dq, known, period)));
            for i in 0..inner {
                let t = (k as f64 + i as f64 / inner as f64) * period;
                let ddq = (tau - m * 9.81 * l * q.sin() - f * dq + external(t)) / (m * l * l);
                dq += ddq * period / inner as f64;
                q += dq * period / inner as f64;
            }
        }
        found
    }

    #[test]
    fn a_step_of_torque_is_seen_as_the_step_response_of_the_filter() {
        let push = |t: f64| if t >= 0.3 { 4.0 } else { 0.0 };
        for (order, response) in [
            (Order::First(50.0), (|t: f64| 1.0 - (-50.0 * t).exp()) as fn(f64) -> f64),
            (Order::Second(80.0), |t| {
                let a = 80.0 / 2.0_f64.sqrt();
                1.0 - (-a * t).exp() * ((a * t).cos() + (a * t).sin())
            }),
        ] {
            for (t, r) in pendulum(order, push, 1e-3) {
                let expected = if t > 0.3 { 4.0 * response(t - 0.3) } else { 0.0 };
                // The motor's torque steps once a millisecond, while the observer takes its mean: 3 x 5 N m/s x 1 ms / 2 = 7.5 mN m.
                // The implicit integration delays the filter by less than one period: 4 N m x 80/s x 1 ms = .32 N m.
                let tolerance = if t > 0.3 { 0.33 } else { 0.01 };
                assert!((r - expected).abs() < tolerance, "{order:?} {t} {r} {expected}");
            }
        }
    }

    #[test]
    fn it_is_stable_at_every_period_and_starts_again_after_nan() {
        for order in [Order::First(1e4), Order::Second(1e4)] {
            let mut observer = Observer::new(order);
            for k in 0..1000 {
                let r = observer.step(k as f64, 60.0, 0.01);
                // The momentum p grows by 100 N m and the known torque is 60 N m. So the external torque is 40 N m.
                assert!(k < 100 || (r - 40.0).abs() < 1e-6, "{order:?} {k} {r}");
            }
            assert_eq!(observer.step(f64::NAN, 60.0, 0.01), 0.0);
            assert_eq!(observer.step(5e3, 60.0, 0.01), 0.0);
            let before = observer.step(5e3 + 1.0, 60.0, 0.01);
            assert_eq!(observer.step(5e3 + 2.0, 60.0, 0.0), before);
        }
    }
}
