//! From logs to an estimate: the solution with its intervals, held-out errors and remarks.

pub mod artefact;
pub mod autocorrelation;
pub mod closed_loop;
pub mod consistent;
pub mod cross_talk;
pub mod delay;
pub mod described;
pub mod digits;
pub mod directions;
pub mod drive_gains;
pub mod essential;
pub mod fleet;
pub mod held_out;
pub mod identified;
pub mod identify;
pub mod joint_terms;
pub mod ledger;
pub mod options;
pub mod other_logs;
pub mod passport;
pub mod remarks;
pub mod residuals;
pub mod rotors;
pub mod selection;
pub mod validation;
pub mod verdict;
