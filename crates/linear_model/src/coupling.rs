//! A motor that also turns with a joint other than its own: its inertia and friction act on both.
//!
//! With c = R_mk / R_mm, the columns to be added to those of the joints are
//!   tau_k += c (IAM ddq_m + FVM dq_m + FSM sign(dq_m + c dq_k))
//!   tau_m += c (IAM ddq_k + FVM dq_k) + FSM sign(dq_m + c dq_k)
//! [Gautier 1997; Janot, Vandanjon, Gautier 2014, for the TX40]

#[cfg(doc)]
use crate::parameter::CouplingParameter;

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
    /// The speed of the motor behind its gear: dq_m + c dq_k.
    #[inline]
    pub fn speed(&self, dq_motor: f64, dq_joint: f64) -> f64 {
        dq_motor + self.ratio * dq_joint
    }

    /// The three columns of [`CouplingParameter::ALL`] in the row of the joint, and in that of the motor; `motor` is the
    /// direction in which the motor turns.
    #[inline]
    pub fn columns(&self, dq: &[f64], ddq: &[f64], motor: f64) -> [[f64; 3]; 2] {
        let (m, k, c) = (self.motor, self.joint, self.ratio);
        [[c * ddq[m], c * dq[m], c * motor], [c * ddq[k], c * dq[k], motor]]
    }

    /// Writes these columns from `column` on into the n x p rows `w`.
    #[inline]
    pub fn fill(&self, dq: &[f64], ddq: &[f64], motor: f64, w: &mut [f64], p: usize, column: usize) {
        for (row, columns) in [self.joint, self.motor].into_iter().zip(self.columns(dq, ddq, motor)) {
            w[row * p + column..row * p + column + 3].copy_from_slice(&columns);
        }
    }
}
