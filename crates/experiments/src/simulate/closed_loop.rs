//! Simulation of a robot in closed loop: the record that an experiment would have left.
//!
//! A(q) ddq + h(q, dq) = kt I - G(dq, kt I), integrated in [`Steps`] of the sample time. Each sample
//! the controller sees q rounded to its encoder quantum,
//!
//! I = (Kp (q_r - q) + Kd (dq_r - v) + feedforward) / kt, limited, held until the next sample,
//!
//! with v the backward difference of q through a first-order filter. The current recorded at t_i is
//! the mean of what was held before and after, the mean current over [t_i - h/2, t_i + h/2]. So the
//! hold's delay of half a sample is in the record.
//!
//! The loop is deterministic; noise is added to a copy of its record by [`Sensing`]. Flexibility,
//! torque ripple and noise in the loop are not here.

use linear_model::friction::law::FrictionLaw;
use numerics::positive_definite::solve_positive;
use random::Random;

use crate::motion::record::Record;
use crate::motion::reference_motion::Reference;
use crate::simulate::dynamics::Dynamics;

/// Joint PD with a filtered velocity.
#[derive(Clone, Debug, PartialEq)]
pub struct Controller {
    /// N m/rad a coordinate.
    pub proportional: Vec<f64>,
    /// N m s/rad a coordinate.
    pub derivative: Vec<f64>,
    /// Pole of the velocity filter, rad/s.
    pub velocity_pole: f64,
}

impl Controller {
    /// Kp = J w^2, Kd = 2 z J w for `inertia` J (kg m^2), `bandwidth` f (Hz), w = 2 pi f, z = 0.8.
    pub fn for_inertia(inertia: &[f64], bandwidth: &[f64], velocity_pole: f64) -> Controller {
        let w = |f: &f64| std::f64::consts::TAU * f;
        let pairs = || inertia.iter().zip(bandwidth);
        Controller {
            proportional: pairs().map(|(j, f)| j * w(f).powi(2)).collect(),
            derivative: pairs().map(|(j, f)| 1.6 * j * w(f)).collect(),
            velocity_pole,
        }
    }
}

/// The drives: torque per unit of current and the greatest torque.
#[derive(Clone, Debug, PartialEq)]
pub struct Drives {
    /// N m/A a coordinate.
    pub gain: Vec<f64>,
    /// N m a coordinate.
    pub greatest_torque: Vec<f64>,
}

/// Encoders and current sensors; one entry a coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensing {
    /// rad; 0: none.
    pub quantum: Vec<f64>,
    /// Standard deviation, rad.
    pub position_noise: Vec<f64>,
    /// Standard deviation of one sample, in N m at the joint.
    pub torque_noise: Vec<f64>,
}

/// Longest step of Runge-Kutta, as a multiple of the time in which friction decays. It is stable up to 2.78.
const LONGEST_STEP_PER_DECAY_TIME: f64 = 2.0;
/// Steps of Runge-Kutta in a sample, above which friction is stiff.
const MOST_STEPS: usize = 16;
/// Steps in a sample where it is.
const STIFF_STEPS: usize = 4;
/// Poses of a reference at which that time is computed.
const STIFFNESS_POSES: usize = 20;

/// Steps in a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Steps {
    /// So many of Runge-Kutta 4.
    RungeKutta(usize),
    /// So many that are implicit in friction, where that is stiff.
    ImplicitFriction(usize),
}

/// A robot with its drives, controller and friction.
pub struct Simulation<'a> {
    /// The robot.
    pub dynamics: &'a dyn Dynamics,
    /// One for each joint.
    pub controller: &'a Controller,
    /// Gains and limits of the drives.
    pub drives: &'a Drives,
    /// Encoder quantum that the controller sees, rad.
    pub quantum: &'a [f64],
    /// One law a coordinate.
    pub friction: &'a [FrictionLaw],
    /// How a sample is integrated.
    pub steps: Steps,
}

/// A law of control: instant, positions that the controller sees, their filtered differences, torques to write, N m.
pub type Law<'a> = dyn FnMut(usize, &[f64], &[f64], &mut [f64]) + 'a;

/// The reason why a simulated motion stopped.
#[derive(Clone, Debug, PartialEq)]
pub enum Stop {
    /// It did not stop before its end.
    End,
    /// The inertia matrix was not positive definite, or the motion left every bound.
    NotPhysical {
        /// Time of the stop, s.
        time: f64,
    },
}

