//! A node of the branch and bound over plans: its evaluation and its split.
//!
//! The relaxed design of a node (with fractional numbers of runs) gives an upper bound of log det F (F: information matrix of a
//! plan). The tangent of log det F at this design, or the tangent of an earlier node with a smaller upper bound, excludes
//! numbers of runs that cannot give a better plan than the best known one. The node is then split at a candidate whose number
//! of runs is not determined yet; candidates with a fractional number come first.

use std::cmp::Ordering;
use std::sync::Arc;

use numerics::information_matrix::WeightedRows;

use experiments::plan::certificate::determinant_bound;
use experiments::plan::exchange::{Criterion, value_of};
use experiments::plan::relaxed_design::{Bounds, Relaxed, Tangent, relaxed};

/// Number of steps of the multiplicative algorithm, which prepares the start design of the root node.
const MULTIPLICATIVE_STEPS: usize = 300;
/// After the multiplicative algorithm, a candidate with less than this number of runs gets zero runs.
const SMALLEST_KEPT_RUNS: f64 = 0.01;
/// Largest number of Newton steps for one node. The steps start at the design of the parent node.
const MAX_NEWTON_STEPS: usize = 12;
/// Largest number of moves (shifts of runs between two candidates) in the ascent that computes how much a split decreases log
/// det F.
const MAX_SPLIT_LOSS_MOVES: usize = 40;
/// A number of runs counts as an integer if it differs from an integer by less than this tolerance.
const WHOLE_RUNS_TOLERANCE: f64 = 1e-4;
/// The multiplicative algorithm ends if log det F is within this distance of its optimum.
const MULTIPLICATIVE_TOLERANCE: f64 = 1e-2;
/// A cut (a bound on the number of runs of a candidate) is not used if its bound is larger than this value.
const MAX_CUT_RUNS: f64 = 1e6;
/// Smallest loss of log det F on a side of a split that counts, as a fraction of (bound of the node - known value).
const LEAST_LOSS_SHARE: f64 = 1e-6;

/// A node that is not evaluated yet.
pub(crate) struct OpenNode {
    pub(crate) bound: f64,
    pub(crate) node: usize,
    pub(crate) bounds: Bounds,
    /// The tangent of log det F with the lowest upper bound so far. `design`: index of the design at which this tangent touches
    /// log det F.
    pub(crate) tangent: Arc<Tangent>,
    pub(crate) design: usize,
    /// The design (number of runs of each candidate) at which the ascent for this node starts.
    pub(crate) x: Arc<Vec<f64>>,
}

