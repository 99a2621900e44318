//! The experiments a plan of R3G or R3B may choose from.

use identification::experiments::candidates::Candidate;
use identification::experiments::exciting_trajectory::{ExcitingTrajectory, MotionKind};

use crate::tree_robot::{NOISE, TreeRobot, bang_bang};

/// All experiments of the benchmark: 384 with gravity, 372 without.
fn trajectories(gravity: bool) -> Vec<ExcitingTrajectory> {
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