impl Simulation<'_> {
    /// What the controller asks for.
    pub(crate) fn law<'a>(&'a self, reference: &'a Reference, feedforward: Option<&'a [Vec<f64>]>) -> Box<Law<'a>> {
        let controller = self.controller;
        Box::new(move |i, seen, velocity, tau| {
            for (k, tau) in tau.iter_mut().enumerate() {
                *tau = controller.proportional[k] * (reference.q[k][i] - seen[k])
                    + controller.derivative[k] * (reference.dq[k][i] - velocity[k])
                    + feedforward.map_or(0.0, |f| f[k][i]);
            }
        })
    }

    /// The same with steps for the friction where it turns its sign: enough of Runge-Kutta, or implicit ones.
    pub(crate) fn with_short_steps(self, reference: &Reference) -> Self {
        let needed = (reference.sample_time * self.stiffness(reference) / LONGEST_STEP_PER_DECAY_TIME).ceil() as usize;
        let steps = match self.steps {
            Steps::RungeKutta(_) if needed > MOST_STEPS => Steps::ImplicitFriction(STIFF_STEPS),
            Steps::RungeKutta(steps) => Steps::RungeKutta(steps.max(needed)),
            implicit => implicit,
        };
        Simulation { steps, ..self }
    }

    /// The greatest rate, 1/s, at which friction decays where it turns its sign.
    ///
    /// It is at most sum_k (A^-1)_kk dG_k/dv, of which the greatest over the poses of a reference is taken.
    fn stiffness(&self, reference: &Reference) -> f64 {
        let (n, count) = (self.dynamics.n_coordinates(), reference.q.first().map_or(0, Vec::len));
        let (mut inertia, mut bias, rest) = (vec![0.0; n * n], vec![0.0; n], vec![0.0; n]);
        let mut most = 0.0_f64;
        for i in (0..count).step_by(count.div_ceil(STIFFNESS_POSES).max(1)) {
            let q: Vec<f64> = reference.q.iter().map(|q| q[i]).collect();
            self.dynamics.fill(&q, &rest, &mut inertia, &mut bias);
            let of = |k: usize| {
                let mut unit = vec![0.0; n];
                unit[k] = 1.0;
                solve_positive(&mut inertia.clone(), &mut unit).then(|| unit[k] * self.friction[k].slope_at_rest())
            };
            most = most.max((0..n).filter_map(of).sum());
        }
        most
    }
}

/// q rounded to the encoder's steps; as it is where they are zero.
pub(crate) fn quantised(q: f64, quantum: f64) -> f64 {
    if quantum > 0.0 { (q / quantum).round() * quantum } else { q }
}

impl Sensing {
    /// Standard deviation of one position, rad (m), one per coordinate: its noise, and the uniform error of rounding to a
    /// quantum.
    pub fn position_deviation(&self) -> Vec<f64> {
        self.position_noise.iter().zip(&self.quantum).map(|(s, quantum)| s.hypot(quantum / 12f64.sqrt())).collect()
    }

    /// The record as the sensors give it: noise, then rounding to the encoder quantum.
    pub fn measure(&self, record: &Record, gain: &[f64], random: &mut Random) -> Record {
        let mut noisy = record.clone();
        let count = record.q.first().map_or(0, Vec::len);
        for i in 0..count {
            for k in 0..record.q.len() {
                let q = record.q[k][i] + self.position_noise[k] * random.normal();
                noisy.q[k][i] = quantised(q, self.quantum[k]);
                noisy.current[k][i] += self.torque_noise[k] / gain[k] * random.normal();
            }
        }
        noisy
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::profile::Profile;
    use crate::plan::exciting_trajectory::{ExcitingTrajectory, MovingJoints, SwingCourse};
    use crate::plan::motion_kind::MotionKind;
    use crate::simulate::dynamics::tests::Mass;

    #[test]
    fn feedforward_alone_follows_the_reference() {
        let joints = MovingJoints { kind: MotionKind::Inertial, fast: 0, slow: &[], centre: &[0.0] };
        let course = SwingCourse {
            profile: Profile::Smooth,
            period: 400,
            acceleration: 10.0,
            slow_velocity: &[0.0],
            duration: 0.8,
            sample_time: 1e-3,
        };
        let swing = ExcitingTrajectory::swing(&joints, &course);
        let reference = swing.reference();
        let controller = Controller { proportional: vec![0.0], derivative: vec![0.0], velocity_pole: 900.0 };
        let drives = Drives { gain: vec![0.5], greatest_torque: vec![100.0] };
        let simulation = Simulation {
            dynamics: &Mass(2.0),
            controller: &controller,
            drives: &drives,
            quantum: &[0.0],
            friction: &[FrictionLaw::asymmetric(0.0, 0.0, 0.0, 0.0)],
            steps: Steps::RungeKutta(2),
        };
        let feedforward = [reference.ddq[0].iter().map(|a| 2.0 * a).collect::<Vec<f64>>()];
        let (record, stop) = simulation.run(&reference, Some(&feedforward));
        assert_eq!(stop, Stop::End);
        let worst = record.q[0].iter().zip(&reference.q[0]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // The hold delays by half a sample: v h / 2 at 1 rad/s, and drifts back over each period.
        assert!(worst < 1.2e-3, "{worst}");
        assert!((record.current[0][101] - 0.5 * (feedforward[0][100] + feedforward[0][101]) / 0.5).abs() < 1e-12);
    }

    #[test]
    fn sensors_round_and_scatter() {
        let record = Record { sample_time: 1e-3, q: vec![vec![0.123; 4000]], current: vec![vec![1.0; 4000]] };
        let sensing = Sensing { quantum: vec![1e-3], position_noise: vec![2e-3], torque_noise: vec![0.5] };
        let noisy = sensing.measure(&record, &[2.0], &mut Random::new(1));
        assert!(noisy.q[0].iter().all(|q| ((q / 1e-3).round() * 1e-3 - q).abs() < 1e-15));
        let variance = noisy.current[0].iter().map(|c| (c - 1.0).powi(2)).sum::<f64>() / 4000.0;
        // 0.25 A; five standard errors of a variance over 4000 draws are 11 %.
        assert!((variance / 0.0625 - 1.0).abs() < 0.11, "{variance}");
    }
}
