//! Tests on random robots with loops, gear ratios and equal lengths. The number of base parameters equals the rank of an
//! independent regressor.

use tests::random_structures::{Outcome, outcome, structure};

#[test]
fn two_hundred_robots_have_their_independent_rank() {
    let (mut wrong, mut refused) = (Vec::new(), Vec::new());
    for seed in 0..200 {
        match outcome(seed) {
            Outcome::Right => {}
            Outcome::Refused(why) => refused.push(format!("{seed} {:?}: {why}", structure(seed).kinds)),
            Outcome::Wrong(why) => wrong.push(format!("{seed} {:?}: {why}", structure(seed).kinds)),
        }
    }
    assert!(wrong.is_empty(), "{} of 200:\n{}", wrong.len(), wrong.join("\n"));
    // The program may refuse a robot for two reasons: a loop does not close in the finite field; or a column is nearly dependent
    // (independent by less than 1e-7).
    assert!(refused.len() <= 2, "{} of 200:\n{}", refused.len(), refused.join("\n"));
    let all: Vec<&str> = (0..200).flat_map(|seed| structure(seed).kinds).collect();
    for kind in ["four-bar", "parallelogram", "crossed", "slider", "ratio", "two coordinates"] {
        assert!(all.iter().filter(|k| **k == kind).count() >= 15, "too few of {kind}");
    }
}
