//! Everything that a simulation or a plan needs beyond the model. It comes from the robot's file, or from stated
//! defaults where the file does not have it.
//!
//! Defaults: limits of +-1.5 rad, 5 rad/s, 30 rad/s^2; slow velocity 0.5 rad/s; controller of 10 Hz; encoder
//! quantum 1e-4 rad with noise of half of it; torque noise of 1 %, Coulomb friction of about 5 % of the torque
//! A_kk a_max that the greatest acceleration takes; drive gains of one.

use robot::Robot;
use robot::value::CoordinateId;

use crate::algebra::random::Random;
use crate::experiments::candidates::MotionLimits;
use crate::experiments::exciting_trajectory::Reference;
use crate::experiments::record::Record;
use crate::model::friction::law::FrictionLaw;
use crate::simulate::closed_loop::{Controller, Drives, Sensing, Simulation, Stop};
use crate::simulate::dynamics::Dynamics;

/// A simulated robot apart from its dynamics.
#[derive(Clone, Debug)]
pub struct SimulationSetup {
    /// Limits of the motions, one a coordinate.
    pub limits: Vec<MotionLimits>,
    /// Tuned to the robot's inertia.
    pub controller: Controller,
    /// Gains and limits of the drives.
    pub drives: Drives,
    /// Noise and resolution of the sensors.
    pub sensing: Sensing,
    /// One a joint.
    pub friction: Vec<FrictionLaw>,
    /// Sentences on the defaults taken.
    pub notes: Vec<String>,
}

const BANDWIDTH: f64 = 10.0;
const QUANTUM: f64 = 1e-4;

/// Limits of the coordinates, with a note on each default taken.
pub fn motion_limits(robot: &Robot) -> (Vec<MotionLimits>, Vec<String>) {
    let mut taken: Vec<(String, Vec<&str>)> = Vec::new();
    let limits = robot.coordinates.iter().map(|c| {
        let mut note = |text: String| match taken.iter_mut().find(|t| t.0 == text) {
            Some(t) => t.1.push(&c.name),
            None => taken.push((text, vec![&c.name])),
        };
        let mut or = |found: Option<f64>, value: f64, what: &str| match found {
            Some(x) if x.is_finite() && x > 0.0 => x,
            Some(x) => {
                note(format!("{what} of {x} in the file, which leaves no motion; {value} assumed"));
                value
            }
            None => {
                note(format!("no {what} in the file, {value} assumed"));
                value
            }
        };
        let velocity = or(c.limits.velocity, 5.0, "greatest velocity (rad/s)");
        let acceleration = or(c.limits.acceleration, 30.0, "greatest acceleration (rad/s^2)");
        let position = match c.limits.position {
            Some((low, high)) if low < high && low.is_finite() && high.is_finite() => (low, high),
            Some((low, high)) => {
                note(format!("position from {low} to {high} in the file, which leaves no motion; +-1.5 rad assumed"));
                (-1.5, 1.5)
            }
            None => {
                note("no limits of position in the file, +-1.5 rad assumed".into());
                (-1.5, 1.5)
            }
        };
        let slow_velocity = 0.5_f64.min(0.1 * velocity);
        MotionLimits { position, velocity, acceleration, slow_velocity, bandwidth: BANDWIDTH, quantum: QUANTUM }
    });
    let limits = limits.collect();
    (limits, taken.into_iter().map(|(text, names)| format!("{}: {text}", names.join(", "))).collect())
}

impl SimulationSetup {
    /// The setup for a robot with these dynamics.
    pub fn for_robot(robot: &Robot, dynamics: &dyn Dynamics) -> SimulationSetup {
        let (limits, mut notes) = motion_limits(robot);
        let n = limits.len();
        let (mut a, mut h, mut inertia, mut bias) =
            (vec![0.0; n * n], vec![0.0; n], vec![0.0_f64; n], vec![0.0_f64; n]);
        let mut random = Random::new(1);
        for _ in 0..20 {
            let q: Vec<f64> = limits.iter().map(|l| random.between(l.position.0, l.position.1)).collect();
            dynamics.fill(&q, &vec![0.0; n], &mut a, &mut h);
            for k in 0..n {
                inertia[k] += a[k * n + k] / 20.0;
                bias[k] = bias[k].max(h[k].abs());
            }
        }
        let effort: Vec<f64> = (0..n).map(|k| inertia[k] * limits[k].acceleration).collect();
        let joint = |k: usize| robot.joint_of(CoordinateId(k)).map(|j| &robot.link(j).joint);
        let mut gains = Vec::new();
        let mut friction = Vec::new();
        for k in 0..n {
            let name = &robot.coordinates[k].name;
            gains.push(joint(k).and_then(|j| j.drive_gain).unwrap_or(1.0));
            let file = joint(k).map(|j| j.friction).unwrap_or_default();
            if file.coulomb.is_none() {
                notes.push(format!("{name}: no friction in the file, {:.3} N m assumed", 0.05 * effort[k]));
            }
            let coulomb = file.coulomb.unwrap_or(0.05 * effort[k]);
            let viscous = file.viscous.unwrap_or(0.5 * coulomb / limits[k].velocity);
            let offset = file.offset.unwrap_or(0.05 * coulomb);
            friction.push(FrictionLaw::asymmetric(viscous, coulomb + offset, 0.9 * viscous, offset - coulomb));
        }
        let mut greatest = |k: usize| match robot.coordinates[k].limits.effort {
            Some(limit) if limit > 0.0 && limit.is_finite() => limit,
            other => {
                let assumed = 5.0 * effort[k] + 3.0 * bias[k];
                if let Some(limit) = other {
                    let name = &robot.coordinates[k].name;
                    notes.push(format!("{name}: greatest torque of {limit} in the file, {assumed:.3} N m assumed"));
                }
                assumed
            }
        };
        let greatest_torque = (0..n).map(&mut greatest).collect();
        let velocity_pole = 15.0 * std::f64::consts::TAU * BANDWIDTH;
        SimulationSetup {
            controller: Controller::for_inertia(&inertia, &vec![BANDWIDTH; n], velocity_pole),
            drives: Drives { gain: gains, greatest_torque },
            sensing: Sensing {
                quantum: vec![QUANTUM; n],
                position_noise: vec![0.5 * QUANTUM; n],
                torque_noise: effort.iter().map(|e| 0.01 * e).collect(),
            },
            friction,
            limits,
            notes,
        }
    }

    /// The record of a motion, with the noise of the stream `index` of the seed; `None`: without noise.
    pub fn record(
        &self,
        dynamics: &dyn Dynamics,
        reference: &Reference,
        feedforward: Option<&[Vec<f64>]>,
        noise: Option<(u64, u64)>,
    ) -> (Record, Stop) {
        let simulation = Simulation {
            dynamics,
            controller: &self.controller,
            drives: &self.drives,
            quantum: &self.sensing.quantum,
            friction: &self.friction,
            substeps: 2,
        };
        let (record, stop) = simulation.run(reference, feedforward);
        match noise {
            None => (record, stop),
            Some((seed, index)) => {
                let mut random = Random::stream(seed, index);
                (self.sensing.measure(&record, &self.drives.gain, &mut random), stop)
            }
        }
    }
}
