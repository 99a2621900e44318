//! Wing (optional package) for fleets: sums of sufficient statistics over more logs than one machine can hold, and changes
//! between two sums.
//!
//! A log becomes triangles (the R of QR decompositions; [`Replicate`](replicate::Replicate)). Replicates with equal
//! [`Settings`](settings::Settings) become an [`Accumulator`], which can be written ([`tri_file`]), merged, solved ([`solution`])
//! and compared with others ([`comparison`]). The rows are not needed again. So methods that need the rows twice are not
//! available: robust weights, the search for a delay, for a friction model or for drive gains, and the autocorrelation of
//! residuals from sample to sample.
//!
//! Interfaces of the core for this wing: `identification` provides the rows of a log as triangles by joint
//! (`rows::observation::Observation`), fits triangles of any logs (`estimators`, `estimate::identify`), and accepts replicates of
//! sums in place of blocks of rows (`estimators::replicate_deviation`). `rist` has the request table and the verdict.

#![warn(missing_docs)]

pub mod accumulator;
mod behrens_fisher;
mod block_deviation;
pub mod comparison;
pub mod false_discovery;
pub mod replicate;
pub mod request;
pub mod settings;
pub mod solution;
pub mod state_cells;
pub mod sums;
#[cfg(test)]
mod test_arm;
pub mod tri_file;
mod tri_words;
pub mod verdict;

pub use accumulator::Accumulator;
pub use comparison::{Compared, Comparison, compare};
pub use request::{AccumulateRequest, CompareRequest, SumsRequest, wing};
pub use sums::{accumulate, accumulator, update};
pub use verdict::sums_verdict;
