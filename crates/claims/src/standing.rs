//! The level of evidence of claims (statements with their evidence) for a purpose of the user, such as gravity compensation.
//! The exit code of the program, the trust, and the word "proven" follow from this level.

use serde::Serialize;

use crate::outcome::Outcome;

/// The level of evidence of claims for a purpose, the lowest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EvidenceLevel {
    /// A needed claim is contradicted, or its level is below the level that the user requires.
    Refused,
    /// A needed subject is undecided, was not checked, or has no claim.
    Open,
    /// A needed claim is an assumption.
    Assumed,
    /// Every needed claim agrees with the data or is proven, and at least one is not proven.
    Agreed,
    /// All needed claims are proven.
    Proven,
}

/// The answer to the question whether the user may use a result for his purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Trust {
    /// A needed claim is contradicted, or its level is below the level that the user requires.
    No,
    /// No needed claim is contradicted, but one is open or assumed.
    WithCare,
    /// Every needed claim agrees with the data or is proven.
    Yes,
}

impl Trust {
    /// The printed answer.
    pub fn word(self) -> &'static str {
        match self {
            Trust::Yes => "yes",
            Trust::WithCare => "with care",
            Trust::No => "no",
        }
    }
}

impl EvidenceLevel {
    pub(crate) fn of(outcome: &Outcome) -> EvidenceLevel {
        match outcome {
            Outcome::Proven { .. } => EvidenceLevel::Proven,
            Outcome::Agrees { .. } => EvidenceLevel::Agreed,
            Outcome::Assumed { .. } => EvidenceLevel::Assumed,
            Outcome::CannotTell { .. } | Outcome::NotLookedAt { .. } => EvidenceLevel::Open,
            Outcome::Contradicted { .. } => EvidenceLevel::Refused,
        }
    }

    /// Whether the user may use a result with this level of evidence.
    pub fn trust(self) -> Trust {
        match self {
            EvidenceLevel::Refused => Trust::No,
            EvidenceLevel::Open | EvidenceLevel::Assumed => Trust::WithCare,
            EvidenceLevel::Agreed | EvidenceLevel::Proven => Trust::Yes,
        }
    }

    /// Whether the result may be called "proven".
    pub fn is_proven(self) -> bool {
        self == EvidenceLevel::Proven
    }

    /// The exit code of the program: 1 if the level is `Refused`, else 0.
    pub fn exit_code(self) -> u8 {
        u8::from(self == EvidenceLevel::Refused)
    }
}

#[test]
fn exit_code_trust_and_proven_follow_the_standing() {
    use EvidenceLevel::{Agreed, Assumed, Open, Proven, Refused};
    let found = [Refused, Open, Assumed, Agreed, Proven].map(|s| (s.exit_code(), s.trust(), s.is_proven()));
    let (no, care, yes) = (Trust::No, Trust::WithCare, Trust::Yes);
    assert_eq!(found, [(1, no, false), (0, care, false), (0, care, false), (0, yes, false), (0, yes, true)]);
}
