//! What a check came to, with its evidence.

use std::fmt;

use serde::Serialize;

use crate::figure::{Bound, Figure};
use crate::remedy::{Remedy, Trial};

/// What a check came to. It counts once a [`Claim`](crate::Claim) holds it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "outcome", rename_all = "snake_case")]
pub enum Outcome {
    /// It holds for every state or instant.
    Proven {
        /// What is proven.
        bound: Bound,
        /// What derives it again, as a noun: `interval arithmetic over each period`.
        derivation: String,
    },
    /// These data would have shown a fault.
    Agrees {
        /// The smallest fault that would have shown, at each joint of the subject. Infinite where none would.
        smallest: Figure,
    },
    /// It is taken for true.
    Assumed {
        /// What is: `the base does not move`.
        what: String,
        /// Who said so: `the description`, `the user`, `default`.
        by: String,
    },
    /// The data cannot tell.
    CannotTell {
        /// A clause: `these joints carry too little gravity`.
        why: String,
        /// A noun: `a log in which the shoulder moves`.
        would_tell: String,
    },
    /// Nobody looked.
    NotLookedAt {
        /// A clause: `the mesh of l3 cannot be read`.
        why: String,
        /// A noun.
        would_tell: String,
    },
    /// Something is wrong.
    Contradicted {
        /// What, as a clause: `it is off by 3 deg`.
        fault: String,
        /// What mends it.
        remedy: Remedy,
        /// Whether that was tried.
        trial: Trial,
    },
}

impl Outcome {
    /// Whether each text says something, and each figure is a finite number.
    pub(crate) fn has_evidence(&self) -> bool {
        let says = |texts: &[&String]| texts.iter().all(|text| !text.trim().is_empty());
        let tells = |figure: &Figure| figure.value.is_finite() && says(&[&figure.unit]);
        match self {
            Outcome::Proven { bound, derivation } => tells(bound.figure()) && says(&[derivation]),
            Outcome::Agrees { smallest } => tells(smallest),
            Outcome::Assumed { what, by } => says(&[what, by]),
            Outcome::CannotTell { why, would_tell } | Outcome::NotLookedAt { why, would_tell } => {
                says(&[why, would_tell])
            }
            Outcome::Contradicted { fault, remedy, trial } => {
                let is_told = match trial {
                    Trial::Tried { quantity, before, after } => says(&[quantity]) && tells(before) && tells(after),
                    Trial::NotTried { why } => says(&[why]),
                };
                says(&[fault, &remedy.step, &remedy.sentence]) && is_told
            }
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Outcome::Proven { bound, derivation } => write!(f, "proven to be {bound}; {derivation} derives it again"),
            Outcome::Agrees { smallest } => write!(f, "agrees; a fault of {smallest} would have shown"),
            Outcome::Assumed { what, by } => write!(f, "assumed by {by}: {what}"),
            Outcome::CannotTell { why, would_tell } => {
                write!(f, "cannot be told, because {why}; {would_tell} would tell")
            }
            Outcome::NotLookedAt { why, would_tell } => {
                write!(f, "not looked at, because {why}; {would_tell} would tell")
            }
            Outcome::Contradicted { fault, remedy, trial } => {
                write!(f, "contradicted: {fault}; remedy: {remedy}, {trial}")
            }
        }
    }
}
