//! The search that proves a plan the best one, and what finds the proof again: another package registers both.

use std::sync::OnceLock;

use linear_model::regressor::Regressor;
use logs::Error;
use numerics::information_matrix::Rows;

use crate::plan::experiment_plan::ExperimentPlan;
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

/// A search with its proof.
#[derive(Clone, Copy)]
pub struct ProofSearch {
    /// The best plan found of as many experiments as the plan given, of candidates by their rows over their noise, and what no such
    /// plan exceeds; `None` where the candidates together have not full rank.
    pub prove: fn(&[Rows], &[usize], &Work) -> Option<ProvenPlan>,
    /// The least D-efficiency that the proof in a plan leaves, found again; `None` where it has none that can be. The text is
    /// the plan's file, for messages.
    pub again: fn(&ExperimentPlan, &dyn Regressor, &str) -> Result<Option<f64>, Error>,
}

static SEARCH: OnceLock<Result<ProofSearch, &'static str>> = OnceLock::new();

/// Sets the search, or what is said where there is none; only the first call counts.
pub fn register(search: Result<ProofSearch, &'static str>) {
    SEARCH.get_or_init(|| search);
}

/// The search, or why there is none.
pub fn registered() -> Result<ProofSearch, &'static str> {
    SEARCH.get().copied().unwrap_or(Err("no search of proofs is registered"))
}
