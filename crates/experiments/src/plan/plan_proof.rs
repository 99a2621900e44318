//! Data of the proof of an upper bound of log det F for all plans of experiments: a tree of splits with a design at each leaf.
//!
//! The bound of a leaf follows from its design and from the splits above the leaf ([`crate::plan::relaxed_design`]). So the bound
//! for all plans can be recomputed from the tree and the candidates alone. If several candidates have the same information, the
//! tree covers only plans with the first of them, because the others cannot improve a plan.

use serde::{Deserialize, Serialize};

use crate::plan::planned_experiment::CandidateMotion;

/// A node of the branch-and-bound tree of a proof; each node covers a set of plans.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProofNode {
    /// Divides the plans of the node into two sets: those that run one candidate at most `at_most` times, and those that run it
    /// more often.
    Split {
        /// Index of the candidate whose number of runs divides the plans.
        candidate: usize,
        /// Greatest number of runs of the candidate in the plans of `below`.
        at_most: usize,
        /// Index of the node of plans with at most `at_most` runs of the candidate.
        below: usize,
        /// Index of the node of plans with more than `at_most` runs of the candidate.
        above: usize,
    },
    /// The upper bound for all plans of this node: the tangent of log det F at one design (numbers of runs). F: information
    /// matrix.
    Leaf {
        /// Index of this design in [`PlanProof::designs`].
        design: usize,
    },
}

/// An upper bound of log det F for all plans, with its proof.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlanProof {
    /// Upper bound of log det F for any plan of the same number of experiments. F: information matrix of the plan, from rows
    /// divided by their noise.
    pub log_det_at_most: f64,
    /// The candidate experiments in their order, so that a reader can compute their rows from the robot description.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub candidates: Vec<CandidateMotion>,
    /// Candidates that the proof omits, as (omitted candidate, earlier candidate with the same information).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub equal: Vec<(usize, usize)>,
    /// The designs of the leaves. A design is a list of (candidate, fractional number of runs), without zeros.
    pub designs: Vec<Vec<(usize, f64)>>,
    /// The nodes of the tree; the first node is the root.
    pub tree: Vec<ProofNode>,
}

impl PlanProof {
    /// The proof with the motions of all candidates, so that the file alone is sufficient for a check.
    pub(crate) fn with_candidates(self, candidates: impl Iterator<Item = CandidateMotion>) -> PlanProof {
        PlanProof { candidates: candidates.collect(), ..self }
    }
}
