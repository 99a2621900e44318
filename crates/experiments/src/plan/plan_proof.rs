//! The proof of a bound for all plans of experiments: a tree of splits whose leaves name a design.
//!
//! Every leaf's bound follows from its design and the splits above it ([`crate::plan::relaxed_design`]), so that
//! the bound of the whole can be found again from the tree and the candidates alone. Candidates with the same
//! information count as one. A plan is as good with the first of them, so the tree is about plans without the others.

use serde::{Deserialize, Serialize};

use crate::plan::planned_experiment::CandidateMotion;

/// A node of a proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProofNode {
    /// Plans that run a candidate at most so often, and those that run it more often.
    Split {
        /// Index of the candidate.
        candidate: usize,
        /// Most runs in the node `below`.
        at_most: usize,
        /// Node of those that run it at most so often.
        below: usize,
        /// Node of the others.
        above: usize,
    },
    /// Plans that the tangent at a design bounds.
    Leaf {
        /// Index of the design.
        design: usize,
    },
}

/// A bound for all plans, with its proof.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlanProof {
    /// Bound of log det F for any plan of as many experiments, with rows over their noise.
    pub log_det_at_most: f64,
    /// The candidates, in their order, so that a reader can make their rows from the description.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub candidates: Vec<CandidateMotion>,
    /// Candidates that plans do without: (candidate, the one before it with the same information).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub equal: Vec<(usize, usize)>,
    /// Designs: (candidate, how often), of those above zero.
    pub designs: Vec<Vec<(usize, f64)>>,
    /// The first node is the root.
    pub tree: Vec<ProofNode>,
}

impl PlanProof {
    /// The same with the candidates written out.
    pub(crate) fn with_candidates(self, candidates: impl Iterator<Item = CandidateMotion>) -> PlanProof {
        PlanProof { candidates: candidates.collect(), ..self }
    }
}
