//! The arm of R3G and R3B with its drives, controller and sensors.

use identification::benchmark::scenario::BenchmarkArm;
use identification::model::friction::law::FrictionLaw;
use identification::simulate::closed_loop::{Controller, Drives, Sensing};

use crate::tree_robot::{ACCELERATION, NOISE, TreeRobot, VELOCITY};

/// The benchmark's arm around a robot.
pub fn benchmark_arm<'a>(name: &'static str, robot: &'a TreeRobot) -> BenchmarkArm<'a> {
    let velocity_pole = std::f64::consts::TAU * 150.0;
    BenchmarkArm {
        name,
        regressor: robot,
        dynamics: robot,
        truth: &robot.truth,
        controller: Controller::for_inertia(&[0.6, 0.30, 0.066], &[10.0, 10.0, 12.0], velocity_pole),
        drives: Drives { gain: vec![2.393, 0.870, 1.0], greatest_torque: vec![40.0, 30.0, 15.0] },
        sensing: Sensing { quantum: vec![1e-4; 3], position_noise: vec![5e-5; 3], torque_noise: NOISE.to_vec() },
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
