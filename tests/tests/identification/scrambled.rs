//! Tests logs with random names, units, order of columns, shape and clock: each is either read correctly, or a claim
//! contradicts it. The bench `scrambled` tests more logs.

use tests::scrambled::{Outcome, Scrambled, arm};

/// Number of random logs. With this number, every shape and all names occur.
const LOGS: u64 = 40;
/// Smallest share of the logs without a hidden fault that must be read correctly and not contradicted.
const MIN_RIGHT_SHARE: f64 = 0.9;

#[test]
fn no_log_is_read_wrongly_in_silence() {
    tests::register_wings();
    let folder = tests::program::folder("scrambled");
    let model = arm();
    let (mut right, mut faultless) = (0, 0);
    for seed in 1..=LOGS {
        let log = Scrambled::of(&model, seed);
        let outcome = log.outcome(&model, &folder.join("log.csv"));
        let is_right = matches!(outcome, Outcome::ByName | Outcome::ByProposal | Outcome::WithRate);
        let is_wrong = matches!(outcome, Outcome::ProposedWrongly(_) | Outcome::Silent(_));
        assert!(!is_wrong, "{}: {outcome:?}", log.choices);
        // A hidden fault does not show in the header of the log. Only the dynamics contradict it.
        assert!(!log.has_hidden_fault || !is_right, "{}: {outcome:?}", log.choices);
        faultless += u32::from(!log.has_hidden_fault);
        right += u32::from(is_right);
    }
    assert!(f64::from(right) >= MIN_RIGHT_SHARE * f64::from(faultless), "{right} of {faultless}");
    assert!(faultless < LOGS as u32, "no log has a hidden fault");
}
