//! The best plan of N experiments, proven: branch and bound over how often each candidate is run.
//!
//! A node is a set of bounds low <= x <= high. Its relaxed design ([`crate::experiments::relaxed_design`]) bounds what any
//! plan within can reach. Bounds of variables that the tangent at that design settles are tightened; then the variable
//! that is the farthest from a whole number is split. The node with the greatest bound comes next, so that the bound of
//! the whole falls; it ends within a tolerance, or after so many nodes, with the gap that is left.
//! [Ponte, Fampa, Lee 2023]
//!
//! What is kept is the proof: a tree of splits whose leaves name a design. Every leaf's bound follows from its design and
//! the splits above it, so that the bound of the whole can be found again from the tree and the candidates alone.
//!
//! Not here: the Gamma bound of the same paper, which is the tighter one where N is little above what full rank takes.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::rc::Rc;

use serde::{Deserialize, Serialize};

use crate::algebra::information_matrix::Rows;
use crate::algebra::interruption::Interruption;
use crate::experiments::exchange::{Criterion, scales, value_of};
use crate::experiments::relaxed_design::{Bounds, Tangent, relaxed};

/// A node of a proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProofNode {
    /// Plans that run a candidate at most so often, and those that run it more often.
    Split {
        /// Index of the candidate.
        candidate: usize,
        /// Runs at most, below.
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

/// A proof that no plan is better than it says.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlanProof {
    /// log det F of any plan of as many experiments, rows over their noise.
    pub log_det_at_most: f64,
    /// Designs: (candidate, how often), of those above zero.
    pub designs: Vec<Vec<(usize, f64)>>,
    /// The first node is the root.
    pub tree: Vec<ProofNode>,
}

/// The best plan found, with its proof.
#[derive(Clone, Debug, PartialEq)]
pub struct ProvenPlan {
    /// Indices of candidates, ascending.
    pub chosen: Vec<usize>,
    /// log det F.
    pub value: f64,
    /// What no plan exceeds.
    pub proof: PlanProof,
}

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    /// Nodes at most.
    pub nodes: usize,
    /// Of the D-efficiency: a bound within this share ends the search.
    pub tolerance: f64,
}

/// Steps of an ascent at the root, and at a node, which begins where the one above ended.
const ROOT_STEPS: usize = 3000;
const STEPS: usize = 150;
/// A fraction nearer to a whole number is one.
const WHOLE: f64 = 1e-6;

/// A node still to be looked at.
struct Open {
    bound: f64,
    node: usize,
    bounds: Bounds,
    /// What bounds it so far, and the design of that.
    tangent: Rc<Tangent>,
    design: usize,
    /// Where an ascent begins.
    x: Rc<Vec<f64>>,
}

impl PartialEq for Open {
    fn eq(&self, other: &Open) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Open) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Open {
    /// The greatest bound first, of equals the oldest.
    fn cmp(&self, other: &Open) -> Ordering {
        self.bound.total_cmp(&other.bound).then(other.node.cmp(&self.node))
    }
}

impl Open {
    /// Its plans with at most so many of a candidate, and those with more, at these nodes.
    fn halves(&self, candidate: usize, at_most: usize, nodes: [usize; 2], count: usize) -> [Open; 2] {
        let [mut below, mut above] = [self.bounds.clone(), self.bounds.clone()];
        below.high[candidate] = at_most;
        above.low[candidate] = at_most + 1;
        let half = |node, bounds: Bounds| {
            let (bound, _) = self.tangent.bound(&bounds, count);
            Open { bound, node, bounds, design: self.design, tangent: self.tangent.clone(), x: self.x.clone() }
        };
        [half(nodes[0], below), half(nodes[1], above)]
    }
}

