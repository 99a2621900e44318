//! Robots drawn at random, with loops, ratios and equal lengths: their rank is that of an independent regressor.

use tests::random_structures::{structure, wrong};

#[test]
fn two_hundred_robots_have_their_independent_rank() {
    let failed: Vec<String> = (0..200)
        .filter_map(|seed| wrong(seed).map(|why| format!("{seed} {:?}: {why}", structure(seed).kinds)))
        .collect();
    assert!(failed.is_empty(), "{} of 200:\n{}", failed.len(), failed.join("\n"));
    let all: Vec<&str> = (0..200).flat_map(|seed| structure(seed).kinds).collect();
    for kind in ["four-bar", "parallelogram", "crossed", "slider", "ratio", "two coordinates"] {
        assert!(all.iter().filter(|k| **k == kind).count() >= 15, "too few of {kind}");
    }
}
