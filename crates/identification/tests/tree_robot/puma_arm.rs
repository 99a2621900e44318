//! The PUMA 560 with drives, controller, friction and sensors of the specification's benchmark.

use identification::benchmark::scenario::BenchmarkArm;
use identification::model::friction::law::FrictionLaw;
use identification::simulate::closed_loop::{Controller, Drives, Sensing};

use crate::tree_robot::TreeRobot;

pub fn puma_arm(robot: &TreeRobot) -> BenchmarkArm<'_> {
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
        controller: Controller::for_inertia(&inertia, &bandwidth, std::f64::consts::TAU * 80.0),
        drives: Drives {
            gain: vec![11.4, 23.8, 12.0, 6.4, 6.9, 7.0],
            greatest_torque: vec![97.0, 186.0, 89.0, 24.0, 20.0, 21.0],
        },
        sensing: Sensing {
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
