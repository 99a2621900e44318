//! More logs than one machine holds: sums of sufficient statistics, and what changed between two of them.
//!
//! A log becomes triangles ([`Replicate`](replicate::Replicate)). Replicates of equal [`Settings`](settings::Settings)
//! become an [`Accumulator`](accumulator::Accumulator), which is written ([`tri_file`]), merged, solved ([`solution`])
//! and compared with others ([`comparison`]). No row is needed again. Not here, because they need the rows twice:
//! robust weights, the search for a delay, a friction model or drive gains, autocorrelation of residuals from sample to
//! sample.

pub mod accumulator;
pub mod comparison;
pub mod false_discovery;
pub mod replicate;
pub mod settings;
pub mod solution;
pub mod state_cells;
pub mod tri_file;
mod tri_words;
