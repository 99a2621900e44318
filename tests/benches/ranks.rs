//! The rank of random robots with loops, ratios and equal lengths, beside an independent one.
//! `cargo bench -p tests --bench ranks -- 1000` (the number of robots).

use std::collections::BTreeMap;

use tests::random_structures::{Outcome, outcome, structure};

fn main() {
    let count = std::env::args().skip(1).find_map(|word| word.parse().ok()).unwrap_or(1000);
    let mut by_kind: BTreeMap<&str, [usize; 3]> = BTreeMap::new();
    let mut told = Vec::new();
    for seed in 0..count {
        let (place, why) = match outcome(seed) {
            Outcome::Right => (0, None),
            Outcome::Refused(why) => (1, Some(why)),
            Outcome::Wrong(why) => (2, Some(why)),
        };
        let kinds = structure(seed).kinds;
        for kind in ["all"].into_iter().chain(if kinds.is_empty() { vec!["tree"] } else { kinds }) {
            by_kind.entry(kind).or_default()[place] += 1;
        }
        told.extend(why.map(|why| format!("{seed} {}: {why}", ["right", "refused", "wrong"][place])));
    }
    println!("{:<18} {:>7} {:>7} {:>7}", "has", "right", "refused", "wrong");
    for (kind, [right, refused, wrong]) in by_kind {
        println!("{kind:<18} {right:>7} {refused:>7} {wrong:>7}");
    }
    told.iter().for_each(|line| println!("{line}"));
}