/// A better plan than `chosen` where there is one, and what no plan of as many experiments exceeds; `None` where the
/// candidates together have not full rank, or nothing is chosen. Interrupted, it gives what is proven until then.
pub fn branch_and_bound(blocks: &[Rows], chosen: &[usize], work: &Work) -> Option<ProvenPlan> {
    let p = blocks.first().map_or(0, Rows::width);
    let count = chosen.len();
    let scale = scales(p, blocks.iter());
    let log_scale = 2.0 * scale.iter().map(|s| s.ln()).sum::<f64>();
    let blocks: Vec<Rows> = blocks.iter().map(|b| b.scaled(&scale)).collect();
    let mut best = (value_of(&blocks, chosen, Criterion::Determinant), chosen.to_vec());
    let tolerance = work.tolerance * p as f64;

    let bounds = Bounds { low: vec![0; blocks.len()], high: vec![count; blocks.len()] };
    let even = vec![count as f64 / blocks.len().max(1) as f64; blocks.len()];
    let mut proof = Proof::default();
    let root = relaxed(&blocks, &bounds, count, &even, (f64::NEG_INFINITY, 0.1 * tolerance), ROOT_STEPS)?;
    let (design, node) = (proof.add_design(&root.x), proof.add_leaf(0));
    let mut open = BinaryHeap::new();
    // What leaves that are done with allow.
    let mut closed = f64::NEG_INFINITY;
    let mut looked_at = 0;
    open.push(Open { bound: root.bound, node, bounds, design, tangent: Rc::new(root.tangent), x: Rc::new(root.x) });
    while let Some(mut next) = open.pop() {
        if next.bound <= best.0 + tolerance || looked_at >= work.nodes || Interruption::check().is_err() {
            closed = closed.max(next.bound);
            break;
        }
        looked_at += 1;
        let goal = (best.0 + tolerance, 0.1 * tolerance);
        if let Some(found) = relaxed(&blocks, &next.bounds, count, &next.x, goal, STEPS) {
            if let Some(plan) = rounded(&found.x, &next.bounds, count) {
                let value = value_of(&blocks, &plan, Criterion::Determinant);
                best = if value > best.0 { (value, plan) } else { best };
            }
            next.x = Rc::new(found.x);
            // The tangent above may be the better one here.
            if found.bound < next.bound {
                next.bound = found.bound;
                next.tangent = Rc::new(found.tangent);
                next.design = proof.add_design(&next.x);
                proof.tree[next.node] = ProofNode::Leaf { design: next.design };
            }
        }
        let known = best.0 + tolerance;
        if next.bound > known {
            tighten(&mut next, known, count, &mut proof, &mut closed);
        }
        let Some((candidate, at_most)) = split(&next.x, &next.bounds).filter(|_| next.bound > known) else {
            closed = closed.max(next.bound);
            continue;
        };
        let (below, above) = proof.split(next.node, candidate, at_most, next.design);
        for child in next.halves(candidate, at_most, [below, above], count) {
            if child.bound <= known { closed = closed.max(child.bound) } else { open.push(child) }
        }
    }
    let bound = open.iter().map(|o| o.bound).fold(closed.max(best.0), f64::max);
    let mut chosen = best.1;
    chosen.sort_unstable();
    let proof = PlanProof { log_det_at_most: bound - log_scale, designs: proof.designs, tree: proof.tree };
    Some(ProvenPlan { chosen, value: best.0 - log_scale, proof })
}

/// The tree as it grows.
#[derive(Default)]
struct Proof {
    designs: Vec<Vec<(usize, f64)>>,
    tree: Vec<ProofNode>,
}

impl Proof {
    fn add_design(&mut self, x: &[f64]) -> usize {
        self.designs.push(x.iter().copied().enumerate().filter(|(_, x)| *x > 0.0).collect());
        self.designs.len() - 1
    }

    fn add_leaf(&mut self, design: usize) -> usize {
        self.tree.push(ProofNode::Leaf { design });
        self.tree.len() - 1
    }

    /// Splits a leaf into two with the same design.
    fn split(&mut self, node: usize, candidate: usize, at_most: usize, design: usize) -> (usize, usize) {
        let (below, above) = (self.tree.len(), self.tree.len() + 1);
        self.tree.extend([ProofNode::Leaf { design }; 2]);
        self.tree[node] = ProofNode::Split { candidate, at_most, below, above };
        (below, above)
    }
}

