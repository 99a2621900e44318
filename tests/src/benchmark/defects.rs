//! Defects that the models of R3G and similar arms do not contain: torque ripple, springs, eccentric encoders, flexible joints,
//! backlash, delayed torques.
//!
//! Flexible joints are simulated in closed loop with two masses per joint, the rotor at theta and the link at q: J theta'' = kt
//! I - G(theta') - tau, M(q) q'' + h(q, q') = tau, tau = K s + D s'. s: deflection theta - q, reduced by the gap if there is
//! backlash; zero within the gap. The encoder measures theta. J: inertia of the rotor, kt: drive gain, I: current, G: friction.
//! The rotor torque J theta'' is known and is subtracted from the recorded currents.

use experiments::motion::record::Record;
use experiments::motion::reference_motion::Reference;
use experiments::plan::exciting_trajectory::ExcitingTrajectory;
use experiments::simulate::closed_loop::{Drives, JointPd, Sensors, Simulation, Steps, Stop};
use experiments::simulate::dynamics::{Dynamics, inverse_dynamics};
use identification::spectrum::experiment::SpectralExperiment;
use linear_model::friction::law::FrictionLaw;
use numerics::fourier::circular_differences;
use random::Random;

use crate::benchmark::arms::NO_FRICTION;
use crate::benchmark::scenario::BenchmarkArm;

/// A defect of one joint or of all joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Defect {
    /// The torques are logged with this delay, s.
    Late(f64),
    /// The drive gain varies sinusoidally with the joint angle, by this fraction. Second number: radians of the sine per radian
    /// of the joint.
    GainRipple(f64, f64),
    /// A torque that is periodic in the joint angle is added: its amplitude as a fraction of the largest torque, and its number
    /// of periods per turn.
    Ripple(f64, f64),
    /// A spring parallel to the motor, N m/rad.
    Spring(f64),
    /// The encoder has an error of this amplitude times the cosine of the joint angle, rad.
    Eccentric(f64),
    /// Flexible joints: the links oscillate at this frequency, Hz, if the motors are blocked.
    Elastic(f64),
    /// Backlash with this gap, rad, in series with a stiff spring. The joint oscillates on this spring with the frequency
    /// `STIFF`.
    Play(f64),
}

/// Oscillation frequency of a joint that is nearly rigid, Hz.
const STIFF: f64 = 100.0;
/// Damping of flexible joints, and of stiff joints, as fractions of the critical damping. With the damping of a flexible joint, a
/// stiff joint would oscillate in closed loop until the drive saturates (17 N m of noise in q1 and q3 if only q2 is flexible),
/// and a joint with backlash would rattle.
const DAMPING: f64 = 0.02;
const STIFF_DAMPING: f64 = 0.1;
/// Inertia of the rotor, as a fraction of the inertia that the motor moves.
const ROTOR: f64 = 0.2;

/// The dynamics of a robot with two masses per joint. The coordinates are first the angles of all motors, then the angles of all
/// links.
struct TwoMass<'a> {
    links: &'a dyn Dynamics,
    rotor: Vec<f64>,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    gap: Vec<f64>,
}

impl Dynamics for TwoMass<'_> {
    fn n_coordinates(&self) -> usize {
        2 * self.rotor.len()
    }

    fn fill(&self, q: &[f64], dq: &[f64], inertia: &mut [f64], bias: &mut [f64]) {
        let n = self.rotor.len();
        let (mut own, mut h) = (vec![0.0; n * n], vec![0.0; n]);
        self.links.fill(&q[n..], &dq[n..], &mut own, &mut h);
        inertia.fill(0.0);
        for k in 0..n {
            let (apart, half) = (q[k] - q[n + k], 0.5 * self.gap[k]);
            let pressed = apart - apart.clamp(-half, half);
            let touches = f64::from(pressed != 0.0 || half == 0.0);
            let tau = self.stiffness[k] * pressed + touches * self.damping[k] * (dq[k] - dq[n + k]);
            inertia[k * 2 * n + k] = self.rotor[k];
            bias[k] = tau;
            bias[n + k] = h[k] - tau;
            for l in 0..n {
                inertia[(n + k) * 2 * n + n + l] = own[k * n + l];
            }
        }
    }
}

