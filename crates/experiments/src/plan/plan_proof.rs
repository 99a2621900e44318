//! The proof of a bound for all plans of experiments: a tree of splits with a design at each leaf.
//!
//! The bound of a leaf follows from its design and the splits above it ([`crate::plan::relaxed_design`]), so the bound of the
//! whole can be recomputed from the tree and the candidates alone. Candidates with the same information count as one: the tree
//! covers plans with the first of them only, since the others cannot improve a plan.

use serde::{Deserialize, Serialize};

use crate::plan::planned_experiment::CandidateMotion;

/// A node of a proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProofNode {
    /// Plans that run a candidate at most `at_most` times, and plans that run it more often.
    Split {
        /// Index of the candidate.
        candidate: usize,
        /// Most runs in the node `below`.
        at_most: usize,
        /// Node of the plans that run it at most `at_most` times.
        below: usize,
        /// Node of the other plans.
        above: usize,
    },
    /// Plans with the bound of the tangent at a design.
    Leaf {
        /// Index of the design.
        design: usize,
    },
}

/// A bound for all plans, with its proof.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlanProof {
    /// Bound of log det F for any plan of the same number of experiments, with rows over their noise.
    pub log_det_at_most: f64,
    /// The candidates in order, so that a reader can compute their rows from the robot description.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub candidates: Vec<CandidateMotion>,
    /// Candidates that plans omit: (candidate, an earlier one with the same information).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub equal: Vec<(usize, usize)>,
    /// Designs: (candidate, number of runs), entries above zero.
    pub designs: Vec<Vec<(usize, f64)>>,
    /// The first node is the root.
    pub tree: Vec<ProofNode>,
}

impl PlanProof {
    /// The proof with the candidates written out.
    pub(crate) fn with_candidates(self, candidates: impl Iterator<Item = CandidateMotion>) -> PlanProof {
        PlanProof { candidates: candidates.collect(), ..self }
    }
}
