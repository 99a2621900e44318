//! The reverse mode of differentiation: the gradient of a weighted sum of a function's outputs with respect to its
//! inputs.
//!
//! The weights are w_k, one per output entry, and the sum is L = sum_k w_k y_k(x). One pass forward evaluates the nodes.
//! One pass backward carries dL/dnode from each node to its operands [Griewank, Walther 2008]:
//!
//! c = a + b: a' += c', b' += c';   c = a b: a' += c' b, b' += c' a;   c = a / b: a' += c' / b, b' -= c' c / b;
//! c = sqrt a: a' += c' / (2 c);   c = sin a: a' += c' cos a;   c = cos a: a' -= c' sin a.
//!
//! The derivatives are exact but for rounding, and cost a few evaluations whatever the number of inputs.

use crate::function::Function;
use crate::graph::{Expr, Node};

/// A function with the reverse of its evaluation.
#[derive(Clone, Debug)]
pub struct Adjoint {
    function: Function,
    n_outputs: usize,
}

/// Memory of one evaluation at a time; make one per thread.
#[derive(Clone, Debug)]
pub struct AdjointWorkspace {
    values: Vec<[f64; ADJOINT_LANES]>,
    slopes: Vec<[f64; ADJOINT_LANES]>,
}

/// Samples computed side by side, so few that values and slopes of a 7R regressor stay in the second-level cache.
const ADJOINT_LANES: usize = 8;

impl Adjoint {
    /// The reverse of `function`; named constants take their values.
    pub fn new(function: &Function) -> Adjoint {
        let function = function.bound();
        Adjoint { n_outputs: function.outputs.iter().map(|o| o.entries.len()).sum(), function }
    }

    /// Number of entries of all inputs together.
    pub fn n_inputs(&self) -> usize {
        self.function.inputs.iter().map(|i| i.entries.len()).sum()
    }

    /// Memory for evaluations, to be used again by each.
    pub fn workspace(&self) -> AdjointWorkspace {
        let nodes = self.function.graph().nodes();
        let value = |node: &Node| if let Node::Constant(x) = node { [*x; ADJOINT_LANES] } else { [0.0; ADJOINT_LANES] };
        AdjointWorkspace { values: nodes.iter().map(value).collect(), slopes: vec![[0.0; ADJOINT_LANES]; nodes.len()] }
    }

    /// `inputs.len() / n_inputs()` samples, one after the other in all three slices: inputs, one weight an output
    /// entry, dL/dinput.
    pub fn pull_back(&self, inputs: &[f64], weights: &[f64], work: &mut AdjointWorkspace, gradient: &mut [f64]) {
        let (n_in, n_out) = (self.n_inputs(), self.n_outputs);
        if n_in == 0 || n_out == 0 {
            return gradient.fill(0.0);
        }
        let samples = inputs.chunks(n_in * ADJOINT_LANES).zip(weights.chunks(n_out * ADJOINT_LANES));
        for ((inputs, weights), gradient) in samples.zip(gradient.chunks_mut(n_in * ADJOINT_LANES)) {
            let n = inputs.len() / n_in;
            // Lanes past the end repeat the last sample.
            let lane = |x: &[f64], width: usize, k: usize| std::array::from_fn(|l| x[l.min(n - 1) * width + k]);
            for (k, e) in self.inputs().enumerate() {
                work.values[e.node()] = lane(inputs, n_in, k);
            }
            self.forward(&mut work.values);
            work.slopes.fill([0.0; ADJOINT_LANES]);
            for (k, e) in self.function.outputs.iter().flat_map(|o| &o.entries).enumerate() {
                add(&mut work.slopes, *e, lane(weights, n_out, k));
            }
            self.backward(&work.values, &mut work.slopes);
            for (k, e) in self.inputs().enumerate() {
                for (l, x) in work.slopes[e.node()].iter().enumerate().take(n) {
                    gradient[l * n_in + k] = *x;
                }
            }
        }
    }

    fn inputs(&self) -> impl Iterator<Item = &Expr> {
        self.function.inputs.iter().flat_map(|i| &i.entries)
    }

    fn forward(&self, values: &mut [[f64; ADJOINT_LANES]]) {
        for (i, &node) in self.function.graph().nodes().iter().enumerate() {
            let at = |e: Expr| values[e.node()];
            values[i] = match node {
                Node::Constant(_) | Node::Symbol(_) => continue,
                Node::Add(a, b) => {
                    let (a, sign, b) = (at(a), sign(b), at(b));
                    std::array::from_fn(|l| a[l] + sign * b[l])
                }
                Node::Mul(a, b) => {
                    let (a, b) = (at(a), at(b));
                    std::array::from_fn(|l| a[l] * b[l])
                }
                Node::Div(a, b) => {
                    let (a, b) = (at(a), at(b));
                    std::array::from_fn(|l| a[l] / b[l])
                }
                Node::Sqrt(a) => at(a).map(|x| (sign(a) * x).sqrt()),
                Node::Sin(a) => at(a).map(libm::sin),
                Node::Cos(a) => at(a).map(libm::cos),
            };
        }
    }

    fn backward(&self, values: &[[f64; ADJOINT_LANES]], slopes: &mut [[f64; ADJOINT_LANES]]) {
        let graph = self.function.graph();
        // Operands stand before what uses them: from the end, each c' is complete when it is passed on.
        for (i, &node) in graph.nodes().iter().enumerate().rev() {
            let own = slopes[i];
            if !graph.varies(Expr::new(i, false)) || own.iter().all(|x| *x == 0.0) {
                continue;
            }
            let at = |e: Expr| values[e.node()];
            let times = |x: [f64; ADJOINT_LANES]| std::array::from_fn(|l| own[l] * x[l]);
            match node {
                Node::Constant(_) | Node::Symbol(_) => {}
                Node::Add(a, b) => {
                    add(slopes, a, own);
                    add(slopes, b, own);
                }
                Node::Mul(a, b) => {
                    add(slopes, a, times(at(b)));
                    add(slopes, b, times(at(a)));
                }
                Node::Div(a, b) => {
                    let (quotient, b_values) = (values[i], at(b));
                    add(slopes, a, std::array::from_fn(|l| own[l] / b_values[l]));
                    add(slopes, b, std::array::from_fn(|l| -own[l] * quotient[l] / b_values[l]));
                }
                Node::Sqrt(a) => {
                    let root = values[i];
                    add(slopes, a, std::array::from_fn(|l| own[l] / (2.0 * root[l])));
                }
                Node::Sin(a) => add(slopes, a, times(at(a).map(libm::cos))),
                Node::Cos(a) => add(slopes, a, times(at(a).map(|x| -libm::sin(x)))),
            }
        }
    }
}

fn sign(e: Expr) -> f64 {
    if e.is_negative() { -1.0 } else { 1.0 }
}

/// Adds dL/d(the expression) to the node behind it.
#[inline(always)]
fn add(slopes: &mut [[f64; ADJOINT_LANES]], e: Expr, slope: [f64; ADJOINT_LANES]) {
    let sign = sign(e);
    for (sum, x) in slopes[e.node()].iter_mut().zip(slope) {
        *sum += sign * x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Graph, Input, Output, SymbolKind, Tape};

    /// All operations at once: sin(x) (x - y) / cos(y), sqrt(x^2 + y^2), -y and zero.
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
                // Central differences err by h^2 and by eps/h; values are of order ten.
                assert!((gradient[2 * i + k] - slope).abs() < 1e-7 * (1.0 + slope.abs()), "{i} {k}");
            }
        }
    }
}
