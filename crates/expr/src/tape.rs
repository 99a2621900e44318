//! A function prepared for evaluation: a list of operations without branches, which an interpreter performs.
//!
//! Nodes are computed in the order of creation. A slot of memory is used again after the last use of its value, so that all slots
//! stay in the cache.
//!
//! The interpreter computes eight samples at a time, in SIMD lanes of the vector registers.
//!
//! [`Fusion`] determines the operations of the tape and of generated code. If the processor has a fused multiply-add, the tape
//! gives the same bits as the compiled function. On other processors, both the tape and the compiled function round a product
//! before they add it.

use crate::function::Function;
use crate::fusion::Fusion;
use crate::graph::{Expr, Node, SymbolKind};
use crate::slots::{Slots, last_uses, partners};
use crate::tape_operation::{Code, NonSumOperation, Scheduled, Sum, Units, run_other, run_sums};

/// A function ready for evaluation.
#[derive(Clone, Debug)]
pub struct Tape {
    sums: Vec<Sum>,
    /// The operations other than sums and products: division, root, sine with cosine. They are in the order of evaluation.
    others: Vec<NonSumOperation>,
    /// Slot and value of each constant; the values are written before the first evaluation.
    constants: Vec<(u32, f64)>,
    /// Slot of each input entry, in the order of the function's inputs; `None` if it has no slot.
    inputs: Vec<Option<u32>>,
    /// For each output entry: its slot, and whether the output is the negative of the value in the slot.
    outputs: Vec<(u32, bool)>,
    n_slots: usize,
}

/// The memory of an evaluation. Each thread needs a separate one.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// The slots of one sample. Each value is stored twice: a vector register can change the signs of a pair of numbers in one
    /// operation, but not the sign of a single number.
    one: Vec<[f64; 2]>,
    many: Vec<[f64; Tape::LANES]>,
}

impl Tape {
    /// Number of samples that are computed together, in SIMD lanes. With eight samples, each operand takes two AVX2 registers,
    /// and the slots of the regressor of a 7R robot fit into the first-level cache.
    pub const LANES: usize = 8;

    /// Prepares `function` for evaluation, with the values of its named constants.
    pub fn new(function: &Function) -> Tape {
        let bound = function.bound();
        let nodes = bound.graph().nodes();
        let partner = partners(nodes);
        let fusion = Fusion::of(&bound);
        let mut last_use = last_uses(&bound, &fusion);
        let mut slots = Slots::new(nodes.len());
        let (mut sums, mut others) = (Vec::new(), Vec::new());
        let units = Units { one: slots.take_for_ever(), minus_zero: slots.take_for_ever() };
        let mut constants = vec![(units.one, 1.0), (units.minus_zero, -0.0)];
        // Constants keep their slots, because they are written only once, before the first evaluation.
        for (i, &node) in nodes.iter().enumerate() {
            if let Node::Constant(x) = node {
                last_use[i] = usize::MAX;
                constants.push((slots.take(i), x));
            }
        }
        for (i, &node) in nodes.iter().enumerate() {
            match node {
                Node::Symbol(s) => {
                    debug_assert_eq!(bound.graph().symbols()[s.0 as usize].1, SymbolKind::Input);
                    slots.take(i);
                }
                // Sine and cosine of one angle are one operation, at the position of the earlier node.
                Node::Sin(a) | Node::Cos(a) if slots.of(i).is_none() => {
                    let of = slots.at(a);
                    if last_use[a.node()] == i {
                        slots.give_back(a.node());
                    }
                    let own = slots.take(i);
                    let other = match partner[i] {
                        Some(p) => slots.take(p),
                        None => slots.take_for_now(),
                    };
                    let (sine, cosine) = if matches!(node, Node::Sin(_)) { (own, other) } else { (other, own) };
                    others.push(NonSumOperation { after: sums.len(), code: Code::SinCos, a: of, b: cosine, to: sine });
                }
                _ => {}
            }
            let Some(scheduled) = units.scheduled(fusion.operation_of(i), &slots) else { continue };
            // If an operand is used here for the last time, its slot becomes free for the result.
            let mut dead: Vec<usize> = fusion.operands_of(i).map(Expr::node).filter(|&e| last_use[e] == i).collect();
            dead.sort_unstable();
            dead.dedup();
            dead.into_iter().for_each(|e| slots.give_back(e));
            let to = slots.take(i);
            match scheduled {
                Scheduled::Sum(mut sum) => {
                    sum.to = to;
                    sums.push(sum);
                }
                Scheduled::Other(other) => others.push(NonSumOperation { after: sums.len(), to, ..other }),
            }
        }
        let slot = |e: &Expr| slots.of(e.node()).expect("outputs are scheduled");
        let of_outputs = bound.outputs.iter().flat_map(|o| &o.entries);
        Tape {
            sums,
            others,
            constants,
            inputs: bound.inputs.iter().flat_map(|i| &i.entries).map(|e| slots.of(e.node())).collect(),
            outputs: of_outputs.map(|e| (slot(e), fusion.held(*e).is_negative())).collect(),
            n_slots: slots.count(),
        }
    }

