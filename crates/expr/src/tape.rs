//! A function scheduled for evaluation in place: straight-line code, interpreted.
//!
//! Nodes run in their order of creation. A slot is reused as soon as its value is dead, so that the
//! working set stays in the cache. The interpreter runs B samples abreast: one dispatch serves B
//! multiplications.

use crate::function::{Function, operands};
use crate::graph::{Expr, Node, SymbolKind};

/// A function ready to run.
#[derive(Clone, Debug)]
pub struct Tape {
    ops: Vec<Op>,
    /// Constants, written to their slots before the first evaluation.
    constants: Vec<(u32, f64)>,
    /// Slot of each input, in the order of the function's inputs.
    inputs: Vec<Option<u32>>,
    /// Slot and sign of each output entry.
    outputs: Vec<(u32, bool)>,
    n_slots: usize,
}

#[derive(Clone, Copy, Debug)]
struct Op {
    code: Code,
    a: u32,
    b: u32,
    to: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Code {
    Add,
    Sub,
    Mul,
    Div,
    Sqrt,
    /// The negative of `a`.
    SqrtOfNegative,
    /// Sine to `to`, cosine to `b`.
    SinCos,
}

/// Memory of one evaluation at a time; make one a thread.
#[derive(Clone, Debug)]
pub struct Workspace {
    one: Vec<[f64; 1]>,
    many: Vec<[f64; LANES]>,
}

/// For each sine the cosine of the same angle, and the other way round: the two are one operation, at the place of the
/// first.
fn partners(nodes: &[Node]) -> Vec<Option<usize>> {
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

/// For each node the last one that reads it; inputs and outputs are read to the end.
fn last_uses(function: &Function) -> Vec<usize> {
    let nodes = function.graph().nodes();
    let mut last_use = vec![0; nodes.len()];
    for (i, &node) in nodes.iter().enumerate() {
        for e in operands(node) {
            last_use[e.node()] = i;
        }
    }
    let (outputs, inputs) = (function.outputs.iter().map(|o| &o.entries), function.inputs.iter().map(|i| &i.entries));
    for e in outputs.chain(inputs).flatten() {
        last_use[e.node()] = usize::MAX;
    }
    last_use
}

/// Samples abreast: enough to amortise a dispatch, few enough for a 7R regressor to stay in L2.
const LANES: usize = 32;

impl Tape {
    /// Schedules `function`; named constants take their values.
    pub fn new(function: &Function) -> Tape {
        let bound = function.bound();
        let nodes = bound.graph().nodes();
        let partner = partners(nodes);
        let mut last_use = last_uses(&bound);
        let mut schedule = Schedule { free: Vec::new(), n_slots: 0, slot: vec![None; nodes.len()] };
        let mut constants = Vec::new();
        let mut ops = Vec::new();
        for (i, &node) in nodes.iter().enumerate() {
            if let Node::Constant(x) = node {
                last_use[i] = usize::MAX;
                constants.push((schedule.take(i), x));
            }
        }
        for (i, &node) in nodes.iter().enumerate() {
            let at = |e: Expr| schedule.slot[e.node()].expect("operands come first");
            let op = match node {
                Node::Constant(_) => continue,
                Node::Symbol(s) => {
                    debug_assert_eq!(bound.graph().symbols()[s.0 as usize].1, SymbolKind::Input);
                    schedule.take(i);
                    continue;
                }
                Node::Add(a, b) if b.is_negative() => (Code::Sub, at(a), at(b)),
                Node::Add(a, b) => (Code::Add, at(a), at(b)),
                Node::Mul(a, b) => (Code::Mul, at(a), at(b)),
                Node::Div(a, b) => (Code::Div, at(a), at(b)),
                Node::Sqrt(a) if a.is_negative() => (Code::SqrtOfNegative, at(a), at(a)),
                Node::Sqrt(a) => (Code::Sqrt, at(a), at(a)),
                Node::Sin(a) | Node::Cos(a) => {
                    if schedule.slot[i].is_some() {
                        continue;
                    }
                    let a = at(a);
                    let own = schedule.take(i);
                    let other = match partner[i] {
                        Some(p) => schedule.take(p),
                        None => schedule.take_nowhere(),
                    };
                    let (sine, cosine) = if matches!(node, Node::Sin(_)) { (own, other) } else { (other, own) };
                    ops.push(Op { code: Code::SinCos, a, b: cosine, to: sine });
                    continue;
                }
            };
            let mut dead: Vec<usize> = operands(node).map(Expr::node).filter(|&e| last_use[e] == i).collect();
            dead.dedup();
            schedule.free.extend(dead.iter().filter_map(|&e| schedule.slot[e]));
            let (code, a, b) = op;
            ops.push(Op { code, a, b, to: schedule.take(i) });
        }
        let slot = |e: &Expr| schedule.slot[e.node()].expect("outputs are scheduled");
        Tape {
            ops,
            constants,
            inputs: bound.inputs.iter().flat_map(|i| &i.entries).map(|e| schedule.slot[e.node()]).collect(),
            outputs: bound.outputs.iter().flat_map(|o| &o.entries).map(|e| (slot(e), e.is_negative())).collect(),
            n_slots: schedule.n_slots,
        }
    }

    /// Number of entries of all inputs together.
    pub fn n_inputs(&self) -> usize {
        self.inputs.len()
    }

    /// Number of entries of all outputs together.
    pub fn n_outputs(&self) -> usize {
        self.outputs.len()
    }

    /// Memory for evaluations of this tape, to be used again by each.
    pub fn workspace(&self) -> Workspace {
        let mut work = Workspace { one: vec![[0.0]; self.n_slots], many: Vec::new() };
        for &(slot, x) in &self.constants {
            work.one[slot as usize] = [x];
        }
        work
    }

    /// One evaluation: all inputs one after the other -> all outputs one after the other.
    pub fn evaluate(&self, inputs: &[f64], work: &mut Workspace, outputs: &mut [f64]) {
        debug_assert_eq!((inputs.len(), outputs.len()), (self.n_inputs(), self.n_outputs()));
        self.run(&mut work.one, |lane_inputs, _| inputs[lane_inputs], |k, values| outputs[k] = values[0]);
    }

    /// `inputs.len() / n_inputs()` evaluations, samples one after the other in both slices.
    pub fn evaluate_many(&self, inputs: &[f64], work: &mut Workspace, outputs: &mut [f64]) {
        if work.many.is_empty() {
            work.many = work.one.iter().map(|&[x]| [x; LANES]).collect();
        }
        let (n_in, n_out) = (self.n_inputs(), self.n_outputs());
        for (inputs, outputs) in inputs.chunks(n_in * LANES).zip(outputs.chunks_mut(n_out * LANES)) {
            let n = inputs.len() / n_in;
            // Lanes past the end repeat the last sample.
            self.run(
                &mut work.many,
                |k, lane| inputs[lane.min(n - 1) * n_in + k],
                |k, values| {
                    for (lane, x) in values.iter().enumerate().take(n) {
                        outputs[lane * n_out + k] = *x;
                    }
                },
            );
        }
    }

    fn run<const B: usize>(
        &self,
        slots: &mut [[f64; B]],
        input: impl Fn(usize, usize) -> f64,
        mut output: impl FnMut(usize, [f64; B]),
    ) {
        for (k, slot) in self.inputs.iter().enumerate() {
            if let Some(slot) = slot {
                slots[*slot as usize] = std::array::from_fn(|lane| input(k, lane));
            }
        }
        for op in &self.ops {
            let (a, b) = (slots[op.a as usize], slots[op.b as usize]);
            slots[op.to as usize] = match op.code {
                Code::Add => std::array::from_fn(|l| a[l] + b[l]),
                Code::Sub => std::array::from_fn(|l| a[l] - b[l]),
                Code::Mul => std::array::from_fn(|l| a[l] * b[l]),
                Code::Div => std::array::from_fn(|l| a[l] / b[l]),
                Code::Sqrt => std::array::from_fn(|l| a[l].sqrt()),
                Code::SqrtOfNegative => std::array::from_fn(|l| (-a[l]).sqrt()),
                Code::SinCos => {
                    let pairs: [(f64, f64); B] = std::array::from_fn(|l| libm::sincos(a[l]));
                    slots[op.b as usize] = pairs.map(|p| p.1);
                    pairs.map(|p| p.0)
                }
            };
        }
        for (k, &(slot, negative)) in self.outputs.iter().enumerate() {
            let values = slots[slot as usize];
            output(k, if negative { values.map(|x| -x) } else { values });
        }
    }
}

struct Schedule {
    free: Vec<u32>,
    n_slots: usize,
    slot: Vec<Option<u32>>,
}

impl Schedule {
    fn take(&mut self, node: usize) -> u32 {
        let slot = self.take_nowhere();
        self.slot[node] = Some(slot);
        slot
    }

    /// A slot that belongs to no node: its content is never read.
    fn take_nowhere(&mut self) -> u32 {
        self.free.pop().unwrap_or_else(|| {
            self.n_slots += 1;
            self.n_slots as u32 - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Graph, Input, Output, SymbolKind};

    /// sin(x) (x + y), -(x - y) D and zero, with D = 3.
    fn function() -> Function {
        let mut g = Graph::new();
        let (x, y) = (g.symbol("x", SymbolKind::Input), g.symbol("y", SymbolKind::Input));
        let d = g.symbol("D", SymbolKind::Constant(3.0));
        let (s, sum, difference) = (g.sin(x), g.add(x, y), g.sub(x, y));
        let entries = vec![g.mul(s, sum), -g.mul(difference, d), Expr::ZERO];
        let inputs = vec![Input { name: "v".into(), entries: vec![x, y] }];
        Function::new("f", &g, inputs, vec![Output { name: "w".into(), rows: 3, columns: 1, entries }])
    }

    #[test]
    fn one_and_many_agree_with_the_formula() {
        let tape = Tape::new(&function());
        let mut work = tape.workspace();
        let n = 2 * LANES + 5;
        let inputs: Vec<f64> = (0..2 * n).map(|i| i as f64 * 0.37 - 9.0).collect();
        let mut many = vec![f64::NAN; 3 * n];
        tape.evaluate_many(&inputs, &mut work, &mut many);
        for i in 0..n {
            let (x, y) = (inputs[2 * i], inputs[2 * i + 1]);
            let mut one = [f64::NAN; 3];
            tape.evaluate(&[x, y], &mut work, &mut one);
            assert_eq!(one, [libm::sin(x) * (x + y), (y - x) * 3.0, 0.0]);
            assert_eq!(one, many[3 * i..3 * i + 3]);
        }
    }

    #[test]
    fn counting_leaves_out_constants_and_signs() {
        let c = function().count();
        assert_eq!((c.mul, c.add, c.sin_cos), (2, 2, 1));
    }
}