impl Defect {
    /// Simulates the experiments of a plan with this defect, without noise. `joint`: the joint with the defect; `None`: all
    /// joints have it.
    pub fn experiments(
        self,
        arm: &BenchmarkArm,
        plan: &[ExcitingTrajectory],
        joint: Option<usize>,
    ) -> Result<Vec<SpectralExperiment>, Stop> {
        let has = |k: usize| joint.is_none_or(|j| j == k);
        // The feedforward is computed with parameters that are wrong by 20 %, as in the scenarios without a defect.
        let mut random = Random::new(77);
        let wrong: Vec<f64> = arm.truth.iter().map(|x| x * if random.uniform() >= 0.5 { 1.2 } else { 0.8 }).collect();
        let mut found = Vec::new();
        for trajectory in plan {
            let reference = trajectory.reference();
            let feedforward = inverse_dynamics(arm.regressor, &wrong, &reference);
            let record = match self {
                Defect::Elastic(_) | Defect::Play(_) => self.two_mass(arm, &reference, feedforward, &has)?,
                _ => rigid(arm, &reference, &feedforward)?,
            };
            let Some(mut experiment) = SpectralExperiment::new(trajectory.clone(), &record) else { continue };
            (0..arm.friction.len()).filter(|&k| has(k)).for_each(|k| self.log(arm, &mut experiment, k));
            found.push(experiment);
        }
        Ok(found)
    }

    /// Adds the defect to the record of joint k, if it is a defect that the simulation does not contain.
    fn log(self, arm: &BenchmarkArm, experiment: &mut SpectralExperiment, k: usize) {
        let current = experiment.current[k].clone();
        let n = current.len();
        for i in 0..n {
            let wave = |periods: f64| (periods * experiment.q[k][i] + 0.4 + k as f64).sin();
            experiment.current[k][i] = match self {
                // The record has whole periods, so the samples that are shifted out at its end are shifted in at its start.
                Defect::Late(seconds) => {
                    let at = (i as f64 - seconds / arm.sample_time).rem_euclid(n as f64);
                    let (low, share) = (at.floor() as usize % n, at.fract());
                    (1.0 - share) * current[low] + share * current[(low + 1) % n]
                }
                Defect::GainRipple(share, periods) => current[i] / (1.0 + share * wave(periods)),
                Defect::Ripple(share, periods) => {
                    current[i] + share * arm.drives.greatest_torque[k] / arm.drives.gain[k] * wave(periods)
                }
                Defect::Spring(stiffness) => current[i] + stiffness * experiment.q[k][i] / arm.drives.gain[k],
                Defect::Elastic(_) | Defect::Play(_) | Defect::Eccentric(_) => current[i],
            };
        }
        if let Defect::Eccentric(off) = self {
            experiment.q[k].iter_mut().for_each(|q| *q += off * q.cos());
        }
    }

