//! The properties of a robot that a simulation or a plan needs in addition to the model: from the robot's file, or defaults.
//!
//! [`crate::simulate::defaults`] lists the defaults. If a default replaces a value that the file could give, a note says so.
//! Three defaults have no note, because no file format has these values: a controller of 10 Hz; an encoder quantum of 1e-4 rad
//! (m), with noise of half a quantum; a torque noise of 1 % of the effort A_kk a_max that the greatest acceleration takes. If
//! the file has no drive gains, the gains are one; the code that computes currents adds a note on the gains.
//!
//! The controller runs at 1 kHz or faster, at a multiple of the rate of the log. The friction torque changes its sign over
//! velocities of w = 0.005 rad/s. In this range a velocity decays as exp(-l t) with l <= sum_k (A^-1)_kk Fs_k / w (A: inertia
//! matrix; Fs: dry friction). A Runge-Kutta step is at most 2 / l long.

use linear_model::friction::law::FrictionLaw;
use nalgebra::DMatrix;
use random::Random;
use robot::Robot;

use crate::motion::record::Record;
use crate::motion::reference_motion::Reference;
use crate::plan::candidates::MotionLimits;
use crate::simulate::closed_loop::{Drives, JointPd, Sensors, Simulation, Steps, Stop};
use crate::simulate::defaults::{CONTROL_BANDWIDTH_HZ, POSITION_QUANTUM};
use crate::simulate::defaults::{greatest_effort, joint_friction, joint_of, motion_limits};
use crate::simulate::dynamics::{Dynamics, torques};
use crate::simulate::run::{SimulationRun, follow};

/// A function that computes the feedforward torque of a controller for a reference, N m, `[coordinate][instant]`.
pub type Feedforward<'a> = dyn Fn(&Reference) -> Vec<Vec<f64>> + 'a;

/// The properties of a simulated robot, except its dynamics.
#[derive(Clone, Debug)]
pub struct SimulationSetup {
    /// Limits of each coordinate from which motions are chosen.
    pub limits: Vec<MotionLimits>,
    /// PD controllers of all joints, tuned to the robot's inertia.
    pub controller: JointPd,
    /// Whether the controllers have a model of the robot. If so, they add the torques A(q) ddq + h(q, dq) of the reference (A:
    /// inertia matrix, h: bias torque).
    pub knows_robot: bool,
    /// Gains and limits of the drives.
    pub drives: Drives,
    /// Noise and resolution of the sensors.
    pub sensing: Sensors,
    /// Friction law of each joint.
    pub friction: Vec<FrictionLaw>,
    /// Sentences for the user on the defaults that were used.
    pub notes: Vec<String>,
}

/// Greatest ratio of the inertia to which a controller is tuned to the true inertia of the robot. With 1 kHz and a velocity
/// filter of 15 bandwidths, the sampled loop has a phase margin of 34 degrees at the ratio 7, of 22 at 10, and is unstable at
/// 18.2.
const MAX_LIGHTNESS: f64 = 7.0;
/// Number of random poses over which the inertia of the joints is averaged.
const INERTIA_POSES: usize = 20;
/// Pole of the velocity filter as a multiple of the controller's bandwidth.
const FILTER_POLE_BANDWIDTHS: f64 = 15.0;
/// Standard deviation of the simulated position noise as a share of the encoder quantum.
const POSITION_NOISE_QUANTA: f64 = 0.5;
/// Standard deviation of the simulated torque noise as a share of A_kk a_max; A_kk: mean inertia, a_max: greatest acceleration.
const TORQUE_NOISE_SHARE: f64 = 0.01;
/// Least number of Runge-Kutta steps per sample of the controller.
const RUNGE_KUTTA_STEPS: usize = 2;
/// Relative tolerance for rounding when a sample time is divided by the control period.
const SAMPLE_TIME_TOLERANCE: f64 = 1e-9;
/// Longest sample time of the simulated controller, s.
pub const MAX_CONTROL_PERIOD_S: f64 = 1e-3;

/// Inertia matrices at random poses within the limits, and for each joint the greatest gravity torque |h_k(q, 0)| at these poses,
/// N m.
fn sampled(dynamics: &dyn Dynamics, limits: &[MotionLimits]) -> (Vec<DMatrix<f64>>, Vec<f64>) {
    let n = limits.len();
    let (mut a, mut h, mut bias) = (vec![0.0; n * n], vec![0.0; n], vec![0.0_f64; n]);
    let mut random = Random::new(1);
    let matrices = (0..INERTIA_POSES).map(|_| {
        let q: Vec<f64> = limits.iter().map(|l| random.between(l.position.0, l.position.1)).collect();
        dynamics.fill(&q, &vec![0.0; n], &mut a, &mut h);
        bias.iter_mut().zip(&h).for_each(|(bias, h)| *bias = bias.max(h.abs()));
        DMatrix::from_row_slice(n, n, &a)
    });
    (matrices.collect(), bias)
}

