//! A motor that also turns with a joint other than its own: its inertia and friction act on both.
//!
//! With c = R_mk / R_mm, the columns to be added to those of the joints are
//!   tau_k += c (IAM ddq_m + FVM dq_m + FSM sign(dq_m + c dq_k))
//!   tau_m += c (IAM ddq_k + FVM dq_k) + FSM sign(dq_m + c dq_k)
//! [Gautier 1997; Janot, Vandanjon, Gautier 2014, for the TX40]

use crate::model::friction::terms::sign;
#[cfg(doc)]
use crate::model::parameter::CouplingParameter;

/// Motor m, which joint k turns too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// The coordinate of the motor.
    pub motor: usize,
    /// The other coordinate that turns it.
    pub joint: usize,
    /// R_mk / R_mm.
    pub ratio: f64,
}

impl Coupling {
    /// The direction in which the motor turns: sign(dq_m + c dq_k).
    pub fn direction(&self, dq_motor: f64, dq_joint: f64) -> f64 {
        sign(dq_motor + self.ratio * dq_joint)
    }

    /// Writes the three columns of [`CouplingParameter::ALL`] from `column` on into the n x p rows `w`; `motor` is the direction in
    /// which the motor turns.
    pub fn fill(&self, dq: &[f64], ddq: &[f64], motor: f64, w: &mut [f64], p: usize, column: usize) {
        let (m, k, c) = (self.motor, self.joint, self.ratio);
        w[k * p + column..k * p + column + 3].copy_from_slice(&[c * ddq[m], c * dq[m], c * motor]);
        w[m * p + column..m * p + column + 3].copy_from_slice(&[c * ddq[k], c * dq[k], motor]);
    }
}
