//! Detection rate and false discovery rate of `rist compare` for fleets of 500 robots, of which 25 changed: `cargo bench -p tests
//! --bench fleet`.
//!
//! Arguments: model (path relative to the repository), robots (500), fleets (10), logs of each robot (16), duration of a log, s
//! (8), sizes of the changes in standard deviations (2, 4, .. 10). A rate is the mean over the fleets, because the false
//! discovery rate is defined as a mean; in a single fleet it is uncertain, because only about 26 robots are reported.

use rist::Model;
use tests::benchmark::fleet::{Fleet, Found, simulate};
use tests::workspace;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|w| !w.starts_with("--")).collect();
    let numbers: Vec<usize> = words.iter().filter_map(|w| w.parse().ok()).collect();
    let number = |k: usize, default: usize| numbers.get(k).copied().unwrap_or(default);
    let (robots, fleets, logs, seconds) = (number(0, 500), number(1, 10), number(2, 16), number(3, 8));
    let path = words.iter().find(|w| w.contains('.')).map_or("tests/data/robots/r3g.yaml", String::as_str);
    let model = Model::read(workspace().join(path)).unwrap_or_else(|e| panic!("{e}"));
    let changed = robots / 20;
    println!("{path}: {fleets} fleets, {changed} of {robots} robots changed, {logs} logs of {seconds} s each");
    let sizes = numbers.get(4).map_or(vec![2.0, 4.0, 6.0, 8.0, 10.0], |&size| vec![size as f64]);
    let found: Vec<Vec<(f64, Found)>> = (0..fleets as u64)
        .map(|k| {
            let seed = 100 + k;
            let fleet = Fleet { robots, changed, logs, seconds: seconds as f64, reference_logs: 4 * logs, seed };
            simulate(&model, fleet, &sizes, 0.05)
        })
        .collect();
    println!("| deviations | of one log | false robots | power | false parameters | power |");
    println!("|---|---|---|---|---|---|");
    for (i, size) in sizes.iter().enumerate() {
        let mean = |of: fn(&Found) -> f64| {
            100.0 * found.iter().map(|fleet| of(&fleet[i].1)).sum::<f64>() / found.len().max(1) as f64
        };
        println!(
            "| {size} | {:.2} | {:.1} % | {:.0} % | {:.1} % | {:.0} % |",
            size / (logs as f64).sqrt(),
            mean(Found::false_robots),
            mean(Found::power),
            mean(Found::false_parameters),
            mean(Found::parameter_power)
        );
    }
}