    /// The tape with its last inputs fixed at `values`; the remaining inputs stay free.
    ///
    /// # Panics
    /// If there are more values than inputs.
    pub fn with_last_inputs(mut self, values: &[f64]) -> Tape {
        let last = self.inputs.split_off(self.inputs.len() - values.len());
        // The slot of an input is never used for another value, so the fixed value remains in it.
        self.constants.extend(last.into_iter().zip(values).filter_map(|(slot, x)| Some((slot?, *x))));
        self
    }

    /// Number of entries of all inputs together.
    pub fn n_inputs(&self) -> usize {
        self.inputs.len()
    }

    /// Number of entries of all outputs together.
    pub fn n_outputs(&self) -> usize {
        self.outputs.len()
    }

    /// Makes the memory that evaluations of this tape need. It can be used for any number of evaluations.
    pub fn workspace(&self) -> Workspace {
        let mut work = Workspace { one: vec![[0.0; 2]; self.n_slots], many: Vec::new() };
        for &(slot, x) in &self.constants {
            work.one[slot as usize] = [x; 2];
        }
        work
    }

    /// Evaluates one sample. `inputs`, `outputs`: the entries of all inputs or outputs, one after the other.
    pub fn evaluate(&self, inputs: &[f64], work: &mut Workspace, outputs: &mut [f64]) {
        debug_assert_eq!((inputs.len(), outputs.len()), (self.n_inputs(), self.n_outputs()));
        self.run(&mut work.one, |k, _| inputs[k]);
        for (output, (slot, is_negative)) in outputs.iter_mut().zip(&self.outputs) {
            let [value, _] = work.one[*slot as usize];
            *output = if *is_negative { -value } else { value };
        }
    }

    /// Evaluates `outputs.len() / n_outputs()` samples. `inputs` and `outputs` are stored sample by sample.
    pub fn evaluate_many(&self, inputs: &[f64], work: &mut Workspace, outputs: &mut [f64]) {
        if outputs.len() == self.n_outputs() {
            return self.evaluate(inputs, work, outputs);
        }
        let (count, n_out) = (outputs.len() / self.n_outputs().max(1), self.n_outputs());
        self.evaluate_lanes(inputs, count, work, &mut |block, found| {
            let first = block * Tape::LANES;
            for k in 0..n_out {
                for (lane, x) in found.of(k).iter().enumerate().take(count - first) {
                    outputs[(first + lane) * n_out + k] = *x;
                }
            }
        });
    }

    /// Evaluates `count` samples, [`Tape::LANES`] at a time, and calls `take(block, outputs)` with the outputs of the samples
    /// from `block * LANES` on. If samples are missing in the last block, the last sample is repeated.
    pub fn evaluate_lanes(
        &self,
        inputs: &[f64],
        count: usize,
        work: &mut Workspace,
        take: &mut dyn FnMut(usize, LaneOutputs),
    ) {
        if work.many.is_empty() {
            work.many = work.one.iter().map(|&[x, _]| [x; Tape::LANES]).collect();
        }
        let n_in = self.n_inputs();
        for block in 0..count.div_ceil(Tape::LANES) {
            let first = block * Tape::LANES;
            let (inputs, last) = (&inputs[first * n_in..], Tape::LANES.min(count - first) - 1);
            let input = |k: usize, lane: usize| inputs[lane.min(last) * n_in + k];
            self.run(&mut work.many, input);
            take(block, LaneOutputs { tape: self, slots: &work.many });
        }
    }

    fn run<const B: usize>(&self, slots: &mut [[f64; B]], input: impl Fn(usize, usize) -> f64) {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            #[allow(unsafe_code, reason = "the processor has been asked")]
            // SAFETY: `run_fused` requires a processor with AVX2 and FMA, which was just checked.
            return unsafe { self.run_fused(slots, input) };
        }
        // Every AArch64 processor has a fused multiply-add. On other processors it may be a slow library call.
        let fused = |a: f64, b: f64, c: f64| if cfg!(target_arch = "aarch64") { a.mul_add(b, c) } else { a * b + c };
        self.run_with(slots, input, fused);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn run_fused<const B: usize>(&self, slots: &mut [[f64; B]], input: impl Fn(usize, usize) -> f64) {
        self.run_with(slots, input, f64::mul_add);
    }

    #[inline(always)]
    fn run_with<const B: usize>(
        &self,
        slots: &mut [[f64; B]],
        input: impl Fn(usize, usize) -> f64,
        mul_add: impl Fn(f64, f64, f64) -> f64,
    ) {
        for (k, slot) in self.inputs.iter().enumerate() {
            if let Some(slot) = slot {
                slots[*slot as usize] = std::array::from_fn(|lane| input(k, lane));
            }
        }
        let mut done = 0;
        for other in &self.others {
            run_sums(&self.sums[done..other.after], slots, &mul_add);
            done = other.after;
            run_other(other, slots, &mul_add);
        }
        run_sums(&self.sums[done..], slots, &mul_add);
    }
}

/// The outputs of [`Tape::LANES`] samples that were computed together.
#[derive(Clone, Copy, Debug)]
pub struct LaneOutputs<'a> {
    tape: &'a Tape,
    slots: &'a [[f64; Tape::LANES]],
}

