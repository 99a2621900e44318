//! What may be said of a log, an estimate, a model, a motion or a plan: claims, each with its evidence.
//!
//! | outcome | says | carries | standing |
//! |---|---|---|---|
//! | proven | for every state or instant | the bound, and what derives it again | `Proven` |
//! | agrees | these data would have shown a fault of this size | the smallest such fault | `Agreed` |
//! | assumed | what was taken for true | by whom | `Assumed` |
//! | cannot tell, not looked at | why | what would tell | `Open` |
//! | contradicted | what is wrong | the remedy, and what it changed where it was tried | `Refused` |
//!
//! A [`Purpose`] needs some subjects, and [`worst`] is the rule for it: the lowest standing among the claims about them. A
//! needed subject that no claim is about is open. Exit code, trust and "proven" follow from that standing alone. What the
//! purpose does not need lowers nothing.
//!
//! A claim without evidence cannot be made: an outcome does not compile without what it carries, and an empty text or a
//! figure that is no finite number is no evidence, so that [`Claim::new`] makes "cannot tell" of it. Claims are written
//! and never read: what a file claims is the file's.
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
//! Not here: any check. The crate knows neither robots nor flags; whoever prints a remedy spells its fields as its user does.

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
pub use left_out::{LeftOut, Matter, Why};
pub use outcome::Outcome;
pub use purpose::{Need, Purpose};
pub use remedy::{Remedy, Trial};
pub use rule::{lowering, worst};
pub use standing::{Standing, Trust};
pub use subject::{Subject, Topic};
