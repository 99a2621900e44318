//! The reverse mode of differentiation: the gradient of a weighted sum of a function's outputs with respect to its
//! inputs.
//!
//! The weights are w_k, one per output entry, and the sum is L = sum_k w_k y_k(x). One pass forward evaluates the nodes. One pass
//! backward adds to the slope a' = dL/da of each operand a the contribution of the node c that uses it [Griewank, Walther 2008]:
//!
//! c = a + b: a' += c', b' += c';   c = a b: a' += c' b, b' += c' a;   c = a / b: a' += c' / b, b' -= c' c / b;
//! c = sqrt a: a' += c' / (2 c);   c = sin a: a' += c' cos a;   c = cos a: a' -= c' sin a.
//!
//! The derivatives are exact except for rounding. All of them together cost a few evaluations, independently of the number of
//! inputs.

use processor::{Work, widely};

use crate::function::Function;
use crate::fusion::{Fusion, Operation};
use crate::graph::{Expr, Node};

/// A function prepared for the forward and the backward pass, which give its gradient.
#[derive(Clone, Debug)]
pub struct Adjoint {
    sums: Vec<Sum>,
    /// The operations other than sums and products, in the order of evaluation.
    others: Vec<NonSumOperation>,
    /// Slot (index in the list of stored values) and value of each constant.
    constants: Vec<(usize, f64)>,
    /// The slot of each input entry.
    inputs: Vec<usize>,
    /// For each output entry that depends on an input: its slot (index of the stored value), its sign (1 or -1), and its index
    /// among all output entries.
    outputs: Vec<(usize, f64, usize)>,
    n_outputs: usize,
    slots: usize,
}

/// An operation on slots (stored values): slot `to` = +-a b +- c. A sum is computed as a 1 +- c and a product as a b - 0, so that
/// the processor need not predict a branch. The operations are those of [`Fusion`], but the product is always rounded before the
/// addition.
#[derive(Clone, Copy, Debug)]
struct Sum {
    a: Signed,
    b: u32,
    c: Signed,
    to: u32,
}

/// A slot with a sign, in 32 bits: twice the slot, plus 1 if its value is subtracted. A [`Sum`] then takes sixteen bytes.
#[derive(Clone, Copy, Debug)]
struct Signed(u32);

impl Signed {
    fn new(slot: u32, negative: bool) -> Signed {
        Signed(2 * slot + u32::from(negative))
    }

    #[inline(always)]
    fn slot(self) -> usize {
        (self.0 / 2) as usize
    }

    #[inline(always)]
    fn sign(self) -> f64 {
        1.0 - 2.0 * f64::from(self.0 % 2)
    }
}

/// An operation other than a sum or product. It is performed after `after` entries of `sums`.
#[derive(Clone, Copy, Debug)]
struct NonSumOperation {
    after: usize,
    code: Code,
    to: usize,
}

#[derive(Clone, Copy, Debug)]
enum Code {
    Div(usize, usize),
    /// Square root of (slot, sign): the sign is applied before the root.
    Sqrt(usize, f64),
    Sin(usize),
    Cos(usize),
}

/// The memory of an evaluation. Each thread needs a separate one.
#[derive(Clone, Debug)]
pub struct AdjointWorkspace {
    values: Vec<Lanes>,
    /// dL/dnode of each slot, L: weighted sum of the outputs. It is zero before and after each evaluation.
    slopes: Vec<Lanes>,
}

type Lanes = [f64; ADJOINT_LANES];

/// Number of samples that are computed together, in SIMD lanes. With 8, the values and slopes of a 7R regressor fit into the
/// second-level cache.
const ADJOINT_LANES: usize = 8;

/// Number of slots with the constant 1, and of slots with -0. Sums and products need these constants for the form a b + c. Their
/// slopes are accumulated but never read. Several copies are used, so that an accumulation need not wait for the previous one.
const CONSTANT_COPIES: usize = 8;

