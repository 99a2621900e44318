//! What `rist compare` finds in a fleet of 500 robots of which 25 changed: `cargo bench -p tests --bench fleet`.
//!
//! Arguments: robots (500), logs of each (16).

use rist::Model;
use tests::benchmark::fleet::{Fleet, simulate};
use tests::model_path;

fn main() {
    let words: Vec<usize> = std::env::args().skip(1).filter_map(|w| w.parse().ok()).collect();
    let robots = words.first().copied().unwrap_or(500);
    let logs = words.get(1).copied().unwrap_or(16);
    let model = Model::read(model_path("ur5.urdf")).unwrap_or_else(|e| panic!("{e}"));
    let fleet = Fleet { robots, changed: robots / 20, logs, seconds: 8.0, reference_logs: 64, seed: 13 };
    println!("{} of {robots} robots changed, {logs} logs of {} s each", fleet.changed, fleet.seconds);
    println!("| deviations | of one log | false robots | power | false parameters | power |");
    println!("|---|---|---|---|---|---|");
    let sizes = [2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    for (size, found) in simulate(&model, fleet, &sizes, 0.05) {
        println!(
            "| {size} | {:.2} | {:.1} % | {:.0} % | {:.1} % | {:.0} % |",
            size / (logs as f64).sqrt(),
            100.0 * found.false_robots(),
            100.0 * found.power(),
            100.0 * found.false_parameters(),
            100.0 * found.parameter_power()
        );
    }
}
