//! Effects other than friction that a fit can have as columns: late torques, ripple, springs, eccentric encoders, elastic
//! joints, play.
//!
//! | effect | contribution to the model of tau_j | unknowns |
//! |---|---|---|
//! | `Delay` | -d dtau_j/dt, with one d for all joints | d, s |
//! | `Ripple` of joint j | a cos(k q_j) + b sin(k q_j) - tau_j (c cos(k q_j) + e sin(k q_j)) | a, b, N m; c, e, shares of the torque |
//! | `Spring` of joint j | k q_j, which carries part of its gravity | k, N m/rad |
//! | `Eccentric` joint k | q_k = theta_k - a cos theta_k - b sin theta_k, theta_k measured: the encoder's disc is off its axis | a, b, rad |
//! | `Elastic` joint k | the links move by q_k = theta_k - c tau_k + b dtau_k/dt, theta_k measured at the motor | c = 1/K, rad/(N m); b = D/K^2, rad s/(N m), of a spring with damping D |
//! | `Play` of joint k | q_k = theta_k - (b/2) tanh(tau_k / w), w: 10 % of the rms of tau_k: the torque holds the link at one side of its gap b | b, rad |
//!
//! Delay, ripple and springs are linear; `yielding` linearises the other effects. For a damped spring with deflection s, tau =
//! K s + D ds/dt gives s = c tau - b dtau/dt with a relative error of (w D/K)^2 at the angular frequency w. This error is 2e-4
//! for a spring of 12 Hz with 2 % of the critical damping in equations up to 10 Hz.

/// An effect in the torques or positions, other than friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effect {
    /// The torques are logged with a delay (negative: early).
    Delay,
    /// Ripple: torque and gain of a drive vary periodically with the angle of the joint.
    Ripple {
        /// Index of the coordinate.
        joint: usize,
        /// The number k of periods per turn (2 pi rad), or per 2 pi m of a prismatic joint.
        periods: f64,
    },
    /// A spring acts in parallel with the motor, for example to balance gravity.
    Spring {
        /// Index of the coordinate.
        joint: usize,
    },
    /// The encoder disc is eccentric: the encoder has a sinusoidal error with one period per turn.
    Eccentric {
        /// Index of the coordinate.
        joint: usize,
    },
    /// The joint is elastic: a spring is between motor and link, and the encoder is at the motor.
    Elastic {
        /// Index of the coordinate.
        joint: usize,
    },
    /// The joint has play: a gap is between motor and link, and the encoder is at the motor.
    Play {
        /// Index of the coordinate.
        joint: usize,
    },
}

impl Effect {
    /// Number of unknowns of the effect, each with a column.
    pub fn columns(self) -> usize {
        match self {
            Effect::Ripple { .. } => 4,
            Effect::Elastic { .. } | Effect::Eccentric { .. } => 2,
            Effect::Delay | Effect::Play { .. } | Effect::Spring { .. } => 1,
        }
    }

    /// The joint whose link position differs from the encoder position because of this effect. `None` for other effects.
    pub(crate) fn moved(self) -> Option<usize> {
        match self {
            Effect::Elastic { joint } | Effect::Play { joint } | Effect::Eccentric { joint } => Some(joint),
            Effect::Delay | Effect::Ripple { .. } | Effect::Spring { .. } => None,
        }
    }

    /// Whether the first unknown alone gives the size of the effect. Such a size must be positive.
    pub(crate) fn is_positive(self) -> bool {
        matches!(self, Effect::Elastic { .. } | Effect::Play { .. } | Effect::Spring { .. })
    }
}

/// The estimated size of an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectSize {
    /// The effect, with its joint.
    pub effect: Effect,
    /// Values of the unknowns of the effect. A delay does not include `delay` of [`Band`](crate::spectrum::harmonics::Band).
    pub values: Vec<f64>,
    /// Standard deviations of the unknowns. The standard deviations are valid for the noise that is contained in the weights of
    /// the fit.
    pub deviations: Vec<f64>,
}
