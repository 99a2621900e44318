//! Plans for the simulated robots: one that is given here, and plans that a search finds.
//!
//! A plan is a set of experiments, chosen among candidates. A search makes the determinant of its information matrix large.

use experiments::plan::candidates::Candidate;
use experiments::plan::exchange::{Criterion, SearchEffort, exchange, value_of};
use experiments::plan::exciting_trajectory::ExcitingTrajectory;
use experiments::plan::motion_kind::MotionKind;
use numerics::information_matrix::WeightedRows;
use random::Random;

use crate::benchmark::candidates::bang_bang;

/// A plan of eight experiments for R3G (three revolute axes, with gravity). The determinant of its information matrix is within 1
/// % of the best known plan. Its last experiment is a slow sweep, which only determines gravity parameters.
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

/// A set of experiments as indices of candidates, and the logarithm of the determinant of its information matrix.
pub type Set = (Vec<usize>, f64);

/// The best set of eight experiments that a search finds, and `count` random sets of eight.
pub fn planned_and_random(found: &[Candidate], count: usize) -> (Set, Vec<Set>) {
    let information: Vec<WeightedRows> = found.iter().map(|c| c.information.clone()).collect();
    let search = SearchEffort { starts: 6, ..SearchEffort::default() };
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

/// The experiments of a set, given by indices of candidates.
pub fn chosen(found: &[Candidate], set: &[usize]) -> Vec<ExcitingTrajectory> {
    set.iter().map(|&i| found[i].trajectory.clone()).collect()
}