impl PartialEq for OpenNode {
    fn eq(&self, other: &OpenNode) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for OpenNode {}

impl PartialOrd for OpenNode {
    fn partial_cmp(&self, other: &OpenNode) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for OpenNode {
    /// The order in which nodes of the search tree are evaluated: the node with the largest bound first; among equal bounds the
    /// oldest node.
    fn cmp(&self, other: &OpenNode) -> Ordering {
        self.bound.total_cmp(&other.bound).then(other.node.cmp(&self.node))
    }
}

/// The candidate experiments that may occur in a plan. Candidates are excluded if they are equal to another candidate, or if
/// they have no runs after the cuts at the root of the tree.
pub(crate) struct RemainingCandidates {
    pub(crate) blocks: Vec<WeightedRows>,
    /// For each remaining candidate, its index among all candidates.
    pub(crate) index: Vec<usize>,
    /// Number of experiments in a plan.
    pub(crate) count: usize,
}

/// A restriction of the number of runs of a candidate experiment. The excluded plans are no better than the best plan known so
/// far: the tangent (a linear upper bound of log det F) shows this. F: information matrix of a plan.
///
/// If `keeps_below`, the candidate runs at most `at_most` times in the remaining plans; otherwise it runs more than `at_most`
/// times.
#[derive(Clone, Copy)]
pub(crate) struct Cut {
    pub(crate) candidate: usize,
    pub(crate) at_most: usize,
    pub(crate) keeps_below: bool,
}

/// The result of the evaluation of a node.
pub(crate) struct NodeBound {
    /// The upper bound of log det F (F: information matrix) over the plans of this node. `better`: tangent and design of this
    /// node, if they give a smaller bound than the parent's tangent.
    pub(crate) bound: f64,
    pub(crate) better: Option<(Tangent, Vec<f64>)>,
    pub(crate) plan: Option<(f64, Vec<usize>)>,
    pub(crate) cuts: Vec<Cut>,
    /// The bounds on the numbers of runs after the cuts.
    pub(crate) bounds: Bounds,
    pub(crate) split: Option<(usize, usize)>,
}

impl OpenNode {
    /// Splits the node in two: plans in which `candidate` has at most `at_most` runs, and plans in which it has more.
    pub(crate) fn halves(&self, candidate: usize, at_most: usize, nodes: [usize; 2], count: usize) -> [OpenNode; 2] {
        let [mut below, mut above] = [self.bounds.clone(), self.bounds.clone()];
        below.high[candidate] = at_most;
        above.low[candidate] = at_most + 1;
        let half = |node, bounds: Bounds| {
            let (bound, _) = self.tangent.bound(&bounds, count);
            OpenNode { bound, node, bounds, design: self.design, tangent: self.tangent.clone(), x: self.x.clone() }
        };
        [half(nodes[0], below), half(nodes[1], above)]
    }
}

impl RemainingCandidates {
    pub(crate) fn of(blocks: &[WeightedRows], index: Vec<usize>, count: usize) -> RemainingCandidates {
        RemainingCandidates { blocks: index.iter().map(|&i| blocks[i].clone()).collect(), index, count }
    }

    /// The design at which the maximization of log det F starts: approximately the best design with real numbers of runs, without
    /// candidates that have almost no runs.
    pub(crate) fn beginning(&self) -> Vec<f64> {
        let weights = determinant_bound(&self.blocks, MULTIPLICATIVE_TOLERANCE, MULTIPLICATIVE_STEPS).weights;
        let runs: Vec<f64> = weights.iter().map(|w| w * self.count as f64).collect();
        runs.into_iter().map(|x| if x < SMALLEST_KEPT_RUNS { 0.0 } else { x }).collect()
    }

    /// A design as stored in the proof: only the candidates with more than zero runs.
    pub(crate) fn design(&self, x: &[f64]) -> Vec<(usize, f64)> {
        self.index.iter().copied().zip(x.iter().copied()).filter(|(_, x)| *x > 0.0).collect()
    }

