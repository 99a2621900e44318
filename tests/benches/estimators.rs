//! Tables that compare estimators, also of drive gains: `cargo bench -p tests --bench estimators`.
//!
//! Arguments: number of draws (50; at most 10 for the PUMA), scenarios (all), and tables `R3G`, `R3B`, `gains`, `RACE`, `PUMA560`
//! (all).
//!
//! RIST-MH: the estimator in the frequency domain. R3G, R3B: arms with three revolute axes, with and without gravity; RACE,
//! PUMA560: other simulated robots (`tests::benchmark`). The scenarios differ in sensors and friction.

use experiments::plan::exchange::{Criterion, SearchEffort, exchange};
use experiments::plan::exciting_trajectory::ExcitingTrajectory;
use identification::estimators::drive_gains::likelihood::Gain;
use identification::spectrum::rist_mh::data::HarmonicOptions;
use numerics::information_matrix::WeightedRows;
use tests::benchmark::arms::{puma_arm, r3_arm, race_arm};
use tests::benchmark::candidates::{puma_candidates, race_candidates};
use tests::benchmark::monte_carlo::{Fixture, Method};
use tests::benchmark::plans::{self, chosen, golden_plan, planned_and_random};
use tests::benchmark::robots::{self, r3, with_load};
use tests::benchmark::scenario::{BenchmarkArm, Scenario};

/// The drive gains: the gain of the third joint is known, the other gains are estimated.
const THIRD: [Gain; 3] = [Gain::Free, Gain::Free, Gain::Known(1.0)];

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|w| !w.starts_with("--")).collect();
    let draws = words.iter().find_map(|w| w.parse().ok()).unwrap_or(50);
    let wanted = |name: &str, of: &[&str]| {
        let asked: Vec<&String> = words.iter().filter(|w| of.contains(&w.as_str())).collect();
        asked.is_empty() || asked.iter().any(|w| *w == name)
    };
    let table = |name: &str| wanted(name, &["R3G", "R3B", "gains", "RACE", "PUMA560"]);
    let scenario = |name: &str| wanted(name, &["S1-PD", "S1", "S2", "S3", "S4"]);
    for (name, gravity) in [("R3G", true), ("R3B", false)] {
        if !table(name) {
            continue;
        }
        let robot = r3(gravity);
        let arm = r3_arm(name, &robot);
        let mut plan = golden_plan();
        if !gravity {
            plan.pop();
        }
        for s in Scenario::all(&arm).into_iter().filter(|s| scenario(s.name)) {
            println!("{}", fixture(&arm, s, &plan).compare(&Method::ALL, draws, 11, threads()));
        }
    }
    if table("gains") {
        gains_of_r3g(draws, &scenario);
    }
    if table("RACE") {
        race(draws);
    }
    if table("PUMA560") {
        puma(draws);
    }
}

fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn fixture<'a>(arm: &'a BenchmarkArm, scenario: Scenario, plan: &[ExcitingTrajectory]) -> Fixture<'a> {
    Fixture::new(arm, scenario, plan).expect("the arms of the benchmark are physical")
}

/// Prints the errors of the estimated drive gains. In each draw, the friction model is chosen several times, since it depends on
/// the gains.
fn gains(title: &str, fixture: &Fixture, known: &[Gain], options: &HarmonicOptions, draws: usize) {
    match fixture.compare_gains(known, options, draws, 11, threads()) {
        Some(found) => println!("{title:<32} {found}"),
        None => println!("{title:<32} no gains"),
    }
}

fn equation_5() -> HarmonicOptions {
    HarmonicOptions { ends: true, ..HarmonicOptions::plain() }
}

fn gains_of_r3g(draws: usize, scenario: &dyn Fn(&str) -> bool) {
    let robot = r3(true);
    let mut arm = r3_arm("R3G", &robot);
    println!("R3G drive gains, {draws} draws");
    for s in Scenario::all(&arm).into_iter().filter(|s| scenario(s.name)) {
        let name = s.name;
        let fixture = fixture(&arm, s, &golden_plan());
        gains(&format!("{name} kt3 known, equation (5)"), &fixture, &THIRD, &equation_5(), draws);
        gains(&format!("{name} kt3 known"), &fixture, &THIRD, &HarmonicOptions::default(), draws);
    }
    // A load of 2 kg needs 24 N m of the third drive, whose limit is 15 N m. So all torque limits are raised.
    arm.drives.greatest_torque.iter_mut().for_each(|t| *t *= 3.0);
    for s in Scenario::all(&arm).into_iter().filter(|s| s.name != "S1-PD" && scenario(s.name)) {
        let masses: &[f64] = if s.name == "S1" { &[0.25, 0.5, 1.0, 2.0] } else { &[1.0] };
        for &mass in masses {
            let (loaded, added) = with_load(&robot, mass);
            let fixture = fixture(&arm, s.clone(), &golden_plan());
            let fixture = fixture.with_load(&loaded, &added, &golden_plan()).expect("a load is physical");
            let title = format!("{} load of {mass} kg, none known", s.name);
            gains(&title, &fixture, &[Gain::Free; 3], &HarmonicOptions::default(), draws);
        }
    }
    println!();
}

/// Compares eight planned experiments with eight random ones, for the eighteen parameters of the robot RACE.
fn race(draws: usize) {
    let robot = robots::race();
    let arm = race_arm(&robot);
    let found = race_candidates(&robot);
    let ((plan, value), mut by_chance) = planned_and_random(&found, 200);
    by_chance.sort_by(|a, b| b.1.total_cmp(&a.1));
    let share = |set: &plans::Set| ((set.1 - value) / 18.0).exp();
    println!("RACE drive gains, {draws} draws");
    println!(
        "sets of eight: determinant to the power 1/18 over that of the plan: best of 200 by chance {:.3}, median {:.3}",
        share(&by_chance[0]),
        share(&by_chance[100])
    );
    for (title, set) in [("planned", &plan), ("best of 200", &by_chance[0].0)] {
        let motions = chosen(&found, set);
        println!("{title}");
        for s in Scenario::all(&arm).into_iter().filter(|s| ["S1", "S3", "S4"].contains(&s.name)) {
            let name = s.name;
            let fixture = fixture(&arm, s, &motions);
            gains(&format!("  {name} kt3 known, equation (5)"), &fixture, &THIRD, &equation_5(), draws);
            gains(&format!("  {name} kt3 known"), &fixture, &THIRD, &HarmonicOptions::default(), draws);
        }
    }
    println!();
}

/// Compares 32 experiments of the PUMA 560. At most ten draws, because each draw takes seconds.
fn puma(draws: usize) {
    let robot = robots::puma();
    let arm = puma_arm(&robot);
    let candidates = puma_candidates(&robot);
    let information: Vec<WeightedRows> = candidates.iter().map(|c| c.information.clone()).collect();
    let search = SearchEffort { starts: 2, ..SearchEffort::default() };
    let plan = exchange(&information, 32, Criterion::Determinant, &search, &|_, _, _| ());
    let plan: Vec<ExcitingTrajectory> = plan.chosen.iter().map(|&i| candidates[i].trajectory.clone()).collect();
    for s in Scenario::all(&arm).into_iter().filter(|s| s.name == "S1") {
        println!("{}", fixture(&arm, s, &plan).compare(&Method::ALL, draws.min(10), 11, threads()));
    }
}