    fn masses<'a>(self, arm: &BenchmarkArm<'a>, has: &dyn Fn(usize) -> bool) -> TwoMass<'a> {
        let n = arm.drives.gain.len();
        // The inertia J for which the controller was tuned: Kp = J w^2, Kd = 1.6 J w.
        let inertia = |k: usize| {
            let (p, d) = (arm.controller.proportional[k], arm.controller.derivative[k]);
            d * d / (1.6 * 1.6 * p)
        };
        let spring = |k: usize| match self {
            Defect::Elastic(hz) if has(k) => (hz, DAMPING),
            _ => (STIFF, STIFF_DAMPING),
        };
        let stiffness: Vec<f64> = (0..n).map(|k| inertia(k) * (std::f64::consts::TAU * spring(k).0).powi(2)).collect();
        let gap = |k: usize| if let Defect::Play(gap) = self { if has(k) { gap } else { 0.0 } } else { 0.0 };
        let rotor: Vec<f64> = (0..n).map(|k| ROTOR * inertia(k)).collect();
        TwoMass {
            links: arm.dynamics,
            damping: (0..n).map(|k| 2.0 * spring(k).1 * (stiffness[k] * rotor[k]).sqrt()).collect(),
            gap: (0..n).map(gap).collect(),
            rotor,
            stiffness,
        }
    }

    fn two_mass(
        self,
        arm: &BenchmarkArm,
        reference: &Reference,
        mut feedforward: Vec<Vec<f64>>,
        has: &dyn Fn(usize) -> bool,
    ) -> Result<Record, Stop> {
        let n = arm.drives.gain.len();
        let dynamics = self.masses(arm, has);
        let zeros = vec![0.0; n];
        let with = |x: &[f64], other: f64| x.iter().copied().chain(vec![other; n]).collect::<Vec<f64>>();
        let controller = JointPd {
            proportional: with(&arm.controller.proportional, 0.0),
            derivative: with(&arm.controller.derivative, 0.0),
            velocity_pole: arm.controller.velocity_pole,
        };
        let drives =
            Drives { gain: with(&arm.drives.gain, 1.0), greatest_torque: with(&arm.drives.greatest_torque, 1.0) };
        let friction: Vec<FrictionLaw> = arm.friction.iter().copied().chain(vec![NO_FRICTION; n]).collect();
        let simulation = Simulation {
            dynamics: &dynamics,
            controller: &controller,
            drives: &drives,
            quantum: &[arm.sensing.quantum.clone(), zeros].concat(),
            friction: &friction,
            steps: Steps::RungeKutta(4),
        };
        let twice = |x: &[Vec<f64>]| x.iter().chain(x).cloned().collect::<Vec<_>>();
        let both = Reference {
            q: twice(&reference.q),
            dq: twice(&reference.dq),
            ddq: twice(&reference.ddq),
            ..reference.clone()
        };
        feedforward.extend(vec![vec![0.0; both.q[0].len()]; n]);
        let (mut record, stop) = simulation.run(&both, Some(&feedforward));
        if stop != Stop::End {
            return Err(stop);
        }
        record.q.truncate(n);
        record.current.truncate(n);
        for k in 0..n {
            let (_, mut acceleration) = circular_differences(&record.q[k], record.sample_time);
            // The difference quotient takes the last and the first sample as neighbours. But the end of the record differs from
            // its start, so this would give an error of 100 A in the last sample.
            let last = acceleration.len() - 1;
            acceleration[0] = acceleration[1];
            acceleration[last] = acceleration[last - 1];
            let rotor = dynamics.rotor[k] / arm.drives.gain[k];
            record.current[k].iter_mut().zip(acceleration).for_each(|(c, a)| *c -= rotor * a);
        }
        Ok(record)
    }
}

fn rigid(arm: &BenchmarkArm, reference: &Reference, feedforward: &[Vec<f64>]) -> Result<Record, Stop> {
    let simulation = Simulation {
        dynamics: arm.dynamics,
        controller: &arm.controller,
        drives: &arm.drives,
        quantum: &arm.sensing.quantum,
        friction: &arm.friction,
        steps: Steps::RungeKutta(2),
    };
    match simulation.run(reference, Some(feedforward)) {
        (record, Stop::End) => Ok(record),
        (_, stop) => Err(stop),
    }
}

/// Adds the sensor noise of draw `draw` to the experiments.
pub fn measured(
    experiments: &[SpectralExperiment],
    arm: &BenchmarkArm,
    sensing: &Sensors,
    seed: u64,
    draw: u64,
) -> Vec<SpectralExperiment> {
    let mut random = Random::stream(seed, draw);
    let mut measure = |e: &SpectralExperiment| {
        let record = Record { sample_time: arm.sample_time, q: e.q.clone(), current: e.current.clone() };
        let noisy = sensing.measure(&record, &arm.drives.gain, &mut random);
        SpectralExperiment { q: noisy.q, current: noisy.current, ..e.clone() }
    };
    experiments.iter().map(&mut measure).collect()
}
