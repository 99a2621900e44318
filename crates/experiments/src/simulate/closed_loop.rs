//! Simulation of a robot in closed loop: the record that an experiment would give.
//!
//! A(q) ddq + h(q, dq) = kt I - G(dq, kt I), integrated in [`Steps`] of the sample time. At each sample the controller uses q
//! rounded to its encoder quantum:
//!
//! I = (Kp (q_r - q) + Kd (dq_r - v) + feedforward) / kt, limited, held until the next sample,
//!
//! with v the backward difference of q through a first-order filter. The current recorded at t_i is the mean of the currents held
//! before and after t_i, which is the mean current over [t_i - h/2, t_i + h/2]. The record therefore contains the hold's delay of
//! half a sample.
//!
//! The loop is deterministic; noise is added to a copy of its record by [`Sensors`]. Flexibility, torque ripple and noise in the
//! loop are not modelled.

use linear_model::friction::law::FrictionLaw;
use numerics::positive_definite::solve_positive;
use random::Random;

use crate::motion::record::Record;
use crate::motion::reference_motion::Reference;
use crate::simulate::dynamics::Dynamics;

/// Joint PD with a filtered velocity.
#[derive(Clone, Debug, PartialEq)]
pub struct JointPd {
    /// N m/rad a coordinate.
    pub proportional: Vec<f64>,
    /// N m s/rad a coordinate.
    pub derivative: Vec<f64>,
    /// Pole of the velocity filter, rad/s.
    pub velocity_pole: f64,
}

impl JointPd {
    /// Kp = J w^2, Kd = 2 z J w for `inertia` J (kg m^2), `bandwidth` f (Hz), w = 2 pi f, z = 0.8.
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
pub struct Sensors {
    /// rad; 0: none.
    pub quantum: Vec<f64>,
    /// Standard deviation, rad.
    pub position_noise: Vec<f64>,
    /// Standard deviation of one sample, in N m at the joint.
    pub torque_noise: Vec<f64>,
}

/// Longest Runge-Kutta step, as a multiple of the decay time of a velocity under friction near zero velocity. The method is
/// stable up to 2.78.
const LONGEST_STEP_PER_DECAY_TIME: f64 = 2.0;
/// Runge-Kutta steps a sample above which friction counts as stiff.
const MAX_RUNGE_KUTTA_STEPS: usize = 16;
/// Implicit steps a sample where friction is stiff.
const IMPLICIT_STEPS_PER_SAMPLE: usize = 4;
/// Poses of a reference at which the decay time is computed.
const STIFFNESS_POSES: usize = 20;
/// Damping ratio of the joint controllers.
const DAMPING_RATIO: f64 = 0.8;

/// Integration steps of one sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Steps {
    /// This number of Runge-Kutta 4 steps.
    RungeKutta(usize),
    /// This number of steps that are implicit in friction, for stiff friction.
    ImplicitFriction(usize),
}

/// A robot with its drives, controller and friction.
pub struct Simulation<'a> {
    /// The robot.
    pub dynamics: &'a dyn Dynamics,
    /// One for each joint.
    pub controller: &'a JointPd,
    /// Gains and limits of the drives.
    pub drives: &'a Drives,
    /// Encoder quantum that the controller sees, rad.
    pub quantum: &'a [f64],
    /// One law a coordinate.
    pub friction: &'a [FrictionLaw],
    /// How a sample is integrated.
    pub steps: Steps,
}

/// A control law: sample index, positions that the controller sees (rad), their filtered differences (rad/s), torques to write (N
/// m).
pub type Law<'a> = dyn FnMut(usize, &[f64], &[f64], &mut [f64]) + 'a;

/// The reason why a simulated motion stopped.
#[derive(Clone, Debug, PartialEq)]
pub enum Stop {
    /// It did not stop before its end.
    End,
    /// The inertia matrix was not positive definite, or the state exceeded the bound of the simulation.
    NotPhysical {
        /// Time of the stop, s.
        time: f64,
    },
}

impl Simulation<'_> {
    /// The control law of the PD controller with a feedforward, N m `[coordinate][sample]`.
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

    /// Shortens the steps to resolve friction near zero velocity: enough Runge-Kutta steps, or implicit steps.
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

    /// The greatest rate, 1/s, at which friction makes a velocity near zero decay.
    ///
    /// The rate is at most sum_k (A^-1)_kk dG_k/dv; the greatest value of this sum over poses of the reference is returned.
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

/// q rounded to the encoder quantum; q unchanged where the quantum is zero.
pub(crate) fn quantised(q: f64, quantum: f64) -> f64 {
    if quantum > 0.0 { (q / quantum).round() * quantum } else { q }
}

impl Sensors {
    /// Standard deviation of one position, rad (m), one per coordinate: its noise and the uniform error of rounding to a quantum.
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
        // The hold delays by half a sample: v h / 2 at 1 rad/s. The error decreases again over each period.
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
        // 0.25 A; five standard errors of a variance over 4000 draws are 11 %.
        assert!((variance / 0.0625 - 1.0).abs() < 0.11, "{variance}");
    }
}
