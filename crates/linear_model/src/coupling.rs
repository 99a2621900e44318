//! A motor that turns with joints other than its own too: its inertia and friction act on all of them.
//!
//! With w = dq_m + sum_k c_k dq_k its speed behind its gear, c_k = R_mk / R_mm, the columns to be added to those of the joints are
//!   tau_k += c_k (IAM (dw/dt - c_k ddq_k) + FVM (w - c_k dq_k) + FSM sign(w))
//!   tau_m += IAM (dw/dt - ddq_m) + FVM (w - dq_m) + FSM sign(w)
//! since the share of a joint's own motion is in its rotor inertia and viscous friction.
//! [Gautier 1997; Janot, Vandanjon, Gautier 2014, for the TX40]

#[cfg(doc)]
use crate::parameter::CouplingParameter;

/// Motor m, which other joints turn too.
#[derive(Clone, Debug, PartialEq)]
pub struct Coupling {
    /// The coordinate of the motor.
    pub motor: usize,
    /// The other coordinates that turn it, each with R_mk / R_mm.
    pub joints: Vec<(usize, f64)>,
}

impl Coupling {
    /// The speed of the motor behind its gear.
    #[inline]
    pub fn speed(&self, dq: impl Fn(usize) -> f64) -> f64 {
        self.joints.iter().map(|&(k, c)| c * dq(k)).sum::<f64>() + dq(self.motor)
    }

    /// The joints on which it acts: the others in their order, then its own.
    pub fn rows(&self) -> impl Iterator<Item = usize> {
        self.joints.iter().map(|(k, _)| *k).chain([self.motor])
    }

    /// The three columns of [`CouplingParameter::ALL`] in each of these rows; `motor` is the direction in which the motor turns.
    #[inline]
    pub fn columns(&self, dq: &[f64], ddq: &[f64], motor: f64) -> impl Iterator<Item = [f64; 3]> {
        let (speed, acceleration) = (self.speed(|k| dq[k]), self.speed(|k| ddq[k]));
        let row = move |(k, c): (usize, f64)| [c * (acceleration - c * ddq[k]), c * (speed - c * dq[k]), c * motor];
        self.joints.iter().copied().chain([(self.motor, 1.0)]).map(row)
    }

    /// Writes these columns from `column` on into the n x p rows `w`.
    #[inline]
    pub fn fill(&self, dq: &[f64], ddq: &[f64], motor: f64, w: &mut [f64], p: usize, column: usize) {
        for (row, columns) in self.rows().zip(self.columns(dq, ddq, motor)) {
            w[row * p + column..row * p + column + 3].copy_from_slice(&columns);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The power of a motor that three joints turn is its torque times its own speed, but for what stands in the joints' own
    /// rotor inertia and viscous friction.
    #[test]
    fn the_power_is_that_of_the_motor() {
        let motor = Coupling { motor: 2, joints: vec![(0, 0.5), (1, -0.3)] };
        let (dq, ddq) = ([0.7, -1.1, 0.4], [2.0, 3.0, -1.5]);
        let (speed, acceleration) = (motor.speed(|k| dq[k]), motor.speed(|k| ddq[k]));
        let mut rows = [0.0; 9];
        motor.fill(&dq, &ddq, speed.signum(), &mut rows, 3, 0);
        let own = [(0, 0.5), (1, -0.3), (2, 1.0)].map(|(k, c): (usize, f64)| [c * c * ddq[k], c * c * dq[k], 0.0]);
        let whole = [acceleration, speed, speed.signum()];
        for (column, of_motor) in whole.iter().enumerate() {
            let power: f64 = (0..3).map(|k| dq[k] * (rows[3 * k + column] + own[k][column])).sum();
            assert!((power - speed * of_motor).abs() < 1e-14, "{column}: {power}");
        }
    }
}
