//! Regressors, torques and inertia matrices of a model at many states.
//!
//! ```text
//! tau = Y(q, dq, ddq) X = A(q) ddq + h(q, dq),    h(q, 0) = g(q)
//! ```
//! Symbols: q, dq, ddq (N x n; rad, rad/s, rad/s^2, or m ..); X the base parameters, p of them; Y_s (n x p_s) of the
//! standard parameters; A (n x n, kg m^2); h, g and tau (n; N m, or N of a joint that slides). A state is a row, and its
//! outputs are one matrix, row by row.

use modeling::{Derivation, UnclearRank};

use crate::error::Error;
use crate::model::Model;
use crate::tape::state_tape::{Argument, StateTape};

/// What is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Y_s, n x p_s: torque per unit of each standard parameter.
    Regressor,
    /// Y, n x p: torque per unit of each base parameter.
    BaseRegressor,
    /// tau, n x 1.
    Torque,
    /// A, n x n.
    InertiaMatrix,
    /// h, n x 1: Coriolis, centrifugal and gravity torques.
    Bias,
    /// g, n x 1.
    Gravity,
}

/// States and parameters. An argument that the quantity does not depend on may be empty.
#[derive(Clone, Copy, Debug, Default)]
pub struct ManyStates<'a> {
    /// rad (m), one row per state.
    pub q: &'a [f64],
    /// rad/s (m/s).
    pub dq: &'a [f64],
    /// rad/s^2 (m/s^2).
    pub ddq: &'a [f64],
    /// X, the same for all states; regressors need none.
    pub parameters: &'a [f64],
}

/// One quantity of a model, ready to be evaluated by any number of threads.
pub struct Evaluation {
    source: Source,
    n: usize,
    shape: (usize, usize),
}

enum Source {
    /// The model's own base regressor, which is compiled if this robot is built in.
    Regressor,
    /// Any function of the states.
    Tape(Box<StateTape>),
}

/// States that are evaluated together, so few that their inputs and outputs stay in the cache.
const STATES_PER_PASS: usize = 64;

impl Evaluation {
    /// Derives the functions that the quantity needs.
    ///
    /// Fails where a loop of the robot closes nowhere.
    pub fn new(model: &Model, quantity: Quantity) -> Result<Evaluation, Error> {
        let n = model.robot.n_coordinates();
        if quantity == Quantity::BaseRegressor {
            return Ok(Evaluation { source: Source::Regressor, n, shape: (n, model.parameters.len()) });
        }
        let refused = |e: UnclearRank| Error::new(format_args!("{}: {e}", model.path.display()));
        let mut derivation = Derivation::new(&model.robot).map_err(|e| refused(e.into()))?;
        let function = match quantity {
            Quantity::Regressor | Quantity::BaseRegressor => model.standard_regressor.clone(),
            Quantity::Torque => derivation.inverse_dynamics(&model.parameters).bound(),
            Quantity::InertiaMatrix => derivation.inertia_matrix(&model.parameters).bound(),
            Quantity::Bias => derivation.bias(&model.parameters).bound(),
            Quantity::Gravity => derivation.gravity(&model.parameters).bound(),
        };
        let shape = match quantity {
            Quantity::InertiaMatrix => (n, n),
            Quantity::Regressor | Quantity::BaseRegressor => (n, model.parameters.standard.len()),
            Quantity::Torque | Quantity::Bias | Quantity::Gravity => (n, 1),
        };
        let tape = StateTape::new(&function, derivation.closure());
        Ok(Evaluation { source: Source::Tape(Box::new(tape)), n, shape })
    }

    /// Rows and columns of the outputs of one state.
    pub fn shape(&self) -> (usize, usize) {
        self.shape
    }

