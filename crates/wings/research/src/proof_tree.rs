//! Builds the proof of an upper bound of log det F that holds for all plans: a tree of splits, with a design at each leaf. F:
//! information matrix of a plan.

use experiments::plan::plan_proof::{PlanProof, ProofNode};
use numerics::information_matrix::{InformationMatrix, WeightedRows};

/// The tree of a proof while it is built.
pub(crate) struct ProofTree(PlanProof);

/// Two candidates count as equal if their information matrices F_i differ by at most this fraction of the trace. The fraction
/// is a thousand times the rounding error of equal rows.
const EQUAL_CANDIDATES_SHARE: f64 = 1e-12;

/// Pairs of equal candidates: index of a candidate, and of the first earlier candidate with the same information.
pub(crate) fn equal_candidates(blocks: &[WeightedRows]) -> Vec<(usize, usize)> {
    let of = |b: &WeightedRows| InformationMatrix::sum(b.width(), 0.0, [(b, 1.0)]);
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

impl ProofTree {
    /// A tree with a single leaf, which has this design.
    pub(crate) fn new(equal: Vec<(usize, usize)>, design: Vec<(usize, f64)>) -> ProofTree {
        let tree = vec![ProofNode::Leaf { design: 0 }];
        ProofTree(PlanProof { log_det_at_most: f64::INFINITY, candidates: vec![], equal, designs: vec![design], tree })
    }

    /// Sets a new design at a leaf, and returns the index of the design.
    pub(crate) fn set_design(&mut self, node: usize, design: Vec<(usize, f64)>) -> usize {
        let index = self.0.designs.len();
        self.0.designs.push(design);
        self.0.tree[node] = ProofNode::Leaf { design: index };
        index
    }

    /// Splits a leaf into two leaves with the same design. Returns the indices of the lower and the upper leaf.
    pub(crate) fn split(&mut self, node: usize, candidate: usize, at_most: usize, design: usize) -> [usize; 2] {
        let tree = &mut self.0.tree;
        let (below, above) = (tree.len(), tree.len() + 1);
        tree.extend([ProofNode::Leaf { design }; 2]);
        tree[node] = ProofNode::Split { candidate, at_most, below, above };
        [below, above]
    }

    /// Completes the proof with this bound of log det F. Designs that no leaf uses are removed.
    pub(crate) fn bounded(self, log_det_at_most: f64) -> PlanProof {
        let mut proof = self.0;
        let mut is_used = vec![false; proof.designs.len()];
        for node in &proof.tree {
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
        for node in &mut proof.tree {
            if let ProofNode::Leaf { design } = node {
                *design = places[*design];
            }
        }
        let mut used = is_used.into_iter();
        proof.designs.retain(|_| used.next().unwrap_or(false));
        PlanProof { log_det_at_most, ..proof }
    }
}
