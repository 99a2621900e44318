//! Tests how logs with random names, units, order of columns, file shape and clock are read (`tests::scrambled`).
//!
//! `cargo bench --profile dev -p tests --bench scrambled -- [COUNT] [each]`: counts of the outcomes; `each`: prints every log.
//! Fails if a signal is wrong and neither a proposal nor the log check mentions it.

use tests::scrambled::{Outcome, Scrambled, arm};

fn main() {
    tests::register_wings();
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let count: u64 = words.first().and_then(|word| word.parse().ok()).unwrap_or(300);
    let each = words.iter().any(|word| word == "each");
    let folder = tests::program::folder("scrambled");
    let model = arm();
    let names = [
        "right by names",
        "right by proposal",
        "right with --rate",
        "asked",
        "contradicted by doctor",
        "proposed wrongly",
        "wrong in silence",
    ];
    let mut counts = [0; 7];
    for seed in 1..=count {
        let log = Scrambled::of(&model, seed);
        let outcome = log.outcome(&model, &folder.join("log.csv"));
        let place = match outcome {
            Outcome::ByName => 0,
            Outcome::ByProposal => 1,
            Outcome::WithRate => 2,
            Outcome::Asked(_) => 3,
            Outcome::Contradicted(_) => 4,
            Outcome::ProposedWrongly(_) => 5,
            Outcome::Silent(_) => 6,
        };
        counts[place] += 1;
        if each || place > 2 {
            println!("{}: {outcome:?}", log.choices);
        }
    }
    names.iter().zip(counts).for_each(|(name, count)| println!("{name:<24} {count}"));
    assert_eq!(counts[6], 0, "signals that are wrong in silence");
}
