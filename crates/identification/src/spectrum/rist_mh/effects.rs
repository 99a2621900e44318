//! Effects beside friction that a fit can have as columns: late torques, ripple, joints that bend, play.
//!
//! | effect | what it adds to the model of tau_j | unknowns |
//! |---|---|---|
//! | `Delay` | -d dtau_j/dt, the same d for all joints | d, s |
//! | `Ripple` of joint j | a cos(k q_j) + b sin(k q_j) - tau_j (c cos(k q_j) + e sin(k q_j)) | a, b, N m; c, e, shares of the torque |
//! | `Elastic` joint k | the links move by q_k = theta_k - c tau_k + b dtau_k/dt, theta_k measured at the motor | c = 1/K, rad/(N m); b = D/K^2, rad s/(N m), of a spring with damping D |
//! | `Play` of joint k | q_k = theta_k - (b/2) tanh(tau_k / w): the torque holds the link at one side of its gap | b, rad |
//!
//! The first two are linear; `yielding` linearises the others. tau = K s + D ds/dt gives s = c tau - b dtau/dt with an
//! error of (w D/K)^2. That is 2e-4 for a spring of 12 Hz with 2 % of its rotor's critical damping in equations up to
//! 10 Hz.

/// An effect beside friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effect {
    /// The torques are logged late, or early.
    Delay,
    /// Torque and gain of a drive go up and down with the angle of the joint.
    Ripple {
        /// Index of the coordinate.
        joint: usize,
        /// k: periods a turn, 2 pi rad; 2 pi m of a prismatic joint.
        periods: f64,
    },
    /// The link is behind a spring, the encoder at the motor.
    Elastic {
        /// Index of the coordinate.
        joint: usize,
    },
    /// The link is behind a gap, the encoder at the motor.
    Play {
        /// Index of the coordinate.
        joint: usize,
    },
}

impl Effect {
    /// Number of unknowns.
    pub fn columns(self) -> usize {
        match self {
            Effect::Ripple { .. } => 4,
            Effect::Elastic { .. } => 2,
            Effect::Delay | Effect::Play { .. } => 1,
        }
    }

    /// The joint whose links move otherwise than its motor; `None` for an effect that moves no links.
    pub(crate) fn yielding(self) -> Option<usize> {
        match self {
            Effect::Elastic { joint } | Effect::Play { joint } => Some(joint),
            Effect::Delay | Effect::Ripple { .. } => None,
        }
    }
}

/// What was found of an effect, in the order of its unknowns.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectSize {
    /// The effect.
    pub effect: Effect,
    /// Its unknowns. A delay is counted from that of the band.
    pub values: Vec<f64>,
    /// Their standard deviations for the noise of the weights.
    pub deviations: Vec<f64>,
}