impl LaneOutputs<'_> {
    /// Output k of each sample.
    ///
    /// # Panics
    /// If there is no output k.
    #[inline]
    pub fn of(self, k: usize) -> [f64; Tape::LANES] {
        let (slot, is_negative) = self.tape.outputs[k];
        let values = self.slots[slot as usize];
        if is_negative { values.map(|x| -x) } else { values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Graph, Input, Output, SymbolKind};

    /// A function with the outputs sin(x) (x + y), -(x - y) D + x y and zero. D = 3 is a named constant.
    fn function() -> Function {
        let mut g = Graph::new();
        let (x, y) = (g.symbol("x", SymbolKind::Input), g.symbol("y", SymbolKind::Input));
        let d = g.symbol("D", SymbolKind::Constant(3.0));
        let (s, sum, difference) = (g.sin(x), g.add(x, y), g.sub(x, y));
        let (product, scaled) = (g.mul(x, y), g.mul(difference, d));
        let entries = vec![g.mul(s, sum), g.sub(product, scaled), Expr::ZERO];
        let inputs = vec![Input { name: "v".into(), entries: vec![x, y] }];
        Function::new("f", &g, inputs, vec![Output { name: "w".into(), rows: 3, columns: 1, entries }])
    }

    #[test]
    fn last_inputs_can_be_fixed() {
        let (tape, y) = (Tape::new(&function()), 0.3);
        let fixed = tape.clone().with_last_inputs(&[y]);
        let x: Vec<f64> = (0..Tape::LANES + 3).map(|i| 1.7 * i as f64 - 4.0).collect();
        let both: Vec<f64> = x.iter().flat_map(|x| [*x, y]).collect();
        let (mut expected, mut found) = (vec![f64::NAN; 3 * x.len()], vec![f64::NAN; 3 * x.len()]);
        tape.evaluate_many(&both, &mut tape.workspace(), &mut expected);
        let mut work = fixed.workspace();
        // The fixed values must remain after the first run.
        for _ in 0..2 {
            fixed.evaluate_many(&x, &mut work, &mut found);
            assert_eq!(found, expected);
            fixed.evaluate(&x[..1], &mut work, &mut found[..3]);
            assert_eq!(found[..3], expected[..3]);
        }
    }

    /// The function is x y - z, with z = x y rounded. A fused operation gives the rounding error of z, and an unfused operation
    /// gives zero.
    #[test]
    fn fusing_rounds_once() {
        let mut g = Graph::new();
        let [x, y, z] = ["x", "y", "z"].map(|name| g.symbol(name, SymbolKind::Input));
        let product = g.mul(x, y);
        let entries = vec![g.sub(product, z)];
        let inputs = vec![Input { name: "v".into(), entries: vec![x, y, z] }];
        let f = Function::new("f", &g, inputs, vec![Output { name: "w".into(), rows: 1, columns: 1, entries }]);
        let tape = Tape::new(&f);
        let inputs = [0.1, 0.3, 0.1 * 0.3];
        let value = |mul_add: fn(f64, f64, f64) -> f64| {
            let mut slots = tape.workspace().one;
            tape.run_with(&mut slots, |k, _| inputs[k], mul_add);
            let (slot, is_negative) = tape.outputs[0];
            if is_negative { -slots[slot as usize][0] } else { slots[slot as usize][0] }
        };
        assert_eq!(value(|a, b, c| a * b + c), 0.0);
        assert_eq!(value(f64::mul_add), 0.1_f64.mul_add(0.3, -inputs[2]));
        assert_ne!(value(f64::mul_add), 0.0);
    }

    #[test]
    fn angles_of_sines_give_their_slots_back() {
        let tape = |sines: usize, both: bool| {
            let mut g = Graph::new();
            let [x, y] = ["x", "y"].map(|name| g.symbol(name, SymbolKind::Input));
            let mut sum = x;
            for _ in 0..sines {
                let angle = g.add(sum, y);
                let mut value = g.sin(angle);
                if both {
                    let cosine = g.cos(angle);
                    value = g.mul(value, cosine);
                }
                sum = g.add(value, x);
            }
            let inputs = vec![Input { name: "v".into(), entries: vec![x, y] }];
            let output = Output { name: "w".into(), rows: 1, columns: 1, entries: vec![sum] };
            Tape::new(&Function::new("f", &g, inputs, vec![output]))
        };
        for both in [false, true] {
            assert_eq!(tape(3, both).n_slots, tape(40, both).n_slots);
            let (mut expected, mut found) = (0.3_f64, [f64::NAN]);
            for _ in 0..3 {
                let (sine, cosine) = (expected + 0.7).sin_cos();
                expected = if both { sine * cosine } else { sine } + 0.3;
            }
            let tape = tape(3, both);
            tape.evaluate(&[0.3, 0.7], &mut tape.workspace(), &mut found);
            // Allowed error: a few roundings of numbers below 2.
            assert!((found[0] - expected).abs() < 1e-14, "{found:?} {expected}");
        }
    }
}
