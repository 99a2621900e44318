//! Simulates a robot in closed loop and gives the record that an experiment would give.
//!
//! A(q) ddq + h(q, dq) = kt I - G(dq, kt I), integrated in several [`Steps`] per sample. A: inertia matrix; h: Coriolis,
//! centrifugal and gravity torques; kt: torque per current; I: current; G: friction. At each sample the controller uses q rounded
//! to the encoder quantum:
//!
//! I = (Kp (q_r - q) + Kd (dq_r - v) + feedforward) / kt, limited, constant until the next sample,
//!
//! with q_r, dq_r the reference, Kp, Kd the gains, and v the backward difference of q through a first-order filter. The current
//! recorded at t_i is the mean of the currents before and after t_i, that is, the mean current over [t_i - h/2, t_i + h/2]. The
//! record therefore contains the delay of half a sample that the zero-order hold causes.
//!
//! The loop is deterministic; [`Sensors`] adds noise to a copy of its record. Not modelled: flexibility, torque ripple, and noise
//! in the loop.

use linear_model::friction::law::FrictionLaw;
use numerics::positive_definite::solve_positive;
use random::Random;

use crate::motion::record::Record;
use crate::motion::reference_motion::Reference;
use crate::simulate::dynamics::Dynamics;

/// PD controllers of all joints, with a filtered velocity.
#[derive(Clone, Debug, PartialEq)]
pub struct JointPd {
    /// Proportional gains Kp, N m/rad, one per coordinate.
    pub proportional: Vec<f64>,
    /// Derivative gains Kd, N m s/rad, one per coordinate.
    pub derivative: Vec<f64>,
    /// Pole of the first-order velocity filter, rad/s.
    pub velocity_pole: f64,
}

impl JointPd {
    /// Computes gains for `inertia` J (kg m^2) and `bandwidth` f (Hz): Kp = J w^2, Kd = 2 z J w, w = 2 pi f, z = 0.8.
    pub fn for_inertia(inertia: &[f64], bandwidth: &[f64], velocity_pole: f64) -> JointPd {
        let w = |f: &f64| std::f64::consts::TAU * f;
        let pairs = || inertia.iter().zip(bandwidth);
        JointPd {
            proportional: pairs().map(|(j, f)| j * w(f).powi(2)).collect(),
            derivative: pairs().map(|(j, f)| 2.0 * DAMPING_RATIO * j * w(f)).collect(),
            velocity_pole,
        }
    }
}

/// The drives of all joints: torque per unit of current, and greatest torque.
#[derive(Clone, Debug, PartialEq)]
pub struct Drives {
    /// Torque per current kt, N m/A, one per coordinate.
    pub gain: Vec<f64>,
    /// Greatest torque, N m, one per coordinate.
    pub greatest_torque: Vec<f64>,
}

/// Encoders and current sensors of all joints; each list has one entry per coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensors {
    /// Resolution (quantum) of the encoder, rad (m); 0: positions are not rounded.
    pub quantum: Vec<f64>,
    /// Standard deviation of the position noise, rad (m).
    pub position_noise: Vec<f64>,
    /// Standard deviation of the torque noise of one sample, N m at the joint.
    pub torque_noise: Vec<f64>,
}

/// Longest Runge-Kutta step, as a multiple of the time constant with which friction makes a velocity near zero decay. The method
/// is stable up to 2.78.
const LONGEST_STEP_PER_DECAY_TIME: f64 = 2.0;
/// Friction counts as stiff if it needs more than this number of Runge-Kutta steps per sample.
const MAX_RUNGE_KUTTA_STEPS: usize = 16;
/// Number of integration steps per sample with the method that is implicit in friction, for stiff friction.
const IMPLICIT_STEPS_PER_SAMPLE: usize = 4;
/// Number of poses of a reference at which the decay rate of velocities by friction is estimated.
const STIFFNESS_POSES: usize = 20;
/// Damping ratio of the simulated joint controllers.
const DAMPING_RATIO: f64 = 0.8;

/// Integration method of a simulation and its number of steps per sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Steps {
    /// Runge-Kutta 4 with this number of steps.
    RungeKutta(usize),
    /// A method that is implicit in friction, with this number of steps; it is used for stiff friction.
    ImplicitFriction(usize),
}

