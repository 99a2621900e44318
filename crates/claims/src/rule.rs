//! The rule for the level of evidence of a purpose, such as gravity compensation. A claim is a statement with its evidence. Of
//! all claims about the subjects that the purpose needs, the claim with the lowest level of evidence decides.

use crate::claim::Claim;
use crate::purpose::Purpose;
use crate::standing::EvidenceLevel;

/// The level of evidence of a purpose: the lowest level among its needs.
///
/// An additional claim never raises this level, unless the claim is the first one about a needed subject.
pub fn worst(claims: &[Claim], purpose: &Purpose) -> EvidenceLevel {
    purpose.needs.iter().map(|need| need.standing(claims)).min().unwrap_or(EvidenceLevel::Open)
}

/// The claims that prevent [`Trust::Yes`](crate::Trust::Yes) for a purpose, because their level of evidence is too low.
pub fn lowering<'a>(claims: &'a [Claim], purpose: &Purpose) -> Vec<&'a Claim> {
    let is_low = |claim: &&Claim| purpose.needs.iter().any(|need| need.is_lowered_by(claim));
    claims.iter().filter(is_low).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Bound, Figure};
    use crate::outcome::Outcome;
    use crate::purpose::Need;
    use crate::remedy::{Remedy, Trial};
    use crate::standing::Trust;
    use crate::subject::{Subject, Topic};

    const ZERO: Topic = Topic("zero");
    const FLOOR: Topic = Topic("floor");

    /// One outcome of each kind, from proven to contradicted.
    fn outcomes() -> [Outcome; 6] {
        let (figure, text) = (|| Figure::new(1.0, "m"), || "a text".to_string());
        let trial = Trial::NotTried { why: text() };
        [
            Outcome::Proven { bound: Bound::AtLeast(figure()), derivation: text() },
            Outcome::Agrees { smallest: figure() },
            Outcome::Assumed { what: text(), by: text() },
            Outcome::CannotTell { why: text(), would_tell: text() },
            Outcome::NotLookedAt { why: text(), would_tell: text() },
            Outcome::Contradicted { fault: text(), remedy: Remedy::new("lint", "look"), trial },
        ]
    }

    #[test]
    fn the_rule_is_the_lowest_of_what_is_needed() {
        let joints: [&[&str]; 4] = [&[], &["q1"], &["q2"], &["q1", "q2"]];
        let of = |topic, k: usize| Subject::of(topic, joints[k].iter().copied());
        let subjects = (0..8).map(|k| of(if k < 4 { ZERO } else { FLOOR }, k % 4));
        let pool: Vec<Claim> =
            subjects.flat_map(|s| outcomes().map(|outcome| Claim::new(s.clone(), outcome))).collect();
        let purposes = [
            Purpose::new("any joint", Need::new(of(ZERO, 0))),
            Purpose::new("both joints", Need::new(of(ZERO, 3))),
            Purpose::new("two needs", Need::new(of(ZERO, 2))).and(Need::at_least(of(FLOOR, 0), EvidenceLevel::Assumed)),
            Purpose::new("a proof", Need::at_least(of(ZERO, 0), EvidenceLevel::Proven)),
            Purpose::new("where claimed", Need::where_claimed(of(ZERO, 1))),
            Purpose::new("uncontradicted", Need::uncontradicted(of(ZERO, 2))),
        ];
        // For each purpose and each pair of claims: order and repetition of claims do not change the level, and a second claim
        // does not raise the level.
        for purpose in &purposes {
            let is_told = |claims: &[Claim]| purpose.needs.iter().all(|need| need.has_claims(claims));
            let needs = |claim: &Claim| claim.subject().topic == ZERO || purpose.needs.len() == 2;
            let is_asked = !matches!(purpose.name, "where claimed" | "uncontradicted");
            assert_eq!(worst(&[], purpose) <= EvidenceLevel::Open, is_asked);
            for a in &pool {
                for b in &pool {
                    let one = [a.clone()];
                    let (before, after) = (worst(&one, purpose), worst(&[a.clone(), b.clone()], purpose));
                    let (again, name) = (worst(&[b.clone(), a.clone(), b.clone()], purpose), purpose.name);
                    assert_eq!(after, again, "order, repetition: {a}; {b}");
                    assert!(after <= before || (is_asked && !is_told(&one)), "a claim raises {name}: {a}; {b}");
                    assert!(after == before || needs(b), "{name} does not need {b}");
                }
            }
        }
    }

    #[test]
    fn what_was_asked_for_may_not_stay_open() {
        use EvidenceLevel::{Agreed, Assumed, Proven, Refused};
        let asked = Purpose::new("a motion", Need::at_least(Subject::whole(FLOOR), Assumed));
        let found = outcomes().map(|outcome| worst(&[Claim::new(Subject::whole(FLOOR), outcome)], &asked));
        assert_eq!(found, [Proven, Agreed, Assumed, Refused, Refused, Refused]);
        assert_eq!(worst(&[], &asked), Refused);
    }

    #[test]
    fn what_need_not_be_told_lowers_nothing_where_nobody_tells_it() {
        let need = || Need::uncontradicted(Subject::of(ZERO, ["q1"]));
        let purpose = Purpose::new("one", Need::new(Subject::whole(FLOOR))).and(need());
        let agrees = Claim::new(Subject::whole(FLOOR), outcomes()[1].clone());
        let found = outcomes().map(|outcome| {
            let zero = Claim::new(Subject::of(ZERO, ["q1"]), outcome);
            worst(&[agrees.clone(), zero], &purpose)
        });
        use EvidenceLevel::{Agreed, Open, Refused};
        assert_eq!(found, [Agreed, Agreed, Agreed, Agreed, Agreed, Refused]);
        let counts = Purpose::new("one", Need::where_claimed(Subject::of(ZERO, ["q1"])));
        let found = outcomes().map(|outcome| worst(&[Claim::new(Subject::of(ZERO, ["q1"]), outcome)], &counts));
        use EvidenceLevel::{Assumed, Proven};
        assert_eq!(found, [Proven, Agreed, Assumed, Open, Open, Refused]);
        assert_eq!(worst(&[], &counts), Proven);
        assert_eq!(worst(std::slice::from_ref(&agrees), &purpose), Agreed);
        // A contradiction at another joint does not change the level of this subject.
        let elsewhere = Claim::new(Subject::of(ZERO, ["q2"]), outcomes()[5].clone());
        assert_eq!(worst(&[agrees, elsewhere], &purpose), Agreed);
    }

    #[test]
    fn a_contradiction_of_what_is_needed_is_a_no() {
        let purpose = Purpose::new("one", Need::new(Subject::of(ZERO, ["q1"])));
        let of = |topic, outcome: &Outcome| Claim::new(Subject::whole(topic), outcome.clone());
        let [proven, .., contradicted] = &outcomes();
        assert_eq!(worst(&[of(ZERO, proven), of(ZERO, contradicted)], &purpose).trust(), Trust::No);
        assert!(worst(&[of(ZERO, proven), of(FLOOR, contradicted)], &purpose).is_proven());
    }
}
