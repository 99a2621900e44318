//! Assigns memory slots to the values that a tape (a function prepared for the interpreter) computes. A slot is used again after
//! the last use of its value.

use crate::function::{Function, operands};
use crate::fusion::Fusion;
use crate::graph::{Expr, Node};

/// For each sine node, the cosine node of the same angle, and for each cosine node, the sine node; `None` if there is none. One
/// operation computes sine and cosine; it stands at the position of the earlier node.
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

/// For each node, the index of the last node that uses it; `usize::MAX` for inputs and outputs, which are kept to the end.
pub(crate) fn last_uses(function: &Function, fusion: &Fusion) -> Vec<usize> {
    let nodes = function.graph().nodes();
    let partner = partners(nodes);
    let mut last_use = vec![0; nodes.len()];
    for (i, &node) in nodes.iter().enumerate() {
        // If both the sine and the cosine of an angle are used, only the earlier node reads the angle.
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

/// Allocates the slots of a tape.
pub(crate) struct Slots {
    free: Vec<u32>,
    n_slots: usize,
    slot: Vec<Option<u32>>,
}

impl Slots {
    /// An allocation for `nodes` nodes, without slots in use.
    pub(crate) fn new(nodes: usize) -> Slots {
        Slots { free: Vec::new(), n_slots: 0, slot: vec![None; nodes] }
    }

    /// Number of different slots that were used so far.
    pub(crate) fn count(&self) -> usize {
        self.n_slots
    }

    /// The slot of a node; `None` if it has none.
    pub(crate) fn of(&self, node: usize) -> Option<u32> {
        self.slot[node]
    }

    /// Releases the slot of a node.
    pub(crate) fn give_back(&mut self, node: usize) {
        self.free.extend(self.slot[node]);
    }

    /// The slot of the node of `e`. The node must have a slot.
    pub(crate) fn at(&self, e: Expr) -> u32 {
        self.slot[e.node()].expect("operands come first")
    }

    /// Assigns a free slot to a node.
    pub(crate) fn take(&mut self, node: usize) -> u32 {
        let slot = self.next();
        self.slot[node] = Some(slot);
        slot
    }

    /// Returns a slot for a result that is never read. The next operation may use it again.
    pub(crate) fn take_for_now(&mut self) -> u32 {
        let slot = self.next();
        self.free.push(slot);
        slot
    }

    /// Returns a slot that is never released and belongs to no node.
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
