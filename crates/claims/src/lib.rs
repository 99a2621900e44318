//! Claims on a log, an estimate, a model, a motion or a plan. A claim is a statement together with the evidence for it.
//!
//! | outcome | says | carries | level of evidence |
//! |---|---|---|---|
//! | proven | the statement holds for every state or instant | the bound, and the method that derives it again | `Proven` |
//! | agrees | the data show no fault | the smallest fault that the data would have shown | `Agreed` |
//! | assumed | the statement is assumed to be true | the assumption and its source | `Assumed` |
//! | cannot tell, not looked at | the data do not decide; it was not checked | the reason; data that would decide | `Open` |
//! | contradicted | there is a fault | the fault, its remedy, and the effect of the remedy if it was tried | `Refused` |
//!
//! A [`Purpose`] needs claims about certain subjects. [`worst`] gives its level of evidence: the lowest level among these
//! claims. A needed subject without a claim counts as open. The exit code, the trust and the word "proven" follow only from
//! this level. Claims about other subjects do not lower this level.
//!
//! A claim cannot be made without evidence: an outcome without the fields of its evidence does not compile. An empty text or a
//! number that is not finite is not evidence, and [`Claim::new`] replaces it by "cannot tell". Claims are written to files but
//! never read from them, because a claim in a file proves nothing.
//!
//! ```
//! use claims::{Claim, Figure, Outcome, Subject, Topic};
//! const ZERO: Topic = Topic("zero");
//! let claim = Claim::new(Subject::of(ZERO, ["q2"]), Outcome::Agrees { smallest: Figure::new(0.4, "deg") });
//! assert_eq!(claim.to_string(), "zero of q2: agrees; a fault of 0.4 deg would have shown");
//! ```
//! ```compile_fail,E0063
//! # use claims::{Claim, Outcome, Subject, Topic};
//! let claim = Claim::new(Subject::of(Topic("zero"), ["q2"]), Outcome::Agrees {});
//! ```
//! ```compile_fail,E0451
//! # use claims::{Claim, Figure, Outcome, Subject, Topic};
//! let outcome = Outcome::Agrees { smallest: Figure::new(f64::NAN, "deg") };
//! let claim = Claim { subject: Subject::of(Topic("zero"), ["q2"]), outcome };
//! ```
//!
//! The checks are in other crates. This crate does not know robots or command-line flags; the program that prints a remedy
//! translates its fields for the user.

#![warn(missing_docs)]

mod claim;
mod figure;
mod left_out;
mod outcome;
mod purpose;
mod remedy;
mod rule;
mod standing;
mod subject;

pub use claim::Claim;
pub use figure::{Bound, Figure, significant};
pub use left_out::{LeftOut, LeftOutReason, LeftOutTopic};
pub use outcome::Outcome;
pub use purpose::{Need, Purpose};
pub use remedy::{Remedy, Trial};
pub use rule::{lowering, worst};
pub use standing::{EvidenceLevel, Trust};
pub use subject::{Subject, Topic};
