//! How claims stand; exit code, trust and "proven" follow from it.

use serde::Serialize;

use crate::outcome::Outcome;

/// How claims stand for a purpose, the lowest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// Something is contradicted, or stands lower than the user asked for.
    Refused,
    /// Something cannot be told, or nobody looked.
    Open,
    /// Something is assumed.
    Assumed,
    /// The data agree.
    Agreed,
    /// All is proven.
    Proven,
}

/// Whether to use what was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Trust {
    /// Something says no.
    No,
    /// Something is open or assumed.
    WithCare,
    /// All that is needed agrees or is proven.
    Yes,
}

impl Trust {
    /// The answer in words.
    pub fn word(self) -> &'static str {
        match self {
            Trust::Yes => "yes",
            Trust::WithCare => "with care",
            Trust::No => "no",
        }
    }
}

impl Standing {
    pub(crate) fn of(outcome: &Outcome) -> Standing {
        match outcome {
            Outcome::Proven { .. } => Standing::Proven,
            Outcome::Agrees { .. } => Standing::Agreed,
            Outcome::Assumed { .. } => Standing::Assumed,
            Outcome::CannotTell { .. } | Outcome::NotLookedAt { .. } => Standing::Open,
            Outcome::Contradicted { .. } => Standing::Refused,
        }
    }

    /// Whether to use what was found.
    pub fn trust(self) -> Trust {
        match self {
            Standing::Refused => Trust::No,
            Standing::Open | Standing::Assumed => Trust::WithCare,
            Standing::Agreed | Standing::Proven => Trust::Yes,
        }
    }

    /// Whether "proven" may be said.
    pub fn is_proven(self) -> bool {
        self == Standing::Proven
    }

    /// What the program ends with.
    pub fn exit_code(self) -> u8 {
        u8::from(self == Standing::Refused)
    }
}

#[test]
fn exit_code_trust_and_proven_follow_the_standing() {
    use Standing::{Agreed, Assumed, Open, Proven, Refused};
    let found = [Refused, Open, Assumed, Agreed, Proven].map(|s| (s.exit_code(), s.trust(), s.is_proven()));
    let (no, care, yes) = (Trust::No, Trust::WithCare, Trust::Yes);
    assert_eq!(found, [(1, no, false), (0, care, false), (0, care, false), (0, yes, false), (0, yes, true)]);
}
