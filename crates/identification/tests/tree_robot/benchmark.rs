//! R3G and R3B: a three-axis arm with and without gravity, its drives, controller, sensors, and the
//! experiments a plan may choose from.

use identification::{
    BenchmarkArm, Candidate, Controller, Drives, ExcitingTrajectory, FrictionLaw, MotionKind, Profile, Random, Sensing,
};

use super::TreeRobot;

const POSITION: [(f64, f64); 3] = [(-2.6, 2.6), (-1.5, 1.5), (-2.4, 2.4)];
const VELOCITY: [f64; 3] = [5.0, 5.0, 7.0];
const ACCELERATION: [f64; 3] = [30.0, 40.0, 60.0];
const SLOW: [f64; 3] = [0.5; 3];
pub const NOISE: [f64; 3] = [0.20, 0.15, 0.10];

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
        position: POSITION.to_vec(),
        velocity: VELOCITY.to_vec(),
        acceleration: ACCELERATION.to_vec(),
        sample_time: 1e-3,
    }
}

/// Four seconds of a bang-bang swing at the greatest acceleration that respects the velocity.
pub fn bang_bang(kind: MotionKind, fast: usize, slow: &[usize], centre: [f64; 3], period: usize) -> ExcitingTrajectory {
    let acceleration = ACCELERATION[fast].min(4.0 * VELOCITY[fast] / (period as f64 * 1e-3));
    ExcitingTrajectory::swing(kind, fast, slow, &centre, Profile::BangBang, period, acceleration, &SLOW, 4.0, 1e-3)
}

/// All experiments of the benchmark: 384 with gravity, 372 without.
pub fn trajectories(gravity: bool) -> Vec<ExcitingTrajectory> {
    let steps = |low: f64, high: f64, count: usize| {
        (0..count).map(move |i| low + (high - low) * i as f64 / (count - 1) as f64).collect::<Vec<f64>>()
    };
    let (second, third) = (steps(-1.2, 1.2, 9), steps(-2.2, 2.2, 13));
    let mut found = Vec::new();
    for &q3 in &third {
        for q2 in [-0.9, 0.0, 0.9] {
            found.push(bang_bang(MotionKind::Inertial, 1, &[], [0.0, q2, q3], 400));
        }
    }
    for q2 in [-0.9, 0.0, 0.9] {
        for &q3 in third.iter().step_by(2) {
            found.push(bang_bang(MotionKind::Inertial, 2, &[], [0.0, q2, q3], 400));
        }
    }
    for &q2 in &second {
        for &q3 in &third {
            for period in [500, 800] {
                found.push(bang_bang(MotionKind::Mixed, 0, &[1, 2], [0.0, q2, q3], period));
            }
        }
    }
    for q2 in [-0.7, 0.0, 0.7] {
        for &q3 in &third {
            for period in [400, 667] {
                found.push(bang_bang(MotionKind::Mixed, 1, &[2], [0.0, q2, q3], period));
            }
        }
    }
    if gravity {
        for &q3 in third.iter().step_by(2) {
            found.push(ExcitingTrajectory::sweep(1, &[0.0, 0.0, q3], 2.0, 1.0, 1e-3));
        }
        for &q2 in second.iter().step_by(2) {
            found.push(ExcitingTrajectory::sweep(2, &[0.0, q2, 0.0], 3.0, 1.0, 1e-3));
        }
    }
    found
}

pub fn benchmark_candidates(robot: &TreeRobot, gravity: bool) -> Vec<Candidate> {
    trajectories(gravity).into_iter().map(|t| Candidate::new(t, robot, &NOISE)).collect()
}

/// A plan of eight whose determinant is within one per cent of the best known.
pub fn golden_plan() -> Vec<ExcitingTrajectory> {
    let third = |i: f64| 2.2 * i / 6.0;
    let one = |q2, i| bang_bang(MotionKind::Mixed, 0, &[1, 2], [0.0, q2, third(i)], 500);
    let two = |q2, i| bang_bang(MotionKind::Mixed, 1, &[2], [0.0, q2, third(i)], 400);
    vec![
        one(-1.2, -2.0),
        one(-0.3, 0.0),
        one(0.3, -6.0),
        one(1.2, 4.0),
        two(-0.7, -6.0),
        two(0.7, -1.0),
        two(0.7, 5.0),
        ExcitingTrajectory::sweep(1, &[0.0, 0.0, -2.2], 2.0, 1.0, 1e-3),
    ]
}

/// Random configurations of a PUMA 560: 708 experiments for 40 parameters.
pub fn puma_candidates() -> Vec<Candidate> {
    const LOW: [f64; 6] = [-2.5, -2.5, -2.0, -2.0, -1.6, -2.5];
    const HIGH: [f64; 6] = [2.5, 0.5, 2.6, 2.0, 1.6, 2.5];
    const GREATEST: [(f64, f64); 6] = [(1.5, 10.0), (1.2, 8.0), (2.0, 15.0), (4.0, 30.0), (4.0, 30.0), (4.0, 30.0)];
    const PERIOD: [usize; 6] = [1000, 1000, 800, 500, 500, 500];
    const NOISE: [f64; 6] = [1.0, 1.5, 0.8, 0.2, 0.2, 0.2];
    let robot = TreeRobot::puma();
    let mut random = Random::new(9);
    let mut configuration = || {
        let at = |k: usize, i: usize| 0.85 * (LOW[k] + (HIGH[k] - LOW[k]) * i as f64 / 6.0);
        (0..6).map(|k| if k == 0 { 0.0 } else { at(k, random.index(7)) }).collect::<Vec<f64>>()
    };
    let mut found = Vec::new();
    for fast in 0..6 {
        let (velocity, acceleration) = GREATEST[fast];
        let acceleration = acceleration.min(4.0 * velocity / (PERIOD[fast] as f64 * 1e-3));
        let mut companions = vec![(MotionKind::Inertial, vec![])];
        companions.extend((fast + 1..6).map(|l| (MotionKind::Mixed, vec![l])));
        companions.push((MotionKind::Mixed, (fast + 1..6).collect()));
        for (kind, slow) in companions {
            for _ in 0..24 {
                let centre = configuration();
                found.push(ExcitingTrajectory::swing(
                    kind,
                    fast,
                    &slow,
                    &centre,
                    Profile::BangBang,
                    PERIOD[fast],
                    acceleration,
                    &[0.15; 6],
                    4.0,
                    1e-3,
                ));
            }
        }
        if fast > 0 {
            found.extend((0..12).map(|_| ExcitingTrajectory::sweep(fast, &configuration(), 1.5, 0.5, 1e-3)));
        }
    }
    found.into_iter().map(|t| Candidate::new(t, &robot, &NOISE)).collect()
}