/// The inertia to which the controller of each joint k is tuned, and a note if it is not the mean A_kk. `matrices`: inertia
/// matrices A at random poses; `mean`: mean A_kk.
///
/// The mean A_kk is the inertia of the joint with the other joints locked. If the joints are coupled so strongly that the loop
/// would oscillate, the least 1 / (A^-1)_kk is used: the inertia with the other joints free.
fn controller_inertia(matrices: &[DMatrix<f64>], mean: &[f64]) -> (Vec<f64>, Option<String>) {
    let lightness = matrices.iter().map(|a| lightness(a, mean)).fold(0.0, f64::max);
    let inverses: Option<Vec<DMatrix<f64>>> = matrices.iter().map(|a| a.clone().try_inverse()).collect();
    match inverses {
        Some(inverses) if lightness > MAX_LIGHTNESS => {
            let least = |k: usize| inverses.iter().map(|inverse| 1.0 / inverse[(k, k)]).fold(f64::INFINITY, f64::min);
            let note = format!(
                "the joints move each other: together they are {lightness:.0} times as light as one by one; the controllers are \
                 tuned to each joint with the others free, and add the torques of the reference"
            );
            ((0..mean.len()).map(least).collect(), Some(note))
        }
        _ => (mean.to_vec(), None),
    }
}

/// Greatest ratio, over all directions, of the inertia J to which the controllers are tuned (`inertia`) to the inertia matrix A
/// of the robot (`a`). It is the largest eigenvalue of J^1/2 A^-1 J^1/2. Zero if A is not positive definite; the simulation
/// reports that case.
fn lightness(a: &DMatrix<f64>, inertia: &[f64]) -> f64 {
    let scaled = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] / (inertia[i] * inertia[j]).sqrt());
    let least = if scaled.iter().all(|x| x.is_finite()) { scaled.symmetric_eigenvalues().min() } else { 0.0 };
    if least > 0.0 { 1.0 / least } else { 0.0 }
}

impl SimulationSetup {
    /// Makes the simulation setup of a robot with these dynamics.
    pub fn for_robot(robot: &Robot, dynamics: &dyn Dynamics) -> SimulationSetup {
        let (limits, mut notes) = motion_limits(robot);
        let n = limits.len();
        // Mean inertia A_kk over random poses. Several defaults are shares of the effort A_kk a_max; a_max: greatest
        // acceleration.
        let (matrices, bias) = sampled(dynamics, &limits);
        let mean = |k: usize| matrices.iter().map(|a| a[(k, k)] / INERTIA_POSES as f64).sum::<f64>();
        let inertia: Vec<f64> = (0..n).map(mean).collect();
        let effort: Vec<f64> = (0..n).map(|k| inertia[k] * limits[k].acceleration).collect();
        let gains = (0..n).map(|k| joint_of(robot, k).and_then(|j| j.drive_gain).unwrap_or(1.0)).collect();
        let friction = joint_friction(robot, &limits, &effort, &mut notes);
        let greatest_torque = greatest_effort(robot, &effort, &bias, &mut notes);
        // The controllers are tuned to the inertia that each joint effectively has.
        let (seen, note) = controller_inertia(&matrices, &inertia);
        let knows_robot = note.is_some();
        notes.extend(note);
        let velocity_pole = FILTER_POLE_BANDWIDTHS * std::f64::consts::TAU * CONTROL_BANDWIDTH_HZ;
        SimulationSetup {
            knows_robot,
            controller: JointPd::for_inertia(&seen, &vec![CONTROL_BANDWIDTH_HZ; n], velocity_pole),
            drives: Drives { gain: gains, greatest_torque },
            sensing: Sensors {
                quantum: vec![POSITION_QUANTUM; n],
                position_noise: vec![POSITION_NOISE_QUANTA * POSITION_QUANTUM; n],
                torque_noise: effort.iter().map(|e| TORQUE_NOISE_SHARE * e).collect(),
            },
            friction,
            limits,
            notes,
        }
    }

