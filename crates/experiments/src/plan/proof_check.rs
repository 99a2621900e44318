//! The function that recomputes the proof in a plan's file; the package that proves plans registers it.

use std::sync::OnceLock;

use linear_model::regressor::Regressor;
use logs::Error;

use crate::plan::experiment_plan::ExperimentPlan;

/// The lower bound of the D-efficiency from the proof in a plan, recomputed; `None` where the plan has no proof that can be
/// checked. The text is the name of the plan's file, for messages.
pub type FindProof = fn(&ExperimentPlan, &dyn Regressor, &str) -> Result<Option<f64>, Error>;

static FIND: OnceLock<Result<FindProof, &'static str>> = OnceLock::new();

/// Sets the function that checks proofs, or the message where there is none; only the first call counts.
pub fn register(find: Result<FindProof, &'static str>) {
    FIND.get_or_init(|| find);
}

/// The function that checks proofs, or the reason why there is none.
pub fn registered() -> Result<FindProof, &'static str> {
    FIND.get().copied().unwrap_or(Err("no check of proofs is registered"))
}