impl Adjoint {
    /// Prepares `function` for differentiation, with the values of its named constants.
    pub fn new(function: &Function) -> Adjoint {
        let function = function.bound();
        let graph = function.graph();
        let nodes = graph.nodes();
        // The slots after the nodes contain ones, then -0. Adding -0 keeps the sign of a product that is zero.
        let one = |i: usize| (nodes.len() + i % CONSTANT_COPIES) as u32;
        let minus_zero = |i: usize| one(i) + CONSTANT_COPIES as u32;
        let mut constants: Vec<(usize, f64)> =
            (0..CONSTANT_COPIES).flat_map(|i| [(one(i) as usize, 1.0), (minus_zero(i) as usize, -0.0)]).collect();
        let (mut sums, mut others) = (Vec::new(), Vec::new());
        let fusion = Fusion::of(&function);
        for (i, &node) in nodes.iter().enumerate() {
            let slot = |e: Expr| e.node() as u32;
            let signed = |e: Expr| Signed::new(slot(e), e.is_negative());
            let mut other = |code: Code| others.push(NonSumOperation { after: sums.len(), code, to: i });
            let to = i as u32;
            match (fusion.operation_of(i), node) {
                (Operation::Add(a, c), _) => sums.push(Sum { a: signed(a), b: one(i), c: signed(c), to }),
                (Operation::MulAdd(a, b, c), _) => sums.push(Sum { a: signed(a), b: slot(b), c: signed(c), to }),
                (Operation::Mul(a, b), _) => {
                    sums.push(Sum { a: signed(a), b: slot(b), c: Signed::new(minus_zero(i), false), to });
                }
                (Operation::Div(a, b), _) => other(Code::Div(a.node(), b.node())),
                (Operation::Sqrt(a), _) => other(Code::Sqrt(a.node(), sign(a))),
                (Operation::None, Node::Sin(a)) => other(Code::Sin(a.node())),
                (Operation::None, Node::Cos(a)) => other(Code::Cos(a.node())),
                (Operation::None, Node::Constant(x)) => constants.push((i, x)),
                // No operation: an input, or a product that is fused into sums.
                (Operation::None, _) => {}
            }
        }
        let all = || function.outputs.iter().flat_map(|o| &o.entries);
        let varying = all().enumerate().filter(|(_, e)| graph.varies(**e));
        Adjoint {
            sums,
            others,
            constants,
            inputs: function.inputs.iter().flat_map(|i| &i.entries).map(|e| e.node()).collect(),
            outputs: varying.map(|(k, e)| (e.node(), sign(fusion.held(*e)), k)).collect(),
            n_outputs: all().count(),
            slots: nodes.len() + 2 * CONSTANT_COPIES,
        }
    }

    /// Number of entries of all inputs together.
    pub fn n_inputs(&self) -> usize {
        self.inputs.len()
    }

    /// Makes the memory that [`Adjoint::pull_back`] needs. It can be used for any number of calls.
    pub fn workspace(&self) -> AdjointWorkspace {
        let mut values = vec![[0.0; ADJOINT_LANES]; self.slots];
        self.constants.iter().for_each(|&(slot, x)| values[slot] = [x; ADJOINT_LANES]);
        AdjointWorkspace { values, slopes: vec![[0.0; ADJOINT_LANES]; self.slots] }
    }

    /// Computes the gradients dL/dinput of `inputs.len() / n_inputs()` samples. All three slices are stored sample by sample:
    /// `inputs`, `weights` (one per output entry), and the result `gradient`.
    pub fn pull_back(&self, inputs: &[f64], weights: &[f64], work: &mut AdjointWorkspace, gradient: &mut [f64]) {
        let (n_in, n_out) = (self.n_inputs(), self.n_outputs);
        if n_in == 0 || n_out == 0 {
            return gradient.fill(0.0);
        }
        let samples = inputs.chunks(n_in * ADJOINT_LANES).zip(weights.chunks(n_out * ADJOINT_LANES));
        for ((inputs, weights), gradient) in samples.zip(gradient.chunks_mut(n_in * ADJOINT_LANES)) {
            widely(SampleGroup { adjoint: self, inputs, weights, work, gradient });
        }
    }

