//! The experiments that identify the RACE arm.

use identification::algebra::information_matrix::Rows;
use identification::algebra::random::Random;
use identification::experiments::candidates::{Candidate, CandidateGrid, MotionLimits, candidates};
use identification::experiments::exchange::{Criterion, Search, exchange, value_of};
use identification::experiments::exciting_trajectory::ExcitingTrajectory;
use identification::experiments::profile::Profile;

use crate::tree_robot::{NOISE, TreeRobot};

/// Every experiment a plan may choose from; the limits are those of the arm R3G.
pub fn race_candidates(robot: &TreeRobot) -> Vec<Candidate> {
    let limit = |range: f64, velocity, acceleration| MotionLimits {
        position: (-range, range),
        velocity,
        acceleration,
        slow_velocity: 0.5,
        bandwidth: 10.0,
        quantum: 1e-4,
    };
    let limits = [limit(2.6, 5.0, 30.0), limit(1.5, 5.0, 40.0), limit(2.4, 7.0, 60.0)];
    let grid = CandidateGrid {
        profile: Profile::BangBang,
        steps: 7,
        configurations: 49,
        duration: 4.0,
        sample_time: 1e-3,
        gravity: false,
        seed: 1,
    };
    candidates(&grid, &limits, robot, &NOISE)
}

/// A set of experiments and the logarithm of its determinant.
pub type Set = (Vec<usize>, f64);

/// The best eight, and `count` sets of eight by chance.
pub fn planned_and_random(found: &[Candidate], count: usize) -> (Set, Vec<Set>) {
    let information: Vec<Rows> = found.iter().map(|c| c.information.clone()).collect();
    let search = Search { starts: 6, ..Search::default() };
    let plan = exchange(&information, 8, Criterion::Determinant, &search, &|_, _, _| ());
    let mut random = Random::new(5);
    let by_chance = (0..count).map(|_| {
        let chosen: Vec<usize> = (0..8).map(|_| random.index(found.len())).collect();
        let value = value_of(&information, &chosen, Criterion::Determinant);
        (chosen, value)
    });
    let by_chance = by_chance.collect();
    ((plan.chosen, plan.value), by_chance)
}

pub fn chosen(found: &[Candidate], set: &[usize]) -> Vec<ExcitingTrajectory> {
    set.iter().map(|&i| found[i].trajectory.clone()).collect()
}
