//! Finds the best plan of N experiments with a proof, by branch and bound over the number of runs of each candidate.
//!
//! A node of the tree is a set of bounds low <= x <= high, x: number of runs of each candidate. The relaxed design of a node
//! ([`experiments::plan::relaxed_design`]), with fractional x, gives an upper bound of log det F for all plans of the node (F:
//! information matrix). The tangent of log det F at this design excludes some values of x, so low and high are tightened. The
//! node is then split at the candidate for which the bounds of both sides decrease most, according to a second-order model. The
//! nodes with the largest upper bounds are evaluated next, several in parallel. The search ends when the gap between the upper
//! bound and the best plan is within a tolerance, or after a given number of nodes; the remaining gap is then part of the
//! result. [Ponte, Fampa, Lee 2023]
//!
//! The result contains a proof that can be verified ([`experiments::plan::plan_proof`]).
//!
//! The Gamma bound of the same paper is not used. The Gamma bound is meant for N slightly above the number of runs that gives
//! full rank. Experiments with several rows have full rank with fewer runs than parameters, and the natural bound (see the
//! paper) proves the plans of the robot RACE without the Gamma bound.

use std::collections::BinaryHeap;
use std::sync::Arc;

use numerics::information_matrix::WeightedRows;
use numerics::interruption::Interruption;
use processor::{in_order, threads};

use crate::plan_node::{NodeBound, OpenNode, RemainingCandidates, cuts};
use crate::proof_tree::{ProofTree, equal_candidates};
use experiments::plan::exchange::{Criterion, scales, value_of};
use experiments::plan::proof_search::{ProvenPlan, SearchBudget};
use experiments::plan::relaxed_design::{Bounds, Tangent, relaxed};

/// Largest number of Newton steps at the root of the tree.
const MAX_ROOT_NEWTON_STEPS: usize = 60;
/// A relaxed design (with fractional numbers of runs) is not improved further if its gap to the optimum is below this fraction of
/// the search tolerance.
const ASCENT_TOLERANCE_SHARE: f64 = 0.01;
/// Number of nodes that are evaluated in parallel before the tree is changed. This number does not depend on the number of
/// processors, so the result does not either.
const NODES_PER_BATCH: usize = 16;

/// State of a branch and bound search.
struct TreeSearch {
    choice: RemainingCandidates,
    best: (f64, Vec<usize>),
    /// Tolerance of the search in log det F.
    tolerance: f64,
    proof: ProofTree,
    open: BinaryHeap<OpenNode>,
    /// The largest upper bound of the leaves that need no further search.
    closed: f64,
}

/// Finds the best plan with as many experiments as the plan `chosen`, and an upper bound of log det F for all plans of this size.
///
/// `None` if all candidates together do not have full rank, or if `chosen` is empty. If the search is interrupted, the upper
/// bound is the bound that is proven until then.
pub(crate) fn branch_and_bound(blocks: &[WeightedRows], chosen: &[usize], work: &SearchBudget) -> Option<ProvenPlan> {
    let p = blocks.first().map_or(0, WeightedRows::width);
    let scale = scales(p, blocks.iter());
    let log_scale = 2.0 * scale.iter().map(|s| s.ln()).sum::<f64>();
    let blocks: Vec<WeightedRows> = blocks.iter().map(|b| b.scaled(&scale)).collect();
    let mut search = TreeSearch::at_root(&blocks, chosen, work.tolerance * p as f64)?;
    let mut evaluated = 0;
    while evaluated < work.nodes && Interruption::check().is_ok() {
        let batch = search.next(NODES_PER_BATCH.min(work.nodes - evaluated));
        if batch.is_empty() {
            break;
        }
        evaluated += batch.len();
        search.step(batch);
    }
    let open = search.open.iter().map(|o| o.bound);
    let bound = open.fold(search.closed.max(search.best.0), f64::max);
    let (value, mut chosen) = search.best;
    chosen.sort_unstable();
    let proof = search.proof.bounded(bound - log_scale);
    Some(ProvenPlan { chosen, value: value - log_scale, proof })
}

impl TreeSearch {
    /// The search with only the root of the tree. Equal candidates are merged, and candidates that occur in no better plan are
    /// removed.
    fn at_root(blocks: &[WeightedRows], chosen: &[usize], tolerance: f64) -> Option<TreeSearch> {
        // `known`: a plan counts as better only if its log det F exceeds that of the given plan by more than the tolerance.
        let count = chosen.len();
        let best = (value_of(blocks, chosen, Criterion::Determinant), chosen.to_vec());
        let known = best.0 + tolerance;
        // Equal candidates become one variable, with up to N runs.
        let equal = equal_candidates(blocks);
        let is_kept = |i: &usize| equal.binary_search_by_key(i, |e| e.0).is_err();
        let all = RemainingCandidates::of(blocks, (0..blocks.len()).filter(is_kept).collect(), count);
        let m = all.index.len();
        let bounds = Bounds { low: vec![0; m], high: vec![count; m] };
        let goal = (f64::NEG_INFINITY, ASCENT_TOLERANCE_SHARE * tolerance);
        // The relaxed design (with fractional numbers of runs) bounds log det F of all plans. The tangent of log det F at this
        // design shows which candidates occur in no better plan.
        let root = relaxed(&all.blocks, &bounds, count, &all.beginning(), goal, MAX_ROOT_NEWTON_STEPS)?;
        let mut proof = ProofTree::new(equal, all.design(&root.x));
        let (mut node, mut closed) = (0, f64::NEG_INFINITY);
        let mut left: Vec<usize> = (0..m).collect();
        // Candidates that the tangent limits to zero runs are removed. For each of them, the proof stores a split of the tree.
        for cut in cuts(&root.tangent, &bounds, known, count) {
            if cut.keeps_below && cut.at_most == 0 {
                node = proof.split(node, all.index[cut.candidate], 0, 0)[0];
                left.retain(|i| *i != cut.candidate);
                closed = known;
            }
        }
        // The root node for the remaining candidates. This node gets the relaxed design of all candidates and the tangent at
        // this design, without the entries of the removed candidates.
        let of = |x: &[f64]| -> Vec<f64> { left.iter().map(|&i| x[i]).collect() };
        let first = OpenNode {
            bound: root.bound,
            node,
            bounds: Bounds { low: vec![0; left.len()], high: vec![count; left.len()] },
            design: 0,
            tangent: Arc::new(Tangent { constant: root.tangent.constant, gain: of(&root.tangent.gain) }),
            x: Arc::new(of(&root.x)),
        };
        let choice = RemainingCandidates::of(blocks, left.iter().map(|&i| all.index[i]).collect(), count);
        Some(TreeSearch { choice, best, tolerance, proof, open: BinaryHeap::from([first]), closed })
    }