    #[inline(always)]
    fn forward(&self, values: &mut [Lanes]) {
        let mut done = 0;
        for other in &self.others {
            sum_up(&self.sums[done..other.after], values);
            done = other.after;
            values[other.to] = match other.code {
                Code::Div(a, b) => each(|l| values[a][l] / values[b][l]),
                Code::Sqrt(a, sign) => values[a].map(|x| (sign * x).sqrt()),
                Code::Sin(a) => values[a].map(libm::sin),
                Code::Cos(a) => values[a].map(libm::cos),
            };
        }
        sum_up(&self.sums[done..], values);
    }

    /// The backward pass, from the last node to the first. Operands come before the nodes that use them. So the slope c' = dL/dc
    /// of a node c is complete before it is added to the slopes of its operands. L: weighted sum of the outputs.
    #[inline(always)]
    fn backward(&self, values: &[Lanes], slopes: &mut [Lanes]) {
        let mut left = self.sums.len();
        for other in self.others.iter().rev() {
            pass_on(&self.sums[other.after..left], values, slopes);
            left = other.after;
            let own = std::mem::take(&mut slopes[other.to]);
            // A node with zero slope is skipped. This saves time, and avoids 0 / 0 at the square root of zero.
            if own == [0.0; ADJOINT_LANES] {
                continue;
            }
            match other.code {
                Code::Div(a, b) => {
                    let (quotient, divisor) = (values[other.to], values[b]);
                    add(slopes, a, each(|l| own[l] / divisor[l]));
                    add(slopes, b, each(|l| -own[l] * quotient[l] / divisor[l]));
                }
                Code::Sqrt(a, sign) => {
                    let root = values[other.to];
                    add(slopes, a, each(|l| sign * (own[l] / (2.0 * root[l]))));
                }
                Code::Sin(a) => add(slopes, a, each(|l| own[l] * libm::cos(values[a][l]))),
                Code::Cos(a) => add(slopes, a, each(|l| own[l] * -libm::sin(values[a][l]))),
            }
        }
        pass_on(&self.sums[..left], values, slopes);
    }
}

/// The input of the forward and the backward pass of one group of samples in SIMD lanes.
struct SampleGroup<'a> {
    adjoint: &'a Adjoint,
    inputs: &'a [f64],
    weights: &'a [f64],
    work: &'a mut AdjointWorkspace,
    gradient: &'a mut [f64],
}

impl Work for SampleGroup<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let SampleGroup { adjoint, inputs, weights, work: AdjointWorkspace { values, slopes }, gradient } = self;
        let n_in = adjoint.n_inputs();
        let n = inputs.len() / n_in;
        // Lanes without a sample repeat the last sample.
        let lane = |x: &[f64], width: usize, k: usize| each(|l| x[l.min(n - 1) * width + k]);
        for (k, &slot) in adjoint.inputs.iter().enumerate() {
            values[slot] = lane(inputs, n_in, k);
        }
        adjoint.forward(values);
        for &(slot, sign, k) in &adjoint.outputs {
            let weights = lane(weights, adjoint.n_outputs, k);
            add(slopes, slot, each(|l| sign * weights[l]));
        }
        adjoint.backward(values, slopes);
        for (k, &slot) in adjoint.inputs.iter().enumerate() {
            for (l, x) in std::mem::take(&mut slopes[slot]).into_iter().enumerate().take(n) {
                gradient[l * n_in + k] = x;
            }
        }
        adjoint.constants.iter().for_each(|&(slot, _)| slopes[slot] = [0.0; ADJOINT_LANES]);
    }
}

// The next functions use loops and not `from_fn`, because the compiler would not use the wider instructions in a closure of the
// library.

#[inline(always)]
fn each(of: impl Fn(usize) -> f64) -> Lanes {
    let mut lanes = [0.0; ADJOINT_LANES];
    for (l, x) in lanes.iter_mut().enumerate() {
        *x = of(l);
    }
    lanes
}

