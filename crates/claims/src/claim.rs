//! A claim: a statement with its evidence. A claim has a subject (such as the zero of joint q2) and the outcome of the check of
//! this subject. The outcome contains the evidence and determines the level of evidence of the claim.

use std::fmt;

use serde::Serialize;

use crate::outcome::Outcome;
use crate::standing::EvidenceLevel;
use crate::subject::Subject;

/// A claim: a subject, and the outcome of its check with the evidence. `Display` prints the claim as a sentence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Claim {
    #[serde(flatten)]
    subject: Subject,
    #[serde(flatten)]
    outcome: Outcome,
}

impl Claim {
    /// Makes a claim from the outcome of a check. An outcome without evidence (an empty text, a number that is not finite) is
    /// replaced by "cannot tell".
    pub fn new(subject: Subject, outcome: Outcome) -> Claim {
        if outcome.has_evidence() {
            return Claim { subject, outcome };
        }
        let (why, would_tell) = ("the check left no evidence".into(), "a check that leaves some".into());
        Claim { subject, outcome: Outcome::CannotTell { why, would_tell } }
    }

    /// The subject of the claim.
    pub fn subject(&self) -> &Subject {
        &self.subject
    }

    /// The outcome of the check.
    pub fn outcome(&self) -> &Outcome {
        &self.outcome
    }
}

impl Claim {
    /// Whether the outcome is a contradiction: the check found a fault.
    pub fn is_contradicted(&self) -> bool {
        self.standing() == EvidenceLevel::Refused
    }

    /// The level of evidence of the claim, from its outcome.
    pub fn standing(&self) -> EvidenceLevel {
        EvidenceLevel::of(&self.outcome)
    }
}

impl fmt::Display for Claim {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.subject, self.outcome)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Bound, Figure};
    use crate::remedy::{Remedy, Trial};
    use crate::subject::Topic;

    /// One claim of each outcome, with `text` and `number` as evidence. "Contradicted" occurs twice: with a tried and with an
    /// untried remedy.
    fn each(text: &str, number: f64) -> [Claim; 7] {
        let (text, figure) = (|| text.to_string(), || Figure::new(number, "deg"));
        let contradicted = |trial| {
            let remedy = Remedy::new("identify", text()).with("offset", 0.05).with("joints", "[q2]");
            Outcome::Contradicted { fault: text(), remedy, trial }
        };
        let outcomes = [
            Outcome::Proven { bound: Bound::AtMost(figure()), derivation: text() },
            Outcome::Agrees { smallest: figure() },
            contradicted(Trial::Tried { quantity: text(), before: figure(), after: figure() }),
            contradicted(Trial::NotTried { why: text() }),
            Outcome::Assumed { what: text(), by: text() },
            Outcome::CannotTell { why: text(), would_tell: text() },
            Outcome::NotLookedAt { why: text(), would_tell: text() },
        ];
        outcomes.map(|outcome| Claim::new(Subject::of(Topic("zero"), ["q2", "q3"]), outcome))
    }

    #[test]
    fn a_claim_says_its_evidence_and_no_flag() {
        let said = each("a text", 0.4).map(|claim| claim.to_string());
        let expected = [
            "proven to be at most 0.4 deg; a text derives it again",
            "agrees; a fault of 0.4 deg would have shown",
            "contradicted: a text; remedy: a text (identify, offset = 0.05, joints = [q2]), tried: a text 0.4 deg before, 0.4 deg after",
            "contradicted: a text; remedy: a text (identify, offset = 0.05, joints = [q2]), not tried, because a text",
            "assumed by a text: a text",
            "cannot tell, because a text; a text would tell",
            "not looked at, because a text; a text would tell",
        ];
        assert_eq!(said, expected.map(|sentence| format!("zero of q2, q3: {sentence}")));
        assert!(said.iter().all(|sentence| !sentence.contains("--")), "{said:?}");
    }

    #[test]
    fn without_evidence_nothing_is_claimed() {
        let carries = |claim: &Claim| {
            !claim.to_string().ends_with("the check left no evidence; a check that leaves some would tell")
        };
        assert_eq!(each("a text", 0.4).map(|c| carries(&c)), [true; 7]);
        assert_eq!(each(" ", 0.4).map(|c| carries(&c)), [false, true, false, false, false, false, false]);
        for number in [f64::NAN, f64::INFINITY] {
            let found = each("a text", number).map(|c| carries(&c));
            assert_eq!(found, [false, false, false, true, true, true, true], "{number}");
        }
    }

    #[test]
    fn a_claim_is_data() {
        let [_, agrees, contradicted, ..] = each("a text", 0.4).map(|claim| serde_json::to_value(claim).unwrap());
        let smallest = serde_json::json!({"value": 0.4, "unit": "deg"});
        let expected =
            serde_json::json!({"topic": "zero", "of": ["q2", "q3"], "outcome": "agrees", "smallest": smallest});
        assert_eq!(agrees, expected);
        assert_eq!(contradicted["remedy"]["fields"], serde_json::json!([["offset", "0.05"], ["joints", "[q2]"]]));
        assert_eq!(contradicted["trial"]["tried"]["before"], smallest);
    }
}
