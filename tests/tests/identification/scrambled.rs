//! Logs with random names, units, order, shape and clock are read rightly, or contradicted. The bench `scrambled` has more draws.

use tests::scrambled::{Outcome, Scrambled, arm};

/// Number of logs: every shape and all names occur.
const LOGS: u64 = 40;
/// Smallest number of logs that are read rightly without contradiction: 90 % of those without a hidden fault.
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
        // A fault that no header shows: only the dynamics contradict it.
        assert!(!log.has_hidden_fault || !is_right, "{}: {outcome:?}", log.choices);
        faultless += u32::from(!log.has_hidden_fault);
        right += u32::from(is_right);
    }
    assert!(f64::from(right) >= MIN_RIGHT_SHARE * f64::from(faultless), "{right} of {faultless}");
    assert!(faultless < LOGS as u32, "no log has a hidden fault");
}
