//! Outcomes of checks. Each outcome contains its evidence: a bound, a number, a reason, or a fault with its remedy. An outcome
//! and its subject make a claim.

use std::fmt;

use serde::Serialize;

use crate::figure::{Bound, Figure};
use crate::remedy::{Remedy, Trial};

/// The outcome of a check, as a part of a [`Claim`](crate::Claim).
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "outcome", rename_all = "snake_case")]
pub enum Outcome {
    /// The statement holds for every state or instant.
    Proven {
        /// The proven bound.
        bound: Bound,
        /// The method by which the bound can be derived again, as a noun: `interval arithmetic over each period`.
        derivation: String,
    },
    /// The data agree with the statement: the check would have detected a fault of the size `smallest`.
    Agrees {
        /// The smallest fault that the check would have detected at every joint of the subject. Infinite if the check would
        /// have detected no fault, however large.
        smallest: Figure,
    },
    /// The statement is assumed to hold.
    Assumed {
        /// The assumption, as a clause: `the base does not move`.
        what: String,
        /// The source of the assumption: `the description`, `the user`, `default`.
        by: String,
    },
    /// The data do not decide whether the statement holds.
    CannotTell {
        /// The reason, as a clause: `these joints carry too little gravity`.
        why: String,
        /// Data that would decide whether the statement holds, as a noun: `a log in which the shoulder moves`.
        would_tell: String,
    },
    /// The statement was not checked.
    NotLookedAt {
        /// The reason, as a clause: `the mesh of l3 cannot be read`.
        why: String,
        /// Data that would allow the check, as a noun.
        would_tell: String,
    },
    /// The check found a fault.
    Contradicted {
        /// The fault, as a clause: `it is off by 3 deg`.
        fault: String,
        /// The command of the program that removes the fault, with its options.
        remedy: Remedy,
        /// Whether the remedy was tried, and the effect of the remedy.
        trial: Trial,
    },
}

impl Outcome {
    /// Whether the outcome has its evidence: no text is empty, and each number is finite and has a unit.
    pub(crate) fn has_evidence(&self) -> bool {
        let says = |texts: &[&String]| texts.iter().all(|text| !text.trim().is_empty());
        let has_figure = |figure: &Figure| figure.value.is_finite() && says(&[&figure.unit]);
        match self {
            Outcome::Proven { bound, derivation } => has_figure(bound.figure()) && says(&[derivation]),
            Outcome::Agrees { smallest } => has_figure(smallest),
            Outcome::Assumed { what, by } => says(&[what, by]),
            Outcome::CannotTell { why, would_tell } | Outcome::NotLookedAt { why, would_tell } => {
                says(&[why, would_tell])
            }
            Outcome::Contradicted { fault, remedy, trial } => {
                let is_told = match trial {
                    Trial::Tried { quantity, before, after } => {
                        says(&[quantity]) && has_figure(before) && has_figure(after)
                    }
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
                write!(f, "cannot tell, because {why}; {would_tell} would tell")
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
