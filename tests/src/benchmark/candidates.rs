//! The candidate experiments from which a plan is chosen.
//!
//! In a candidate, one joint swings fast with bang-bang acceleration (always the largest acceleration, with changing sign), and
//! other joints move slowly or rest. R3G and R3B: arms with three revolute axes, with and without gravity.

use experiments::motion::profile::Profile;
use experiments::plan::candidates::{Candidate, CandidateGrid, MotionLimits, candidates};
use experiments::plan::exciting_trajectory::{ExcitingTrajectory, MovingJoints, SwingCourse};
use experiments::plan::motion_kind::MotionKind;
use random::Random;

use crate::benchmark::arms::{ACCELERATION, NOISE, VELOCITY};
use crate::tape_robot::TapeRobot;

/// Velocities of the joints of R3G and R3B that move slowly while another joint swings fast, rad/s.
const SLOW: [f64; 3] = [0.5; 3];

/// A motion of R3G for four seconds in which joint `fast` swings with bang-bang acceleration: the largest acceleration that keeps
/// the velocity limit. `period`: period of the swing, samples.
pub fn bang_bang(kind: MotionKind, fast: usize, slow: &[usize], centre: [f64; 3], period: usize) -> ExcitingTrajectory {
    let acceleration = ACCELERATION[fast].min(4.0 * VELOCITY[fast] / (period as f64 * 1e-3));
    let joints = MovingJoints { kind, fast, slow, centre: &centre };
    ExcitingTrajectory::swing(&joints, &four_seconds(period, acceleration, &SLOW))
}

/// The settings of a swing with bang-bang acceleration: four seconds, with a sampling period of 1 ms.
fn four_seconds(period: usize, acceleration: f64, slow_velocity: &[f64]) -> SwingCourse<'_> {
    let profile = Profile::BangBang;
    SwingCourse { profile, period, acceleration, slow_velocity, duration: 4.0, sample_time: 1e-3 }
}

/// All candidate experiments of R3G (384, with gravity) or of R3B (372, without gravity).
pub fn r3_candidates(robot: &TapeRobot, gravity: bool) -> Vec<Candidate> {
    r3_trajectories(gravity).into_iter().map(|t| Candidate::new(t, robot, &NOISE)).collect()
}

fn r3_trajectories(gravity: bool) -> Vec<ExcitingTrajectory> {
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

pub fn r3_limits() -> [MotionLimits; 3] {
    let limit = |range: f64, velocity, acceleration| MotionLimits {
        position: (-range, range),
        velocity,
        acceleration,
        slow_velocity: 0.5,
        bandwidth: 10.0,
        quantum: 1e-4,
    };
    [limit(2.6, 5.0, 30.0), limit(1.5, 5.0, 40.0), limit(2.4, 7.0, 60.0)]
}

/// The candidate experiments of the RACE, within the limits of R3G.
pub fn race_candidates(robot: &TapeRobot) -> Vec<Candidate> {
    let grid = CandidateGrid {
        profile: Profile::BangBang,
        steps: 7,
        configurations: 49,
        duration: 4.0,
        sample_time: 1e-3,
        gravity: false,
        seed: 1,
    };
    candidates(&grid, &r3_limits(), robot, &NOISE)
}

/// Candidate experiments of the PUMA 560 at random configurations: 708 experiments, from which 40 parameters are identified.
pub fn puma_candidates(robot: &TapeRobot) -> Vec<Candidate> {
    const LOW: [f64; 6] = [-2.5, -2.5, -2.0, -2.0, -1.6, -2.5];
    const HIGH: [f64; 6] = [2.5, 0.5, 2.6, 2.0, 1.6, 2.5];
    const GREATEST: [(f64, f64); 6] = [(1.5, 10.0), (1.2, 8.0), (2.0, 15.0), (4.0, 30.0), (4.0, 30.0), (4.0, 30.0)];
    const PERIOD: [usize; 6] = [1000, 1000, 800, 500, 500, 500];
    const NOISE: [f64; 6] = [1.0, 1.5, 0.8, 0.2, 0.2, 0.2];
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
                let joints = MovingJoints { kind, fast, slow: &slow, centre: &centre };
                let course = four_seconds(PERIOD[fast], acceleration, &[0.15; 6]);
                found.push(ExcitingTrajectory::swing(&joints, &course));
            }
        }
        if fast > 0 {
            found.extend((0..12).map(|_| ExcitingTrajectory::sweep(fast, &configuration(), 1.5, 0.5, 1e-3)));
        }
    }
    found.into_iter().map(|t| Candidate::new(t, robot, &NOISE)).collect()
}