#[inline(always)]
fn sum_up(sums: &[Sum], values: &mut [Lanes]) {
    for sum in sums {
        let (a, b, c) = (&values[sum.a.slot()], &values[sum.b as usize], &values[sum.c.slot()]);
        let [of_a, of_c] = [sum.a.sign(), sum.c.sign()];
        values[sum.to as usize] = each(|l| of_a * a[l] * b[l] + of_c * c[l]);
    }
}

#[inline(always)]
fn pass_on(sums: &[Sum], values: &[Lanes], slopes: &mut [Lanes]) {
    for sum in sums.iter().rev() {
        let own = std::mem::take(&mut slopes[sum.to as usize]);
        let (a, b) = (&values[sum.a.slot()], &values[sum.b as usize]);
        let [of_a, of_c] = [sum.a.sign(), sum.c.sign()];
        add(slopes, sum.a.slot(), each(|l| of_a * own[l] * b[l]));
        add(slopes, sum.b as usize, each(|l| of_a * own[l] * a[l]));
        add(slopes, sum.c.slot(), each(|l| of_c * own[l]));
    }
}

#[inline(always)]
fn add(slopes: &mut [Lanes], slot: usize, slope: Lanes) {
    let sum = &mut slopes[slot];
    for l in 0..ADJOINT_LANES {
        sum[l] += slope[l];
    }
}

fn sign(e: Expr) -> f64 {
    if e.is_negative() { -1.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Graph, Input, Output, SymbolKind, Tape};

    /// A function with the outputs sin(x) (x - y) / cos(y), sqrt(x^2 + y^2), -y and zero. It has all operations.
    fn function() -> Function {
        let mut g = Graph::new();
        let (x, y) = (g.symbol("x", SymbolKind::Input), g.symbol("y", SymbolKind::Input));
        let (s, c, difference) = (g.sin(x), g.cos(y), g.sub(x, y));
        let product = g.mul(s, difference);
        let (xx, yy) = (g.mul(x, x), g.mul(y, y));
        let square = g.add(xx, yy);
        let entries = vec![g.div(product, c), g.sqrt(square), -y, Expr::ZERO];
        let inputs = vec![Input { name: "v".into(), entries: vec![x, y] }];
        Function::new("f", &g, inputs, vec![Output { name: "w".into(), rows: 4, columns: 1, entries }])
    }

    #[test]
    fn the_gradient_is_that_of_central_differences() {
        let (adjoint, tape) = (Adjoint::new(&function()), Tape::new(&function()));
        let (mut work, mut tape_work) = (adjoint.workspace(), tape.workspace());
        let n = ADJOINT_LANES + 3;
        let inputs: Vec<f64> = (0..2 * n).map(|i| 0.3 + 0.05 * i as f64).collect();
        let weights: Vec<f64> = (0..4 * n).map(|i| 1.0 - 0.2 * i as f64).collect();
        let mut gradient = vec![f64::NAN; 2 * n];
        adjoint.pull_back(&inputs, &weights, &mut work, &mut gradient);
        let mut value = |x: [f64; 2], w: &[f64]| {
            let mut y = [0.0; 4];
            tape.evaluate(&x, &mut tape_work, &mut y);
            y.iter().zip(w).map(|(y, w)| y * w).sum::<f64>()
        };
        for i in 0..n {
            let (x, w) = ([inputs[2 * i], inputs[2 * i + 1]], &weights[4 * i..4 * i + 4]);
            for k in 0..2 {
                let h = 1e-5;
                let moved = |h: f64| if k == 0 { [x[0] + h, x[1]] } else { [x[0], x[1] + h] };
                let slope = (value(moved(h), w) - value(moved(-h), w)) / (2.0 * h);
                // Allowed error of central differences with the step h: h^2, and rounding eps / h. The values are of order ten.
                assert!((gradient[2 * i + k] - slope).abs() < 1e-7 * (1.0 + slope.abs()), "{i} {k}");
            }
        }
    }
}
