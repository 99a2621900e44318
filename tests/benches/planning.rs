//! Plans with their certificates: `cargo bench -p tests --bench planning`.
//!
//! Words choose among `R3G`, `R3B`, `PUMA560` and `scaling` (the planner's time against the number of
//! candidates); none: all.

use std::time::Instant;

use experiments::plan::candidates::Candidate;
use experiments::plan::certificate::{certified_efficiency, condition_bound, determinant_bound};
use experiments::plan::exchange::{Criterion, Search, exchange, value_of};
use numerics::information_matrix::Rows;
use random::Random;
use tests::benchmark::candidates::{puma_candidates, r3_candidates};
use tests::benchmark::robots::{puma, r3};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|w| !w.starts_with("--")).collect();
    let wanted = |name: &str| words.is_empty() || words.iter().any(|w| w == name);
    for (name, gravity) in [("R3G", true), ("R3B", false)] {
        if wanted(name) {
            let candidates = r3_candidates(&r3(gravity), gravity);
            plans(name, &candidates, &[8, 12, 16, 20], 24, 3000);
        }
    }
    if wanted("PUMA560") {
        plans("PUMA560", &puma_candidates(&puma()), &[24, 32, 48], 4, 4000);
    }
    if wanted("scaling") {
        scaling();
    }
}

fn plans(name: &str, candidates: &[Candidate], counts: &[usize], starts: usize, iterations: usize) {
    let information: Vec<Rows> = candidates.iter().map(|c| c.information.clone()).collect();
    let raw: Vec<Rows> = candidates.iter().map(|c| c.raw.clone()).collect();
    let p = information[0].width();
    let clock = Instant::now();
    let bound = determinant_bound(&information, 1e-3, iterations);
    let condition = condition_bound(&raw, 1e-3, iterations);
    println!(
        "{name}: {} candidates, p {p}, log det M* {:.3}, gap {:.4}, cond_fro >= {:.3} (reached {:.3}), {:.1} s",
        candidates.len(),
        bound.log_det,
        bound.gap,
        condition.bound,
        condition.reached,
        clock.elapsed().as_secs_f64()
    );
    let search = Search { starts, ..Search::default() };
    let mut random = Random::new(3);
    for &count in counts {
        let clock = Instant::now();
        let plan = exchange(&information, count, Criterion::Determinant, &search, &|_, _, _| ());
        let seconds = clock.elapsed().as_secs_f64();
        let smallest = exchange(&raw, count, Criterion::FrobeniusCondition, &search, &|_, _, _| ());
        let of_plan = (-value_of(&raw, &plan.chosen, Criterion::FrobeniusCondition)).exp();
        let mut by_chance: Vec<f64> = (0..200)
            .map(|_| {
                let chosen: Vec<usize> = (0..count).map(|_| random.index(candidates.len())).collect();
                let value = value_of(&information, &chosen, Criterion::Determinant);
                certified_efficiency(value, count, p, &bound)
            })
            .collect();
        by_chance.sort_by(f64::total_cmp);
        println!(
            "  N {count}: D-efficiency >= {:.4} in {seconds:.1} s; cond_fro {of_plan:.2}, least {:.2} = {:.3} of the bound; 200 random plans {:.3} median, {:.3} best",
            certified_efficiency(plan.value, count, p, &bound),
            (-smallest.value).exp(),
            (-smallest.value).exp() / condition.bound,
            by_chance[100],
            by_chance[199],
        );
    }
}

/// Seconds for twelve experiments and four starts.
fn scaling() {
    let robot = r3(true);
    let all = r3_candidates(&robot, true);
    for copies in [1, 2, 4, 8] {
        let blocks: Vec<Rows> = all.iter().map(|c| c.information.clone()).collect();
        let blocks: Vec<Rows> = std::iter::repeat_n(blocks, copies).flatten().collect();
        let search = Search { starts: 4, threads: 1, ..Search::default() };
        let clock = Instant::now();
        let plan = exchange(&blocks, 12, Criterion::Determinant, &search, &|_, _, _| ());
        println!("  {} candidates: {:.2} s, log det {:.2}", blocks.len(), clock.elapsed().as_secs_f64(), plan.value);
    }
}
