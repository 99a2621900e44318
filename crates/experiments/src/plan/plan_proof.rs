//! The proof of a bound for all plans of experiments: a tree of splits whose leaves name a design.
//!
//! Every leaf's bound follows from its design and the splits above it ([`crate::plan::relaxed_design`]), so that
//! the bound of the whole can be found again from the tree and the candidates alone. Candidates with the same
//! information count as one. A plan is as good with the first of them, so the tree is about plans without the others.

use numerics::information_matrix::{InformationMatrix, Rows};
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

/// Share of the trace of F_i by which equal candidates differ at most: the rounding of equal rows, a thousandfold.
const EQUAL_CANDIDATES_SHARE: f64 = 1e-12;

/// Which candidates have the same information as an earlier one, and the first of those.
pub(crate) fn equal_candidates(blocks: &[Rows]) -> Vec<(usize, usize)> {
    let of = |b: &Rows| InformationMatrix::sum(b.width(), 0.0, [(b, 1.0)]);
    let squares: Vec<InformationMatrix> = blocks.iter().map(of).collect();
    let is_equal = |a: &InformationMatrix, b: &InformationMatrix, p: usize| {
        let least = EQUAL_CANDIDATES_SHARE * a.trace();
        (0..p).all(|i| (0..=i).all(|j| (a.at(i, j) - b.at(i, j)).abs() <= least))
    };
    let (mut first, mut equal): (Vec<usize>, Vec<(usize, usize)>) = (vec![], vec![]);
    for (i, square) in squares.iter().enumerate() {
        match first.iter().find(|j| is_equal(square, &squares[**j], blocks[i].width())) {
            Some(j) => equal.push((i, *j)),
            None => first.push(i),
        }
    }
    equal
}

impl PlanProof {
    /// A tree of one leaf with this design.
    pub(crate) fn new(equal: Vec<(usize, usize)>, design: Vec<(usize, f64)>) -> PlanProof {
        let tree = vec![ProofNode::Leaf { design: 0 }];
        PlanProof { log_det_at_most: f64::INFINITY, candidates: vec![], equal, designs: vec![design], tree }
    }

    /// The same with the candidates written out.
    pub(crate) fn with_candidates(self, candidates: impl Iterator<Item = CandidateMotion>) -> PlanProof {
        PlanProof { candidates: candidates.collect(), ..self }
    }

    /// Gives a leaf another design.
    pub(crate) fn set_design(&mut self, node: usize, design: Vec<(usize, f64)>) -> usize {
        self.designs.push(design);
        self.tree[node] = ProofNode::Leaf { design: self.designs.len() - 1 };
        self.designs.len() - 1
    }

    /// Splits a leaf into two with the same design: (below, above).
    pub(crate) fn split(&mut self, node: usize, candidate: usize, at_most: usize, design: usize) -> [usize; 2] {
        let (below, above) = (self.tree.len(), self.tree.len() + 1);
        self.tree.extend([ProofNode::Leaf { design }; 2]);
        self.tree[node] = ProofNode::Split { candidate, at_most, below, above };
        [below, above]
    }

    /// Without the designs that no leaf names any more.
    pub(crate) fn without_unused(mut self) -> PlanProof {
        let mut is_used = vec![false; self.designs.len()];
        for node in &self.tree {
            if let ProofNode::Leaf { design } = node {
                is_used[*design] = true;
            }
        }
        let mut places = Vec::new();
        let mut kept = 0;
        for used in &is_used {
            places.push(kept);
            kept += usize::from(*used);
        }
        for node in &mut self.tree {
            if let ProofNode::Leaf { design } = node {
                *design = places[*design];
            }
        }
        let mut used = is_used.into_iter();
        self.designs.retain(|_| used.next().unwrap_or(false));
        self
    }
}
