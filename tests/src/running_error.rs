//! Evaluates a function in plain f64 with a running bound of the rounding error [Higham 2002, 3.3].
//!
//! Two evaluations differ by at most twice the bound, even if their operations are in another order, or their sines and cosines
//! differ by one unit in the last place. The bound is a few units in the last place, times the condition number of each sum.

use expr::{Algebra, Expr, Function, Node, Symbol};

/// Each output entry of `function` at `inputs`, with the bound of its rounding error. Sines and cosines may be only of inputs,
/// and named constants must have values.
pub fn bounded(function: &Function, inputs: &[f64]) -> Vec<Bounded> {
    function.evaluate_in(&mut RunningError { function, inputs }).concat()
}

/// A value, and a bound of its rounding error.
#[derive(Clone, Copy, Debug)]
pub struct Bounded {
    pub value: f64,
    pub error: f64,
}

struct RunningError<'a> {
    function: &'a Function,
    inputs: &'a [f64],
}

impl RunningError<'_> {
    fn angle(&self, argument: Expr) -> f64 {
        let at = self.function.inputs.iter().flat_map(|i| &i.entries).position(|e| *e == argument);
        self.inputs[at.expect("the angles of these functions are inputs")]
    }
}

fn exact(value: f64) -> Bounded {
    Bounded { value, error: 0.0 }
}

fn rounded(value: f64, error: f64) -> Bounded {
    Bounded { value, error: error + f64::EPSILON * value.abs() }
}

impl Algebra for RunningError<'_> {
    type Value = Bounded;
    fn constant(&mut self, x: f64) -> Bounded {
        exact(x)
    }
    fn symbol(&mut self, symbol: Symbol) -> Bounded {
        let graph = self.function.graph();
        let entries = || self.function.inputs.iter().flat_map(|i| &i.entries);
        let at = entries().position(|e| matches!(graph.node(*e), Node::Symbol(s) if s == symbol));
        exact(at.map_or(0.0, |k| self.inputs[k]))
    }
    fn sin(&mut self, argument: Expr) -> Bounded {
        Bounded { value: self.angle(argument).sin(), error: f64::EPSILON }
    }
    fn cos(&mut self, argument: Expr) -> Bounded {
        Bounded { value: self.angle(argument).cos(), error: f64::EPSILON }
    }
    fn neg(&mut self, a: &Bounded) -> Bounded {
        Bounded { value: -a.value, error: a.error }
    }
    fn add(&mut self, a: &Bounded, b: &Bounded) -> Bounded {
        rounded(a.value + b.value, a.error + b.error)
    }
    fn sub(&mut self, a: &Bounded, b: &Bounded) -> Bounded {
        rounded(a.value - b.value, a.error + b.error)
    }
    fn mul(&mut self, a: &Bounded, b: &Bounded) -> Bounded {
        rounded(a.value * b.value, a.value.abs() * b.error + b.value.abs() * a.error)
    }
    fn div(&mut self, a: &Bounded, b: &Bounded) -> Bounded {
        let x = a.value / b.value;
        rounded(x, (a.error + x.abs() * b.error) / b.value.abs())
    }
    fn sqrt(&mut self, a: &Bounded) -> Bounded {
        let x = a.value.sqrt();
        rounded(x, 0.5 * a.error / x)
    }
}