    /// Evaluates a node of the search tree. `known`: log det F of the best known plan (F: information matrix); a node whose upper
    /// bound is at most `known` is not split. `ascent`: tolerance of the maximization of log det F.
    pub(crate) fn look(&self, open: &OpenNode, known: f64, ascent: f64) -> NodeBound {
        let found = relaxed(&self.blocks, &open.bounds, self.count, &open.x, (known, ascent), MAX_NEWTON_STEPS);
        let mut look = NodeBound {
            bound: open.bound,
            better: None,
            plan: None,
            cuts: vec![],
            bounds: open.bounds.clone(),
            split: None,
        };
        if let Some(plan) = found.as_ref().and_then(|found| rounded(&found.x, &open.bounds, self.count)) {
            let value = value_of(&self.blocks, &plan, Criterion::Determinant);
            look.plan = Some((value, plan.iter().map(|&i| self.index[i]).collect()));
        }
        // The tangent of the parent node may give a smaller upper bound than the design of this node. Then the tangent of the
        // parent is kept.
        let is_better = found.as_ref().is_some_and(|found| found.bound < open.bound);
        look.bound = found.as_ref().filter(|_| is_better).map_or(open.bound, |found| found.bound);
        if look.bound > known {
            let tangent = found.as_ref().filter(|_| is_better).map_or(&*open.tangent, |found| &found.tangent);
            look.cuts = cuts(tangent, &open.bounds, known, self.count);
            look.cuts.iter().for_each(|cut| look.bounds.cut(cut.candidate, cut.at_most, cut.keeps_below));
            look.split = split(found.as_ref(), &open.x, &look.bounds, look.bound - known);
        }
        look.better = found.filter(|_| is_better).map(|found| (found.tangent, found.x));
        look
    }
}

/// The cuts (restrictions of numbers of runs) that follow from a tangent, a linear upper bound of the plans' values. The cuts
/// exclude only plans whose value is at most `known`.
pub(crate) fn cuts(tangent: &Tangent, bounds: &Bounds, known: f64, count: usize) -> Vec<Cut> {
    let (bound, price) = tangent.bound(bounds, count);
    let slack = bound - known;
    let of = |i: usize| {
        let net_gain = tangent.gain[i] - price;
        // One more run (or one less) of candidate i changes the tangent by the net gain. After `steps` such changes in the
        // direction in which the tangent decreases, the tangent is at most the known value.
        let steps = (slack / net_gain.abs()).floor();
        let runs = if steps.is_finite() && steps < MAX_CUT_RUNS { steps.max(0.0) as usize } else { return None };
        let (low, high) = (bounds.low[i], bounds.high[i]);
        let (at_most, keeps_below) =
            if net_gain < 0.0 { (low + runs, true) } else { (high.checked_sub(runs + 1)?, false) };
        ((low..high).contains(&at_most)).then_some(Cut { candidate: i, at_most, keeps_below })
    };
    (0..bounds.low.len()).filter_map(of).collect()
}

/// The candidate at which a node is split, and the largest number of runs on its lower side. `None` if all numbers are
/// determined.
///
/// Among candidates with a fractional number of runs, the candidate with the largest product of two losses is taken: how much
/// the bound decreases, according to a quadratic model, on the lower and on the upper side of the split. A loss counts only up
/// to `slack` (bound minus known value), which is enough to exclude the side. If no number is fractional, the first candidate
/// whose number can vary is taken.
fn split(found: Option<&Relaxed>, above: &[f64], bounds: &Bounds, slack: f64) -> Option<(usize, usize)> {
    let x = found.map_or(above, |found| &found.x);
    let at_most = |i: usize| (x[i].floor().max(bounds.low[i] as f64) as usize).min(bounds.high[i] - 1);
    let varies: Vec<usize> = (0..x.len()).filter(|&i| bounds.low[i] < bounds.high[i]).collect();
    let score = |i: usize| {
        let off = (x[i] - x[i].round()).abs();
        let Some(found) = found.filter(|_| off > WHOLE_RUNS_TOLERANCE) else { return 0.0 };
        let room = bounds.room(x);
        let side = |by: f64| found.model.loss(&room, i, by, MAX_SPLIT_LOSS_MOVES).min(slack);
        let (below, above) = (side(at_most(i) as f64 - x[i]), side((at_most(i) + 1) as f64 - x[i]));
        below.max(LEAST_LOSS_SHARE * slack) * above.max(LEAST_LOSS_SHARE * slack)
    };
    let scored = varies.into_iter().map(|i| (i, score(i)));
    let (candidate, _) = scored.reduce(|a, b| if b.1 > a.1 { b } else { a })?;
    Some((candidate, at_most(candidate)))
}

/// Rounds a design (real numbers of runs) to integer numbers of runs with the sum `count`. `None` if the bounds do not allow
/// this.
fn rounded(x: &[f64], bounds: &Bounds, count: usize) -> Option<Vec<usize>> {
    let whole = |i: usize| ((x[i] + WHOLE_RUNS_TOLERANCE).floor() as usize).clamp(bounds.low[i], bounds.high[i]);
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