/// A simulated robot with its drives, controllers, encoders and friction.
pub struct Simulation<'a> {
    /// Inertia matrix and bias torques of the robot.
    pub dynamics: &'a dyn Dynamics,
    /// The PD controllers of all joints.
    pub controller: &'a JointPd,
    /// Gains and limits of the drives.
    pub drives: &'a Drives,
    /// Resolution of the encoders that the controller reads, rad (m), one per coordinate.
    pub quantum: &'a [f64],
    /// The friction law of each coordinate.
    pub friction: &'a [FrictionLaw],
    /// Integration method and number of steps per sample.
    pub steps: Steps,
}

/// A control law that replaces the PD controllers. Arguments: sample index; positions that the controller reads, rad; their
/// filtered differences, rad/s; torques to write, N m.
pub type Law<'a> = dyn FnMut(usize, &[f64], &[f64], &mut [f64]) + 'a;

/// The reason why a simulated motion ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Stop {
    /// The motion reached the end of its reference.
    End,
    /// The motion ended early: the inertia matrix was not positive definite, no velocity was found, or the state diverged.
    NotPhysical {
        /// Time of the early end, s.
        time: f64,
    },
}

impl Simulation<'_> {
    /// The control law: PD controllers that follow `reference`, plus the torques `feedforward[coordinate][sample]`, N m. `None`:
    /// no feedforward.
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

    /// Increases the number of Runge-Kutta steps until they resolve friction near zero velocity, or selects implicit steps if
    /// friction is stiff.
    pub(crate) fn with_short_steps(self, reference: &Reference) -> Self {
        let needed = (reference.sample_time * self.stiffness(reference) / LONGEST_STEP_PER_DECAY_TIME).ceil() as usize;
        let steps = match self.steps {
            Steps::RungeKutta(_) if needed > MAX_RUNGE_KUTTA_STEPS => {
                Steps::ImplicitFriction(IMPLICIT_STEPS_PER_SAMPLE)
            }
            Steps::RungeKutta(steps) => Steps::RungeKutta(steps.max(needed)),
            implicit => implicit,
        };
        Simulation { steps, ..self }
    }

    /// The greatest decay rate, 1/s, that friction gives to a velocity near zero.
    ///
    /// It is estimated by its bound sum_k (A^-1)_kk dG_k/dv (A: inertia matrix; dG_k/dv: slope of the friction of joint k); the
    /// greatest value over poses of the reference is returned.
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

/// Rounds the position q to the encoder quantum; q is unchanged if the quantum is zero.
pub(crate) fn quantised(q: f64, quantum: f64) -> f64 {
    if quantum > 0.0 { (q / quantum).round() * quantum } else { q }
}

impl Sensors {
    /// Standard deviation of a measured position, rad (m), one per coordinate. It consists of the noise and the uniform error of
    /// rounding to the quantum.
    pub fn position_deviation(&self) -> Vec<f64> {
        self.position_noise.iter().zip(&self.quantum).map(|(s, quantum)| s.hypot(quantum / 12f64.sqrt())).collect()
    }

    /// Makes the measured record from an exact one: adds noise, then rounds positions to the encoder quantum. `gain`: torque per
    /// current of each drive, N m/A.
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
        let controller = JointPd { proportional: vec![0.0], derivative: vec![0.0], velocity_pole: 900.0 };
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
        // The zero-order hold delays the torque by half a sample time h, which gives an error of v h / 2 at the velocity v = 1
        // rad/s. Over each period the error decreases again.
        assert!(worst < 1.2e-3, "{worst}");
        assert!((record.current[0][101] - 0.5 * (feedforward[0][100] + feedforward[0][101]) / 0.5).abs() < 1e-12);
    }

    #[test]
    fn sensors_round_and_scatter() {
        let record = Record { sample_time: 1e-3, q: vec![vec![0.123; 4000]], current: vec![vec![1.0; 4000]] };
        let sensing = Sensors { quantum: vec![1e-3], position_noise: vec![2e-3], torque_noise: vec![0.5] };
        let noisy = sensing.measure(&record, &[2.0], &mut Random::new(1));
        assert!(noisy.q[0].iter().all(|q| ((q / 1e-3).round() * 1e-3 - q).abs() < 1e-15));
        let variance = noisy.current[0].iter().map(|c| (c - 1.0).powi(2)).sum::<f64>() / 4000.0;
        // The expected standard deviation is 0.25 A. Five standard errors of a variance from 4000 draws are 11 %.
        assert!((variance / 0.0625 - 1.0).abs() < 0.11, "{variance}");
    }
}
