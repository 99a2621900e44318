//! Claims on a log, an estimate, a model, a motion or a plan, each with its evidence.
//!
//! | outcome | says | carries | level of evidence |
//! |---|---|---|---|
//! | proven | for every state or instant | the bound, and what derives it again | `Proven` |
//! | agrees | these data would have shown a fault of this size | the smallest such fault | `Agreed` |
//! | assumed | what was taken for true | by whom | `Assumed` |
//! | cannot tell, not looked at | why | what would decide it | `Open` |
//! | contradicted | what is wrong | the remedy, and what it changed where it was tried | `Refused` |
//!
//! A [`Purpose`] needs some subjects, and [`worst`] is the rule for it: the lowest level of evidence among the claims about
//! them. A needed subject without a claim is open. Exit code, trust and "proven" follow only from this level. Claims about
//! other subjects do not lower it.
//!
//! A claim without evidence cannot be made: an outcome does not compile without its evidence. An empty text or a figure that
//! is no finite number is no evidence; [`Claim::new`] turns it into "cannot tell". Claims are written and never read, because
//! the claims in a file prove nothing.
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
//! Not here: any check. The crate knows neither robots nor flags; the program that prints a remedy spells its fields for the
//! user.

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
