//! Drift of the friction of one joint: the changes of viscous friction, Coulomb friction and offset since the identification.
//!
//! ```text
//! r = -(dFV dq + dFS c + dOFF) + e          dq, c: speed and its direction, through the filter of the observer
//! ```
//! The recursion forgets slowly. A change is significant if it exceeds its standard deviation by the factor of the caller.

use crate::real::Real;
use crate::recursion::Recursion;

/// Recursive estimate of the drift of one joint.
#[derive(Clone, Copy, Debug)]
pub struct Drift<R> {
    recursion: Recursion<R, 3>,
    root_of_weight: R,
    correlation: R,
}

impl<R: Real> Drift<R> {
    /// Starts without drift. `start`: standard deviations of the changes of FV, FS and OFF that are possible; `weight`: factor of
    /// the weight of a row at each later update, for example 1 - period / memory; `correlation`: f of [`crate::Payload`].
    pub fn new(start: [R; 3], weight: R, correlation: R) -> Drift<R> {
        Drift { recursion: Recursion::new(&start), root_of_weight: weight.sqrt(), correlation }
    }

    /// Takes one update. `speed`, `direction`: dq and its sign, both through the filter of the observer; `torque`: r, N m (N);
    /// `deviation`: standard deviation of r without contact.
    pub fn push(&mut self, speed: R, direction: R, torque: R, deviation: R) {
        let weight = R::ONE / deviation;
        self.recursion.forget(self.root_of_weight);
        self.recursion.push([speed, direction, R::ONE].map(|x| -x * weight), torque * weight);
    }

    /// The changes of FV (N m s/rad), FS (N m) and OFF (N m), and their standard deviations.
    pub fn changes(&self) -> ([R; 3], [R; 3]) {
        let sigma = self.recursion.inverse_triangle().map(|row| {
            let variance = row.iter().fold(R::ZERO, |sum, x| sum + *x * *x);
            (self.correlation * variance).sqrt()
        });
        (self.recursion.solution(), sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    #[test]
    fn a_change_of_friction_is_followed() {
        let mut drift = Drift::new([1.0; 3], 0.999, 1.0);
        let mut random = Random::new(3);
        for k in 0..20_000 {
            let speed = (0.01 * f64::from(k)).sin();
            let direction = if speed < 0.0 { -1.0 } else { 1.0 };
            let change = if k < 10_000 { [0.0; 3] } else { [0.2, 0.5, -0.1] };
            let torque = -(change[0] * speed + change[1] * direction + change[2]) + 0.3 * random.normal();
            drift.push(speed, direction, torque, 0.3);
            if k == 9_999 {
                let (found, sigma) = drift.changes();
                assert!((0..3).all(|i| found[i].abs() < 4.0 * sigma[i]), "{found:?} {sigma:?}");
            }
        }
        let (found, sigma) = drift.changes();
        assert!((0..3).all(|i| (found[i] - [0.2, 0.5, -0.1][i]).abs() < 4.0 * sigma[i]), "{found:?} {sigma:?}");
        assert!(found[1] > 10.0 * sigma[1]);
    }
}
