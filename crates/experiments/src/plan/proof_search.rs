//! Registry for the function that finds the best plan with a proof (branch and bound). Another package registers this function,
//! so this crate does not depend on that package.

use std::sync::OnceLock;

use numerics::information_matrix::WeightedRows;

use crate::plan::plan_proof::PlanProof;

/// The best plan that the search found, with a proof of how good it is.
#[derive(Clone, Debug, PartialEq)]
pub struct ProvenPlan {
    /// Indices of the chosen candidates, ascending.
    pub chosen: Vec<usize>,
    /// log det F of the plan; F: its information matrix.
    pub value: f64,
    /// The proof of an upper bound of log det F for all plans.
    pub proof: PlanProof,
}

/// Conditions that end the search for the best plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchBudget {
    /// Greatest number of nodes of the branch-and-bound tree.
    pub nodes: usize,
    /// The search ends when the D-efficiency is proved up to this relative gap.
    pub tolerance: f64,
}

/// Finds the best plan. Arguments: the regressor rows of each candidate (divided by their noise), an initial plan, which also
/// gives the number of experiments, and the budget. `None` if all candidates together do not have full rank.
pub type ProvePlan = fn(&[WeightedRows], &[usize], &SearchBudget) -> Option<ProvenPlan>;

static PROVE: OnceLock<Result<ProvePlan, &'static str>> = OnceLock::new();

/// Registers the search for the best plan, or a message why there is none. Only the first call has an effect.
pub fn register(prove: Result<ProvePlan, &'static str>) {
    PROVE.get_or_init(|| prove);
}

/// The registered search for the best plan, or the message why there is none.
pub fn registered() -> Result<ProvePlan, &'static str> {
    PROVE.get().copied().unwrap_or(Err("no search of proofs is registered"))
}
