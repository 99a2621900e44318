//! Registry for the function that checks the proof in a plan's file. The package that proves plans registers this function, so
//! this crate does not depend on that package.

use std::sync::OnceLock;

use linear_model::regressor::Regressor;
use logs::Error;

use crate::plan::experiment_plan::ExperimentPlan;

/// Recomputes the lower bound of the D-efficiency of a plan from the proof in its file. The text argument is the name of this
/// file, for messages. `None` if the plan has no proof that can be checked.
pub type FindProof = fn(&ExperimentPlan, &dyn Regressor, &str) -> Result<Option<f64>, Error>;

static FIND: OnceLock<Result<FindProof, &'static str>> = OnceLock::new();

/// Registers the function that checks proofs, or a message why there is none. Only the first call has an effect.
pub fn register(find: Result<FindProof, &'static str>) {
    FIND.get_or_init(|| find);
}

/// The registered function that checks proofs, or the message why there is none.
pub fn registered() -> Result<FindProof, &'static str> {
    FIND.get().copied().unwrap_or(Err("no check of proofs is registered"))
}
