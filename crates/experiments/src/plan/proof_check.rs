//! What finds the proof in a plan's file again: the package that proves plans registers it.

use std::sync::OnceLock;

use linear_model::regressor::Regressor;
use logs::Error;

use crate::plan::experiment_plan::ExperimentPlan;

/// The least D-efficiency that the proof in a plan leaves, found again; `None` where it has none that can be. The text is the
/// plan's file, for messages.
pub type FindProof = fn(&ExperimentPlan, &dyn Regressor, &str) -> Result<Option<f64>, Error>;

static FIND: OnceLock<Result<FindProof, &'static str>> = OnceLock::new();

/// Sets what finds proofs, or what is said where nothing does; only the first call counts.
pub fn register(find: Result<FindProof, &'static str>) {
    FIND.get_or_init(|| find);
}

/// What finds proofs, or why nothing does.
pub fn registered() -> Result<FindProof, &'static str> {
    FIND.get().copied().unwrap_or(Err("no check of proofs is registered"))
}