    /// Simulates motions; gives each record, at the rate of its reference, and the reason for its end. The motions run together,
    /// with one call of the dynamics per stage; each record equals the record of a separate run, bit for bit.
    pub fn records(&self, dynamics: &dyn Dynamics, asked: &[SimulatedMotion]) -> Vec<(Record, Stop)> {
        // Number of controller periods per sample of the reference; the tolerance covers the rounding of a rate of 1 kHz.
        let parts = |asked: &SimulatedMotion| {
            (asked.reference.sample_time / MAX_CONTROL_PERIOD_S - SAMPLE_TIME_TOLERANCE).ceil().max(1.0) as usize
        };
        let controlled: Vec<Reference> = asked.iter().map(|a| a.reference.refined(parts(a))).collect();
        let pairs = || asked.iter().zip(&controlled);
        let simulation = |reference: &Reference| {
            Simulation {
                dynamics,
                controller: &self.controller,
                drives: &self.drives,
                quantum: &self.sensing.quantum,
                friction: &self.friction,
                steps: Steps::RungeKutta(RUNGE_KUTTA_STEPS),
            }
            .with_short_steps(reference)
        };
        let simulations: Vec<Simulation> = controlled.iter().map(simulation).collect();
        let feedforward = |(asked, reference): (&SimulatedMotion, &Reference)| {
            let known = || self.knows_robot.then(|| torques(dynamics, reference));
            asked.feedforward.map(|torques| torques(reference)).or_else(known)
        };
        let feedforwards: Vec<Option<Vec<Vec<f64>>>> = pairs().map(feedforward).collect();
        let run = |((simulation, reference), feedforward)| {
            SimulationRun::new(simulation, reference, Simulation::law(simulation, reference, feedforward))
        };
        let forward = feedforwards.iter().map(Option::as_deref);
        let mut runs: Vec<SimulationRun> = simulations.iter().zip(&controlled).zip(forward).map(run).collect();
        follow(dynamics, &mut runs);
        let measured = |(asked, run): (&SimulatedMotion, SimulationRun)| {
            let (record, stop) = run.ended();
            let record = record.thinned(parts(asked));
            let Some((seed, index)) = asked.noise else { return (record, stop) };
            let mut random = Random::stream(seed, index);
            (self.sensing.measure(&record, &self.drives.gain, &mut random), stop)
        };
        asked.iter().zip(runs).map(measured).collect()
    }
}

/// A motion to be simulated, with its feedforward and noise.
#[derive(Clone, Copy)]
pub struct SimulatedMotion<'a> {
    /// The commanded motion.
    pub reference: &'a Reference,
    /// Computes the feedforward torque, N m `[coordinate][instant]`, for the reference at the rate of the controller. `None`:
    /// the controller uses the torques of its own model of the robot, if it has such a model.
    pub feedforward: Option<&'a Feedforward<'a>>,
    /// Seed of the sensor noise and index of its random stream. `None`: no noise.
    pub noise: Option<(u64, u64)>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::dynamics::tests::Mass;

    /// Greatest distance of a mass of 1 kg from its goal, later than one second after the goal has jumped by 1 m. The controller
    /// is tuned to the mass `lightness`, kg.
    fn left(lightness: f64) -> f64 {
        let velocity_pole = 15.0 * std::f64::consts::TAU * CONTROL_BANDWIDTH_HZ;
        let simulation = Simulation {
            dynamics: &Mass(1.0),
            controller: &JointPd::for_inertia(&[lightness], &[CONTROL_BANDWIDTH_HZ], velocity_pole),
            drives: &Drives { gain: vec![1.0], greatest_torque: vec![1e5] },
            quantum: &[0.0],
            friction: &[FrictionLaw::asymmetric(0.0, 0.0, 0.0, 0.0)],
            steps: Steps::RungeKutta(2),
        };
        let count = 1100;
        let step = (0..count).map(|i| if i == 0 { 0.0 } else { 1.0 }).collect();
        let rest = || vec![vec![0.0; count]];
        let reference = Reference {
            sample_time: MAX_CONTROL_PERIOD_S,
            q: vec![step],
            dq: rest(),
            ddq: rest(),
            windows: Vec::new(),
        };
        let (record, stop) = simulation.run(&reference, None);
        assert_eq!(stop, Stop::End);
        assert_eq!(record.q[0].len(), count);
        record.q[0][1000..].iter().map(|q| (q - 1.0).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn the_loop_settles_up_to_the_lightness_it_is_made_for() {
        // The slowest pole of the sampled loop decays by 0.962 per sample, to 1e-17 after a second.
        assert!(left(MAX_LIGHTNESS) < 1e-12, "{}", left(MAX_LIGHTNESS));
        // At the ratio 18.2 a pole of the loop leaves the unit circle. Above this ratio the torque switches between its limits,
        // and the mass oscillates with the amplitude 1e5 / (2 pi 186 Hz)^2.
        assert!(left(17.0) < 1e-6, "{}", left(17.0));
        assert!(left(19.0) > 0.05, "{}", left(19.0));
    }
}