/// Takes away what the tangent shows to hold no plan better than `known`: each cut is a split with a leaf that is done.
fn tighten(next: &mut Open, known: f64, count: usize, proof: &mut Proof, closed: &mut f64) {
    let (bound, price) = next.tangent.bound(&next.bounds, count);
    let slack = bound - known;
    for i in 0..next.bounds.low.len() {
        let worth = next.tangent.gain[i] - price;
        // How far a candidate can be from the bound that its worth sends it to before the tangent falls to what is known.
        let steps = (slack / worth.abs()).floor();
        let reach = if steps.is_finite() && steps < 1e6 { steps.max(0.0) as usize } else { continue };
        let (low, high) = (next.bounds.low[i], next.bounds.high[i]);
        if worth < 0.0 && low + reach < high {
            let (below, _) = proof.split(next.node, i, low + reach, next.design);
            (next.node, next.bounds.high[i]) = (below, low + reach);
            *closed = closed.max(known);
        } else if worth > 0.0 && high > low + reach {
            let (_, above) = proof.split(next.node, i, high - reach - 1, next.design);
            (next.node, next.bounds.low[i]) = (above, high - reach);
            *closed = closed.max(known);
        }
    }
}

/// The candidate to split at and how often it is run at most on one side: the farthest from a whole number, or else the
/// first that can vary.
fn split(x: &[f64], bounds: &Bounds) -> Option<(usize, usize)> {
    let varies = |i: &usize| bounds.low[*i] < bounds.high[*i];
    let off = |i: usize| (x[i] - x[i].round()).abs();
    let all = (0..x.len()).filter(varies);
    let candidate = all.reduce(|a, b| if off(b) > off(a) { b } else { a })?;
    let below = x[candidate].floor().max(bounds.low[candidate] as f64) as usize;
    Some((candidate, below.min(bounds.high[candidate] - 1)))
}

/// The whole numbers nearest to a design with the right sum.
fn rounded(x: &[f64], bounds: &Bounds, count: usize) -> Option<Vec<usize>> {
    let whole = |i: usize| ((x[i] + WHOLE).floor() as usize).clamp(bounds.low[i], bounds.high[i]);
    let mut often: Vec<usize> = (0..x.len()).map(whole).collect();
    let mut order: Vec<usize> = (0..x.len()).filter(|&i| often[i] < bounds.high[i]).collect();
    order.sort_by(|&a, &b| (x[b] - often[b] as f64).total_cmp(&(x[a] - often[a] as f64)).then(a.cmp(&b)));
    let missing = count.checked_sub(often.iter().sum())?;
    if order.len() < missing {
        return None;
    }
    order[..missing].iter().for_each(|&i| often[i] += 1);
    Some(often.iter().enumerate().flat_map(|(i, n)| std::iter::repeat_n(i, *n)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::random::Random;

    fn random_blocks(count: usize, p: usize, seed: u64) -> Vec<Rows> {
        let mut random = Random::new(seed);
        let mut block = || {
            let mut rows = Rows::new(p);
            for _ in 0..1 + random.index(2) {
                rows.push(&(0..p).map(|_| random.normal()).collect::<Vec<_>>());
            }
            rows
        };
        (0..count).map(|_| block()).collect()
    }

    /// From the worst beginning it ends at the best of all plans, and proves it.
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
            let work = Work { nodes: 5000, tolerance: 1e-7 };
            let found = branch_and_bound(&blocks, &worst.1, &work).unwrap();
            // The tolerance, a parameter.
            assert!((found.value - best).abs() < 1e-6, "{seed}: {} {best}", found.value);
            assert!(found.proof.log_det_at_most >= best - 1e-9 && found.proof.log_det_at_most < best + 1e-6);
            // Scaled columns and their scale, against the columns as they are: rounding.
            let again = value_of(&blocks, &found.chosen, Criterion::Determinant);
            assert!((found.value - again).abs() < 1e-12, "{} {again}", found.value);
            // With hardly any work the bound holds, and is not below.
            let short = branch_and_bound(&blocks, &worst.1, &Work { nodes: 2, tolerance: 1e-7 }).unwrap();
            assert!(short.proof.log_det_at_most >= best, "{short:?}");
        }
        let flat = random_blocks(3, 9, 1);
        assert!(branch_and_bound(&flat, &[0, 1, 2], &Work { nodes: 10, tolerance: 1e-3 }).is_none());
    }
}