    /// The value of log det F that a better plan must exceed. A node whose upper bound is at most this value is not searched
    /// further.
    fn known(&self) -> f64 {
        self.best.0 + self.tolerance
    }

    /// Takes at most `most` open nodes from the queue, the nodes with the largest bounds first. Nodes with a bound of at most
    /// `known` are not taken.
    fn next(&mut self, most: usize) -> Vec<OpenNode> {
        let known = self.known();
        let mut batch = Vec::new();
        while batch.len() < most && self.open.peek().is_some_and(|o| o.bound > known) {
            batch.extend(self.open.pop());
        }
        batch
    }

    /// Evaluates nodes, and adds the results to the tree.
    fn step(&mut self, batch: Vec<OpenNode>) {
        let known = self.known();
        let mut looks = Vec::new();
        let look = |_, open: &OpenNode| self.choice.look(open, known, ASCENT_TOLERANCE_SHARE * self.tolerance);
        let done: Result<(), std::convert::Infallible> = in_order(&batch, threads(), look, |_, look| {
            looks.push(look);
            Ok(())
        });
        let Ok(()) = done;
        for (open, look) in batch.into_iter().zip(looks) {
            self.take(open, look, known);
        }
    }

    /// Adds the result `look` for a node to the tree. `known`: the value that a better plan had to exceed when the node was
    /// evaluated.
    fn take(&mut self, mut open: OpenNode, look: NodeBound, known: f64) {
        if let Some(plan) = look.plan.filter(|plan| plan.0 > self.best.0) {
            self.best = plan;
        }
        open.bound = look.bound;
        if let Some((tangent, x)) = look.better {
            open.design = self.proof.set_design(open.node, self.choice.design(&x));
            (open.tangent, open.x) = (Arc::new(tangent), Arc::new(x));
        }
        let Some((candidate, at_most)) = look.split.filter(|_| open.bound > self.known()) else {
            self.closed = self.closed.max(open.bound);
            return;
        };
        for cut in look.cuts {
            let nodes = self.proof.split(open.node, self.choice.index[cut.candidate], cut.at_most, open.design);
            open.node = nodes[usize::from(!cut.keeps_below)];
            self.closed = self.closed.max(known);
        }
        open.bounds = look.bounds;
        let nodes = self.proof.split(open.node, self.choice.index[candidate], at_most, open.design);
        for child in open.halves(candidate, at_most, nodes, self.choice.count) {
            if child.bound <= self.known() {
                self.closed = self.closed.max(child.bound);
            } else {
                self.open.push(child);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::test_plans::random_blocks;

    /// The search starts with the worst plan. The search must find the best of all plans, and prove that no plan is better.
    #[test]
    fn the_best_of_all_small_plans_is_proven() {
        for seed in 1..6 {
            let blocks = random_blocks(9, 3, seed);
            let mut all = Vec::new();
            for code in 0..9_usize.pow(4) {
                let mut plan = vec![code % 9, code / 9 % 9, code / 81 % 9, code / 729];
                plan.sort_unstable();
                all.push((value_of(&blocks, &plan, Criterion::Determinant), plan));
            }
            let best = all.iter().map(|a| a.0).fold(f64::NEG_INFINITY, f64::max);
            let worst = all.iter().filter(|a| a.0.is_finite()).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
            let work = SearchBudget { nodes: 5000, tolerance: 1e-7 };
            let found = branch_and_bound(&blocks, &worst.1, &work).unwrap();
            // The tolerance is per parameter, so the error of log det F may be larger than the tolerance.
            assert!((found.value - best).abs() < 1e-6, "{seed}: {} {best}", found.value);
            assert!(found.proof.log_det_at_most >= best - 1e-9 && found.proof.log_det_at_most < best + 1e-6);
            // One of the values is computed with scaled columns, so the two agree only up to rounding.
            let again = value_of(&blocks, &found.chosen, Criterion::Determinant);
            assert!((found.value - again).abs() < 1e-12, "{} {again}", found.value);
            // After only two nodes the upper bound is still valid: it is not below the value of the best plan.
            let short = branch_and_bound(&blocks, &worst.1, &SearchBudget { nodes: 2, tolerance: 1e-7 }).unwrap();
            assert!(short.proof.log_det_at_most >= best, "{short:?}");
        }
        // Three candidates have at most nine rows together, fewer than the ten parameters. So there is no plan with full rank.
        let flat = random_blocks(3, 10, 1);
        assert!(branch_and_bound(&flat, &[0, 1, 2], &SearchBudget { nodes: 10, tolerance: 1e-3 }).is_none());
    }
}
