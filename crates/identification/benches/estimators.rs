//! The table of estimators on R3G and R3B: `cargo bench -p identification --bench estimators`.
//!
//! Arguments: draws (50), scenarios (all), `R3G` or `R3B` (both).

#[path = "../tests/tree_robot/arm.rs"]
mod arm;
#[path = "../tests/tree_robot/golden.rs"]
mod golden;
#[path = "../tests/tree_robot/mod.rs"]
mod tree_robot;

use identification::{Fixture, Method, Scenario};
use tree_robot::TreeRobot;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|w| !w.starts_with("--")).collect();
    let draws = words.iter().find_map(|w| w.parse().ok()).unwrap_or(50);
    let wanted = |name: &str, of: &[&str]| {
        let asked: Vec<&String> = words.iter().filter(|w| of.contains(&w.as_str())).collect();
        asked.is_empty() || asked.iter().any(|w| *w == name)
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    for (name, gravity) in [("R3G", true), ("R3B", false)] {
        if !wanted(name, &["R3G", "R3B"]) {
            continue;
        }
        let robot = TreeRobot::r3(gravity);
        let arm = arm::benchmark_arm(name, &robot);
        let mut plan = golden::golden_plan();
        if !gravity {
            plan.pop();
        }
        for scenario in Scenario::all(&arm) {
            if !wanted(scenario.name, &["S1-PD", "S1", "S2", "S3", "S4"]) {
                continue;
            }
            match Fixture::new(&arm, scenario, &plan) {
                Ok(fixture) => println!("{}", fixture.compare(&Method::ALL, draws, 11, threads)),
                Err(stop) => println!("{name}: {stop:?}"),
            }
        }
    }
}
