//! The search for the best plan with a proof; another package registers it.

use std::sync::OnceLock;

use numerics::information_matrix::WeightedRows;

use crate::plan::plan_proof::PlanProof;

/// The best plan found, with its proof.
#[derive(Clone, Debug, PartialEq)]
pub struct ProvenPlan {
    /// Indices of candidates, ascending.
    pub chosen: Vec<usize>,
    /// log det F.
    pub value: f64,
    /// The proof of an upper bound for all plans.
    pub proof: PlanProof,
}

/// The limits of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchBudget {
    /// Largest number of nodes.
    pub nodes: usize,
    /// Relative gap of the D-efficiency. A bound within it ends the search.
    pub tolerance: f64,
}

/// Finds the best plan of as many experiments as the given plan, from the candidates' rows over their noise, with an upper bound
/// for all such plans; `None` where the candidates together lack full rank.
pub type ProvePlan = fn(&[WeightedRows], &[usize], &SearchBudget) -> Option<ProvenPlan>;

static PROVE: OnceLock<Result<ProvePlan, &'static str>> = OnceLock::new();

/// Sets the search, or the message where there is none; only the first call counts.
pub fn register(prove: Result<ProvePlan, &'static str>) {
    PROVE.get_or_init(|| prove);
}

/// The search, or the reason why there is none.
pub fn registered() -> Result<ProvePlan, &'static str> {
    PROVE.get().copied().unwrap_or(Err("no search of proofs is registered"))
}
