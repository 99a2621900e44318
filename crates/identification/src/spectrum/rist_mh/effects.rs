//! Effects beside friction that a fit can have as columns: late torques, ripple, springs, eccentric encoders, joints that
//! bend, play.
//!
//! | effect | what it adds to the model of tau_j | unknowns |
//! |---|---|---|
//! | `Delay` | -d dtau_j/dt, the same d for all joints | d, s |
//! | `Ripple` of joint j | a cos(k q_j) + b sin(k q_j) - tau_j (c cos(k q_j) + e sin(k q_j)) | a, b, N m; c, e, shares of the torque |
//! | `Spring` of joint j | k q_j, which carries part of its gravity | k, N m/rad |
//! | `Eccentric` joint k | q_k = theta_k - a cos theta_k - b sin theta_k, theta_k measured: the encoder's disc is off its axis | a, b, rad |
//! | `Elastic` joint k | the links move by q_k = theta_k - c tau_k + b dtau_k/dt, theta_k measured at the motor | c = 1/K, rad/(N m); b = D/K^2, rad s/(N m), of a spring with damping D |
//! | `Play` of joint k | q_k = theta_k - (b/2) tanh(tau_k / w): the torque holds the link at one side of its gap | b, rad |
//!
//! Those of delay, ripple and springs are linear; `yielding` linearises the others. tau = K s + D ds/dt gives s = c tau - b dtau/dt with an
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
    /// A spring acts beside the motor, as one that balances gravity.
    Spring {
        /// Index of the coordinate.
        joint: usize,
    },
    /// The encoder reads once a turn too much and too little.
    Eccentric {
        /// Index of the coordinate.
        joint: usize,
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
            Effect::Elastic { .. } | Effect::Eccentric { .. } => 2,
            Effect::Delay | Effect::Play { .. } | Effect::Spring { .. } => 1,
        }
    }

    /// The joint whose links move otherwise than its encoder says; `None` for an effect that moves no links.
    pub(crate) fn moved(self) -> Option<usize> {
        match self {
            Effect::Elastic { joint } | Effect::Play { joint } | Effect::Eccentric { joint } => Some(joint),
            Effect::Delay | Effect::Ripple { .. } | Effect::Spring { .. } => None,
        }
    }

    /// Whether its first unknown alone says how large it is, and is positive.
    pub(crate) fn is_positive(self) -> bool {
        matches!(self, Effect::Elastic { .. } | Effect::Play { .. } | Effect::Spring { .. })
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
