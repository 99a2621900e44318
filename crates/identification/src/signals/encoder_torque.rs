//! Computes how encoder noise contributes to the residuals of an identification.
//!
//! Position noise with standard deviation s per sample is differentiated twice. Below the cut-off w, rad/s, the mean density of
//! the result equals the density of white acceleration noise with standard deviation s w^2 / sqrt 5 per sample, because the
//! mean of the fourth powers of the frequencies below w is w^4 / 5. With the inertia matrix A this is the torque noise of joint
//! i,
//!
//! e_i^2 = mean over the motion of sum_k A_ik^2 s_k^2 w^4 / 5.
//!
//! Most of this noise is at much higher frequencies than the motion. So the noise hardly changes the parameters, but it lowers
//! the weight of joint i in the fit.

use experiments::motion::reference_motion::Reference;
use experiments::simulate::dynamics::Dynamics;

use crate::signals::cutoff::rule_with_noise;

/// Number of samples for which the dynamics are computed in one call.
const SAMPLES_PER_CALL: usize = 64;

/// The rms torque noise e_i of each coordinate, N m (N), for an identification with the default cut-off. `noise`: standard
/// deviations s of the positions, rad (m).
pub fn encoder_torque(dynamics: &dyn Dynamics, motion: &Reference, noise: &[f64]) -> Vec<f64> {
    let n = noise.len();
    let w = std::f64::consts::TAU * rule_with_noise(&motion.q, motion.sample_time, noise).cutoff;
    let (mut inertia, mut bias) = (vec![0.0; SAMPLES_PER_CALL * n * n], vec![0.0; SAMPLES_PER_CALL * n]);
    let (mut sum, at_rest) = (vec![0.0; n], vec![0.0; n]);
    let samples = motion.q.first().map_or(0, Vec::len);
    for first in (0..samples).step_by(SAMPLES_PER_CALL) {
        let instants = first..samples.min(first + SAMPLES_PER_CALL);
        let positions: Vec<Vec<f64>> = instants.map(|k| motion.q.iter().map(|q| q[k]).collect()).collect();
        let states: Vec<(&[f64], &[f64])> = positions.iter().map(|q| (&q[..], &at_rest[..])).collect();
        let count = states.len();
        dynamics.fill_each(&states, &mut inertia[..count * n * n], &mut bias[..count * n]);
        for (i, row) in inertia[..count * n * n].chunks_exact(n.max(1)).enumerate() {
            sum[i % n] += row.iter().zip(noise).map(|(a, s)| (a * s).powi(2)).sum::<f64>();
        }
    }
    sum.into_iter().map(|sum| w * w * (sum / (5 * samples.max(1)) as f64).sqrt()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;
    use experiments::simulate::dynamics::RegressorDynamics;
    use random::Random;

    /// The expected torque noise is computed from the spectrum of white position noise: the rms of the second derivative of
    /// this noise below the cut-off, times the inertia.
    #[test]
    fn it_is_the_noise_of_the_acceleration() {
        let (rate, n, noise) = (100.0, 2000, 1e-4);
        let q: Vec<f64> = (0..n).map(|i| 0.5 * (std::f64::consts::TAU * 0.4 * i as f64 / rate).sin()).collect();
        let motion = Reference { sample_time: 1.0 / rate, q: vec![q.clone()], ..Reference::default() };
        let (arm, inertia) = (Pendulum::new(), 0.7);
        let found = encoder_torque(&RegressorDynamics::new(&arm, vec![inertia, 0.0, 0.0]), &motion, &[noise])[0];

        // Each frequency up to half the sampling rate has an equal share of the variance of white noise.
        let cutoff = rule_with_noise(&[q], 1.0 / rate, &[noise]).cutoff;
        let mut random = Random::new(4);
        let (bins, mut square) = (2000, 0.0);
        for bin in 0..bins {
            let frequency = (bin as f64 + 0.5) / bins as f64 * 0.5 * rate;
            if frequency < cutoff {
                // A cosine and a sine with random amplitudes. The mean square of this frequency component is noise^2 / bins.
                let size = noise * random.normal().hypot(random.normal()) / (2.0 * bins as f64).sqrt();
                square += (inertia * size * (std::f64::consts::TAU * frequency).powi(2)).powi(2);
            }
        }
        // `expected`: rms per sample of a white torque noise (up to half the sampling rate) with the same density as the torque
        // noise below the cut-off.
        let expected = (square * 0.5 * rate / cutoff).sqrt();
        // About a hundred bins determine the sum. So the sum of squares has an error of 10 %, and the root of the sum an error
        // of 5 %. Four times this error is allowed.
        assert!((found / expected - 1.0).abs() < 0.2, "{found} {expected}");
    }
}
