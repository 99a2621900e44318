//! The simulated robots with their drives, controllers, friction and sensors.
//!
//! R3G and R3B: three revolute axes, with and without gravity. RACE: a robot with loops.

use experiments::simulate::closed_loop::{Drives, JointPd, Sensors};
use linear_model::friction::law::FrictionLaw;

use crate::benchmark::scenario::BenchmarkArm;
use crate::tape_robot::TapeRobot;

pub const NO_FRICTION: FrictionLaw = FrictionLaw::asymmetric(0.0, 0.0, 0.0, 0.0);

/// For R3G and R3B (three revolute axes, with and without gravity): velocity limits, rad/s; `ACCELERATION`: acceleration limits,
/// rad/s^2; `NOISE`: standard deviation of the torque per sample, N m.
pub const VELOCITY: [f64; 3] = [5.0, 5.0, 7.0];
pub const ACCELERATION: [f64; 3] = [30.0, 40.0, 60.0];
pub const NOISE: [f64; 3] = [0.20, 0.15, 0.10];

/// A robot with three axes (R3G, R3B, or the robot RACE), with drives, controller, friction and sensors.
pub fn r3_arm<'a>(name: &'static str, robot: &'a TapeRobot) -> BenchmarkArm<'a> {
    let velocity_pole = std::f64::consts::TAU * 150.0;
    BenchmarkArm {
        name,
        regressor: robot,
        dynamics: robot,
        truth: &robot.truth,
        controller: JointPd::for_inertia(&[0.6, 0.30, 0.066], &[10.0, 10.0, 12.0], velocity_pole),
        drives: Drives { gain: vec![2.393, 0.870, 1.0], greatest_torque: vec![40.0, 30.0, 15.0] },
        sensing: Sensors { quantum: vec![1e-4; 3], position_noise: vec![5e-5; 3], torque_noise: NOISE.to_vec() },
        friction: vec![
            FrictionLaw::asymmetric(0.25, 0.60, 0.18, -0.75),
            FrictionLaw::asymmetric(0.15, 0.45, 0.20, -0.35),
            FrictionLaw::asymmetric(0.08, 0.25, 0.06, -0.30),
        ],
        position: vec![(-2.6, 2.6), (-1.5, 1.5), (-2.4, 2.4)],
        velocity: VELOCITY.to_vec(),
        acceleration: ACCELERATION.to_vec(),
        sample_time: 1e-3,
    }
}

/// The robot RACE with the drives, controller and sensors of R3G, and half the friction of R3G.
pub fn race_arm(robot: &TapeRobot) -> BenchmarkArm<'_> {
    let mut arm = r3_arm("RACE", robot);
    arm.friction.iter_mut().for_each(|f| *f = f.scaled(0.5));
    arm
}

/// The PUMA 560 with drives, friction and sensors that fit its size.
pub fn puma_arm(robot: &TapeRobot) -> BenchmarkArm<'_> {
    let law = |f: [f64; 4]| FrictionLaw { smoothing: 0.01, ..FrictionLaw::asymmetric(f[0], f[1], f[2], f[3]) };
    let friction = [
        [4.9, 8.2, 3.5, -8.3],
        [7.7, 11.3, 8.5, -12.8],
        [3.0, 5.6, 3.3, -5.6],
        [1.0, 1.4, 1.2, -1.1],
        [1.4, 1.0, 1.1, -1.3],
        [0.6, 0.5, 0.5, -0.6],
    ];
    let (inertia, bandwidth) = ([4.5, 7.5, 1.9, 0.25, 0.25, 0.22], [4.0, 4.0, 5.0, 6.0, 6.0, 6.0]);
    BenchmarkArm {
        name: "PUMA560",
        regressor: robot,
        dynamics: robot,
        truth: &robot.truth,
        controller: JointPd::for_inertia(&inertia, &bandwidth, std::f64::consts::TAU * 80.0),
        drives: Drives {
            gain: vec![11.4, 23.8, 12.0, 6.4, 6.9, 7.0],
            greatest_torque: vec![97.0, 186.0, 89.0, 24.0, 20.0, 21.0],
        },
        sensing: Sensors {
            quantum: vec![5e-5; 6],
            position_noise: vec![2e-5; 6],
            torque_noise: vec![1.0, 1.5, 0.8, 0.2, 0.2, 0.2],
        },
        friction: friction.map(law).to_vec(),
        position: vec![(-2.5, 2.5), (-2.5, 0.5), (-2.0, 2.6), (-2.0, 2.0), (-1.6, 1.6), (-2.5, 2.5)],
        velocity: vec![1.5, 1.2, 2.0, 4.0, 4.0, 4.0],
        acceleration: vec![10.0, 8.0, 15.0, 30.0, 30.0, 30.0],
        sample_time: 1e-3,
    }
}
