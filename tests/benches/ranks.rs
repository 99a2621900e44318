//! The rank of random robots with loops, ratios and equal lengths, beside an independent one.
//! `cargo bench -p tests --bench ranks -- 1000` (the number of robots).

use std::collections::BTreeMap;

use tests::random_structures::{structure, wrong};

fn main() {
    let count = std::env::args().skip(1).find_map(|word| word.parse().ok()).unwrap_or(1000);
    let mut by_kind: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    let mut failed = Vec::new();
    for seed in 0..count {
        let why = wrong(seed);
        let kinds = structure(seed).kinds;
        for kind in if kinds.is_empty() { vec!["tree"] } else { kinds } {
            let entry = by_kind.entry(kind).or_default();
            entry.0 += 1;
            entry.1 += usize::from(why.is_none());
        }
        failed.extend(why.map(|why| (seed, why)));
    }
    println!("{:<18} {:>7} {:>7}", "has", "robots", "right");
    for (kind, (robots, right)) in by_kind {
        println!("{kind:<18} {robots:>7} {right:>7}");
    }
    println!("{:<18} {count:>7} {:>7}", "all", count as usize - failed.len());
    for (seed, why) in failed {
        println!("{seed}: {why}");
    }
}
