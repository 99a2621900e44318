//! The slots in which a tape holds the values of nodes. A slot is reused as soon as its value is dead.

use crate::function::{Function, operands};
use crate::fusion::Fusion;
use crate::graph::{Expr, Node};

/// For each sine the cosine of the same angle, and the other way round: the two are one operation, at the place of the
/// first.
pub(crate) fn partners(nodes: &[Node]) -> Vec<Option<usize>> {
    let mut partner = vec![None; nodes.len()];
    let mut angles = std::collections::BTreeMap::new();
    for (i, node) in nodes.iter().enumerate() {
        if let Node::Sin(a) | Node::Cos(a) = node
            && let Some(first) = angles.insert(*a, i)
        {
            partner[first] = Some(i);
            partner[i] = Some(first);
        }
    }
    partner
}

/// For each node the last one that reads it. Inputs and outputs stay alive to the end.
pub(crate) fn last_uses(function: &Function, fusion: &Fusion) -> Vec<usize> {
    let nodes = function.graph().nodes();
    let partner = partners(nodes);
    let mut last_use = vec![0; nodes.len()];
    for (i, &node) in nodes.iter().enumerate() {
        // The first of a sine and its cosine reads their angle for both.
        let is_first = partner[i].is_none_or(|other| other > i);
        let angle = operands(node).filter(|_| is_first && matches!(node, Node::Sin(_) | Node::Cos(_)));
        for e in fusion.operands_of(i).chain(angle) {
            last_use[e.node()] = i;
        }
    }
    let (outputs, inputs) = (function.outputs.iter().map(|o| &o.entries), function.inputs.iter().map(|i| &i.entries));
    for e in outputs.chain(inputs).flatten() {
        last_use[e.node()] = usize::MAX;
    }
    last_use
}

/// The slots of a tape, as they are taken and given back.
pub(crate) struct Slots {
    free: Vec<u32>,
    n_slots: usize,
    slot: Vec<Option<u32>>,
}

impl Slots {
    /// No slot yet, for this many nodes.
    pub(crate) fn new(nodes: usize) -> Slots {
        Slots { free: Vec::new(), n_slots: 0, slot: vec![None; nodes] }
    }

    /// Number of slots ever taken.
    pub(crate) fn count(&self) -> usize {
        self.n_slots
    }

    /// Where a node is held, if it is.
    pub(crate) fn of(&self, node: usize) -> Option<u32> {
        self.slot[node]
    }

    /// The node's slot may be taken by another.
    pub(crate) fn give_back(&mut self, node: usize) {
        self.free.extend(self.slot[node]);
    }

    /// Where the node behind `e` is held.
    pub(crate) fn at(&self, e: Expr) -> u32 {
        self.slot[e.node()].expect("operands come first")
    }

    /// A slot for the node.
    pub(crate) fn take(&mut self, node: usize) -> u32 {
        let slot = self.next();
        self.slot[node] = Some(slot);
        slot
    }

    /// A slot for one operation: its content is never read, and the next operation may take it.
    pub(crate) fn take_for_now(&mut self) -> u32 {
        let slot = self.next();
        self.free.push(slot);
        slot
    }

    /// A slot that no node has.
    pub(crate) fn take_for_ever(&mut self) -> u32 {
        self.next()
    }

    fn next(&mut self) -> u32 {
        self.free.pop().unwrap_or_else(|| {
            self.n_slots += 1;
            self.n_slots as u32 - 1
        })
    }
}