    /// Writes the outputs of one state after the other. Where a loop does not close, they are not numbers.
    ///
    /// Fails where the lengths are not those of whole states, of the same number of them, and of the parameters.
    pub fn fill<'a>(&self, model: &Model, states: &ManyStates<'a>, outputs: &mut [f64]) -> Result<(), Error> {
        let (n, size) = (self.n, self.shape.0 * self.shape.1);
        let count = states.q.len().checked_div(n).unwrap_or(0);
        let wrong = |what: &str, expected: usize, found: usize| {
            Err(Error::new(format_args!(
                "{what}: {expected} numbers are expected for {count} states, {found} are there"
            )))
        };
        for (what, given) in [("q", states.q), ("dq", states.dq), ("ddq", states.ddq)] {
            if self.needs(what) && given.len() != count * n {
                return wrong(what, count * n, given.len());
            }
        }
        if let Some(p) = self.parameters().filter(|p| *p != states.parameters.len()) {
            return wrong("parameters", p, states.parameters.len());
        }
        if outputs.len() != count * size {
            return wrong("outputs", count * size, outputs.len());
        }
        if outputs.is_empty() {
            return Ok(());
        }
        for (first, outputs) in (0..count).step_by(STATES_PER_PASS).zip(outputs.chunks_mut(STATES_PER_PASS * size)) {
            let rows = first..count.min(first + STATES_PER_PASS);
            // An argument that is not needed may be empty.
            let row = |x: &'a [f64], k: usize| x.get(k * n..(k + 1) * n).unwrap_or_default();
            let rows = rows.map(|k| [row(states.q, k), row(states.dq, k), row(states.ddq, k)]);
            match &self.source {
                Source::Regressor => {
                    model.regressor().fill_many(&rows.flatten().flatten().copied().collect::<Vec<f64>>(), outputs)
                }
                Source::Tape(tape) => tape.fill(rows, states.parameters, outputs),
            }
        }
        Ok(())
    }

    /// Whether the outputs depend on an argument, `q`, `dq` or `ddq`.
    pub fn needs(&self, argument: &str) -> bool {
        match (&self.source, argument) {
            (_, "q") | (Source::Regressor, _) => true,
            (Source::Tape(tape), "dq") => tape.arguments().contains(&Argument::Dq),
            (Source::Tape(tape), _) => tape.arguments().contains(&Argument::Ddq),
        }
    }

    /// Number of parameters, where the outputs depend on them.
    pub fn parameters(&self) -> Option<usize> {
        let Source::Tape(tape) = &self.source else { return None };
        tape.arguments().iter().find_map(|a| if let Argument::Parameters(p) = a { Some(*p) } else { None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    /// tau = Y X = Y_s X_s = A ddq + h, and h(q, 0) = g, at more states than are evaluated together. The robots are a
    /// tree, a compiled robot, and loops that are closed numerically.
    #[test]
    fn the_quantities_of_a_state_agree() {
        for name in ["tree.yaml", "ur5.yaml", "sr400.par"] {
            let model = Model::read(format!("{}/../../models/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
            let n = model.robot.n_coordinates();
            let mut random = Random::new(5);
            let count = STATES_PER_PASS + 7;
            let mut normal = |count: usize| (0..count).map(|_| 0.3 * random.normal()).collect::<Vec<f64>>();
            let standard = normal(model.parameters.standard.len());
            let (q, dq, ddq, x) =
                (normal(count * n), normal(count * n), normal(count * n), model.parameters.values(&standard));
            let at = |quantity, dq: &[f64]| {
                let evaluation = Evaluation::new(&model, quantity).unwrap();
                let (rows, columns) = evaluation.shape();
                let mut outputs = vec![0.0; count * rows * columns];
                let states = ManyStates { q: &q, dq, ddq: &ddq, parameters: &x };
                evaluation.fill(&model, &states, &mut outputs).unwrap();
                outputs
            };
            let times = |matrices: &[f64], x: &[f64]| -> Vec<f64> {
                matrices.chunks(x.len()).map(|row| row.iter().zip(x).map(|(a, b)| a * b).sum()).collect()
            };
            let torque = at(Quantity::Torque, &dq);
            let inertia = at(Quantity::InertiaMatrix, &dq);
            let accelerated: Vec<f64> = inertia
                .chunks(n * n)
                .zip(ddq.chunks(n))
                .flat_map(|(a, ddq)| times(a, ddq))
                .zip(at(Quantity::Bias, &dq))
                .map(|(a, h)| a + h)
                .collect();
            let at_rest = at(Quantity::Bias, &vec![0.0; count * n]);
            for (what, found, expected) in [
                ("Y X", times(&at(Quantity::BaseRegressor, &dq), &x), &torque),
                ("Y_s X_s", times(&at(Quantity::Regressor, &dq), &standard), &torque),
                ("A ddq + h", accelerated, &torque),
                ("g", at(Quantity::Gravity, &[]), &at_rest),
            ] {
                let open = expected.iter().filter(|x| x.is_nan()).count();
                assert!(open < expected.len() / 2, "{name}: the loops are open at {open} of {}", expected.len());
                for (found, expected) in found.iter().zip(expected) {
                    // Sums of some hundred terms of order one.
                    let close = (found - expected).abs() < 1e-10 * expected.abs().max(1.0);
                    assert!(close || (found.is_nan() && expected.is_nan()), "{name}: {what}: {found} for {expected}");
                }
            }
        }
    }

    #[test]
    fn wrong_lengths_are_refused() {
        let model = Model::read(format!("{}/../../models/planar2r.yaml", env!("CARGO_MANIFEST_DIR"))).unwrap();
        let torque = Evaluation::new(&model, Quantity::Torque).unwrap();
        let (q, x) = ([0.0; 4], vec![0.0; model.parameters.len()]);
        let states = ManyStates { q: &q, dq: &q, ddq: &q[..2], parameters: &x };
        let refused = torque.fill(&model, &states, &mut [0.0; 4]).unwrap_err().to_string();
        assert_eq!(refused, "ddq: 4 numbers are expected for 2 states, 2 are there");
        let states = ManyStates { ddq: &q, parameters: &x[1..], ..states };
        assert!(torque.fill(&model, &states, &mut [0.0; 4]).is_err());
    }
}
