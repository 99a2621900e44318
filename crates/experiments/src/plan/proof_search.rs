//! The search that proves a plan the best one: another package registers it.

use std::sync::OnceLock;

use numerics::information_matrix::Rows;

use crate::plan::plan_proof::PlanProof;

/// The best plan found, with its proof.
#[derive(Clone, Debug, PartialEq)]
pub struct ProvenPlan {
    /// Indices of candidates, ascending.
    pub chosen: Vec<usize>,
    /// log det F.
    pub value: f64,
    /// The proof of a bound that no plan exceeds.
    pub proof: PlanProof,
}

/// The limits of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    /// Largest number of nodes.
    pub nodes: usize,
    /// Share of the D-efficiency. A bound within it ends the search.
    pub tolerance: f64,
}

/// The best plan found of as many experiments as the plan given, of candidates by their rows over their noise, and what no such
/// plan exceeds; `None` where the candidates together have not full rank.
pub type ProvePlan = fn(&[Rows], &[usize], &Work) -> Option<ProvenPlan>;

static PROVE: OnceLock<Result<ProvePlan, &'static str>> = OnceLock::new();

/// Sets the search, or what is said where there is none; only the first call counts.
pub fn register(prove: Result<ProvePlan, &'static str>) {
    PROVE.get_or_init(|| prove);
}

/// The search, or why there is none.
pub fn registered() -> Result<ProvePlan, &'static str> {
    PROVE.get().copied().unwrap_or(Err("no search of proofs is registered"))
}
