//! The noise that an identification of a motion has to expect in each joint.
//!
//! Torques are noisy, and so are the accelerations that an identification takes from positions. A position noise s of each
//! sample has, below the cut-off w, the acceleration s w^2 / sqrt 5 (the mean of the fourth powers of the frequencies below w
//! is w^4 / 5). The inertia matrix makes a torque of it,
//!
//! e_i^2 = mean over the motion of sum_k A_ik^2 s_k^2 w^4 / 5,
//!
//! far above the frequencies of the motion. The parameters hardly see it; the weight of joint i, 1 / sqrt(s_i^2 + e_i^2), does.

use crate::experiments::excitation::motion::Motion;
use crate::signals::cutoff::rule;
use crate::simulate::dynamics::Dynamics;

/// N m (N) a sample, one a coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct JointNoise {
    /// Of the torques, white: s.
    pub torque: Vec<f64>,
    /// What the encoders add to the residual: e.
    pub encoders: Vec<f64>,
}

impl JointNoise {
    /// Of the torques alone.
    pub fn of_torques(torque: Vec<f64>) -> JointNoise {
        JointNoise { encoders: vec![0.0; torque.len()], torque }
    }

    /// What an identification divides the rows of each joint by: the deviation of its residual.
    pub fn weights(&self) -> Vec<f64> {
        self.torque.iter().zip(&self.encoders).map(|(s, e)| s.hypot(*e)).collect()
    }
}

/// What the encoders add to the residuals of an identification of the motion with its default cut-off; `noise`: rad (m) of a
/// position, one a coordinate.
pub fn encoder_torque(dynamics: &dyn Dynamics, motion: &Motion, noise: &[f64]) -> Vec<f64> {
    let reference = motion.reference();
    let n = noise.len();
    let w = std::f64::consts::TAU * rule(&reference.q, reference.sample_time).cutoff;
    let (mut inertia, mut bias, mut sum) = (vec![0.0; n * n], vec![0.0; n], vec![0.0; n]);
    let samples = reference.q.first().map_or(0, Vec::len);
    for k in 0..samples {
        let q: Vec<f64> = reference.q.iter().map(|q| q[k]).collect();
        dynamics.fill(&q, &vec![0.0; n], &mut inertia, &mut bias);
        for (i, sum) in sum.iter_mut().enumerate() {
            *sum += inertia[i * n..][..n].iter().zip(noise).map(|(a, s)| (a * s).powi(2)).sum::<f64>();
        }
    }
    sum.into_iter().map(|sum| w * w * (sum / (5 * samples.max(1)) as f64).sqrt()).collect()
}
