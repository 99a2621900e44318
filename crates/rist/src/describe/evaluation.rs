//! Regressors, torques, inertia matrices and any other function of a model at many states.
//!
//! ```text
//! tau = Y(q, dq, ddq) X = A(q) ddq + h(q, dq),    h(q, 0) = g(q)
//! ```
//! Symbols: q, dq, ddq (N states x n coordinates; rad, rad/s, rad/s^2, or m ..); X the p base parameters; Y (n x p); Y_s (n x
//! p_s) the regressor of the p_s standard parameters; A (n x n, kg m^2); h, g and tau (n; N m, or N for a sliding joint). Each
//! state is one row of an array; the output matrices of a state are written row by row.

use modeling::{Derivation, UnclearRank};

use crate::describe::model::Model;
use crate::describe::named_function::function_named;
use crate::error::Error;
use crate::tape::state_tape::{StateArgument, StateTape};

/// The quantities that can be evaluated at a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Y_s, n x p_s: torque per unit of each standard parameter.
    Regressor,
    /// Y, n x p: torque per unit of each base parameter.
    BaseRegressor,
    /// tau, n x 1: torques of the bodies and rotors, without friction.
    Torque,
    /// A, n x n: inertia matrix.
    InertiaMatrix,
    /// h, n x 1: Coriolis, centrifugal and gravity torques.
    Bias,
    /// g, n x 1: gravity torques.
    Gravity,
}

/// Name and shape of a matrix that is computed for each state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputShape {
    /// Name of the matrix: `tau`, `dtau_by_q`.
    pub name: String,
    /// Number of rows; a vector has one column.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
}

/// Arguments of an evaluation at many states. An argument may be empty if the quantity does not depend on it.
#[derive(Clone, Copy, Debug, Default)]
pub struct ManyStates<'a> {
    /// Positions, rad (m), one row per state.
    pub q: &'a [f64],
    /// Velocities, rad/s (m/s), one row per state.
    pub dq: &'a [f64],
    /// Accelerations, rad/s^2 (m/s^2), one row per state.
    pub ddq: &'a [f64],
    /// Parameters X, the same for all states; empty for a regressor.
    pub parameters: &'a [f64],
    /// Further arguments of the function, by name, one row per state: torques `tau`, a `wrench`, a `point`, a pose `t`.
    pub others: &'a [(&'a str, &'a [f64])],
}

/// The kind and number of parameters that a function takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParametersOf {
    /// The p base parameters.
    Base(usize),
    /// The p_s standard parameters: the base parameters do not determine this function.
    Standard(usize),
}

/// A function of a model that can be evaluated at states, also by several threads at the same time.
pub struct Evaluation {
    source: StateSource,
    n: usize,
    outputs: Vec<OutputShape>,
    parameters: Option<ParametersOf>,
}

enum StateSource {
    /// The base regressor of the model, as compiled code if this robot is built in.
    Regressor,
    /// Another function of the state, evaluated by a tape.
    Tape(Box<StateTape>),
}

/// Number of states that are evaluated together. With this number, the inputs and outputs of these states stay in the cache.
const STATES_PER_PASS: usize = 64;

impl Evaluation {
    /// Derives the functions that `quantity` needs.
    ///
    /// Fails if a loop of the robot cannot be closed at any configuration.
    pub fn new(model: &Model, quantity: Quantity) -> Result<Evaluation, Error> {
        let function = match quantity {
            Quantity::BaseRegressor => return Ok(Evaluation::of_regressor(model)),
            Quantity::Regressor => return Evaluation::of_function(model, "regressor"),
            Quantity::Torque => "inverse-dynamics",
            Quantity::InertiaMatrix => "inertia-matrix",
            Quantity::Bias => "bias",
            Quantity::Gravity => "gravity",
        };
        Evaluation::of_function(model, function)
    }

    /// Derives the function of this name. Names are those of `rist generate`: `forward-dynamics`, `pose=5`, `jacobian=5:base`.
    ///
    /// Fails with the list of names if the name is unknown, and fails if a loop of the robot cannot be closed anywhere.
    pub fn of_function(model: &Model, name: &str) -> Result<Evaluation, Error> {
        let refused = |e: UnclearRank| Error::new(format_args!("{}: {e}", model.path.display()));
        let which = function_named(&model.robot, name)?;
        let mut derivation = Derivation::new(&model.robot).map_err(|e| refused(e.into()))?;
        let function = derivation.function(&which, &model.standard_regressor, &model.parameters).bound();
        let shape = |o: &expr::Output| OutputShape { name: o.name.clone(), rows: o.rows, columns: o.columns };
        let outputs = function.outputs.iter().map(shape).collect();
        let tape = StateTape::new(&function, derivation.closure());
        let parameters = tape.arguments.iter().find_map(|a| match *a {
            StateArgument::Parameters(p) if p == model.parameters.len() => Some(ParametersOf::Base(p)),
            StateArgument::Parameters(p) => Some(ParametersOf::Standard(p)),
            _ => None,
        });
        Ok(Evaluation {
            source: StateSource::Tape(Box::new(tape)),
            n: model.robot.n_coordinates(),
            outputs,
            parameters,
        })
    }

    /// Evaluates the base regressor of the model.
    fn of_regressor(model: &Model) -> Evaluation {
        let n = model.robot.n_coordinates();
        let outputs = vec![OutputShape { name: "y".into(), rows: n, columns: model.parameters.len() }];
        Evaluation { source: StateSource::Regressor, n, outputs, parameters: None }
    }

    /// Shapes of the output matrices of a state, in order; each matrix is written row by row.
    pub fn outputs(&self) -> &[OutputShape] {
        &self.outputs
    }

    /// Further arguments of the function (not q, dq, ddq or X): name and number of entries per state.
    pub fn others(&self) -> Vec<(&str, usize)> {
        let StateSource::Tape(tape) = &self.source else { return Vec::new() };
        let other =
            |a| if let &StateArgument::Other(ref name, width) = a { Some((name.as_str(), width)) } else { None };
        tape.arguments.iter().filter_map(other).collect()
    }

    /// Writes the output matrices of all states, one state after the other. The outputs of a state are NaN if a loop does not
    /// close there.
    ///
    /// Fails if the arguments and `outputs` are not for the same number of states, or if X has the wrong length.
    pub fn fill<'a>(&self, model: &Model, states: &ManyStates<'a>, outputs: &mut [f64]) -> Result<(), Error> {
        let (n, size) = (self.n, self.outputs.iter().map(|o| o.rows * o.columns).sum::<usize>());
        let count = match self.others()[..] {
            // The inverse geometric model does not take q. So the first other argument gives the number of states.
            [(name, width), ..] if !self.needs("q") => named(states, name).len().checked_div(width).unwrap_or(0),
            _ => states.q.len().checked_div(n).unwrap_or(0),
        };
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
        if let Some(ParametersOf::Base(p) | ParametersOf::Standard(p)) = self.parameters
            && p != states.parameters.len()
        {
            return wrong("parameters", p, states.parameters.len());
        }
        let others = self.others();
        for (name, width) in &others {
            if named(states, name).len() != count * width {
                return wrong(name, count * width, named(states, name).len());
            }
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
            let some = |(name, width): &(&str, usize)| &named(states, name)[rows.start * width..rows.end * width];
            let others: Vec<&[f64]> = others.iter().map(some).collect();
            let rows = rows.map(|k| [row(states.q, k), row(states.dq, k), row(states.ddq, k)]);
            match &self.source {
                StateSource::Regressor => {
                    model.regressor().fill_many(&rows.flatten().flatten().copied().collect::<Vec<f64>>(), outputs)
                }
                StateSource::Tape(tape) => tape.fill(rows, states.parameters, &others, outputs),
            }
        }
        Ok(())
    }

    /// Whether the outputs depend on an argument, `q`, `dq` or `ddq`.
    pub fn needs(&self, argument: &str) -> bool {
        match (&self.source, argument) {
            (StateSource::Regressor, _) => true,
            (StateSource::Tape(tape), "q") => tape.arguments.contains(&StateArgument::Q),
            (StateSource::Tape(tape), "dq") => tape.arguments.contains(&StateArgument::Dq),
            (StateSource::Tape(tape), _) => tape.arguments.contains(&StateArgument::Ddq),
        }
    }

    /// The parameters on which the outputs depend; `None` if they depend on no parameters.
    pub fn parameters(&self) -> Option<ParametersOf> {
        self.parameters
    }
}

/// The rows of the argument `name`; empty if the argument is not given.
fn named<'a>(states: &ManyStates<'a>, name: &str) -> &'a [f64] {
    states.others.iter().find(|(given, _)| *given == name).map_or(&[], |(_, rows)| rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    /// Checks tau = Y X = Y_s X_s = A ddq + h and h(q, 0) = g, with more states than one pass evaluates. Robots: a tree, a
    /// compiled robot, and a robot with loops that are closed numerically.
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
                let size: usize = evaluation.outputs().iter().map(|o| o.rows * o.columns).sum();
                let mut outputs = vec![0.0; count * size];
                let states = ManyStates { q: &q, dq, ddq: &ddq, parameters: &x, others: &[] };
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
                let not_closed = expected.iter().filter(|x| x.is_nan()).count();
                assert!(
                    not_closed < expected.len() / 2,
                    "{name}: the loops are open at {not_closed} of {}",
                    expected.len()
                );
                for (found, expected) in found.iter().zip(expected) {
                    // Tolerance: rounding of sums of some hundred terms of order one.
                    let close = (found - expected).abs() < 1e-10 * expected.abs().max(1.0);
                    assert!(close || (found.is_nan() && expected.is_nan()), "{name}: {what}: {found} for {expected}");
                }
            }
        }
    }

    #[test]
    fn functions_are_found_by_their_name() {
        let model = Model::read(format!("{}/../../models/ur5.yaml", env!("CARGO_MANIFEST_DIR"))).unwrap();
        let (n, count) = (6, STATES_PER_PASS + 7);
        let mut random = Random::new(6);
        let mut normal = |count: usize| (0..count).map(|_| 0.3 * random.normal()).collect::<Vec<f64>>();
        let (q, dq, ddq) = (normal(count * n), normal(count * n), normal(count * n));
        let x = model.nominal_parameters().unwrap();
        let at = |name: &str, states: ManyStates| {
            let evaluation = Evaluation::of_function(&model, name).unwrap();
            let size: usize = evaluation.outputs().iter().map(|o| o.rows * o.columns).sum();
            let mut outputs = vec![0.0; count * size];
            evaluation.fill(&model, &states, &mut outputs).unwrap();
            outputs
        };
        let states = ManyStates { q: &q, dq: &dq, ddq: &ddq, parameters: &x, others: &[] };
        let tau = at("inverse-dynamics", states);
        let found = at("forward-dynamics", ManyStates { ddq: &[], others: &[("tau", &tau)], ..states });
        let worst = found.iter().zip(&ddq).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Tolerance: rounding, amplified by the condition number of A, up to 1e4.
        assert!(worst < 1e-9, "{worst:e}");

        let derivatives = Evaluation::of_function(&model, "forward-dynamics-derivatives").unwrap();
        let names: Vec<&str> = derivatives.outputs().iter().map(|o| o.name.as_str()).collect();
        assert_eq!((names, derivatives.others()), (vec!["ddq_by_q", "ddq_by_dq", "ddq_by_tau"], vec![("tau", 6)]));
        let refused = derivatives.fill(&model, &states, &mut vec![0.0; count * 108]).unwrap_err().to_string();
        assert_eq!(refused, format!("tau: {} numbers are expected for {count} states, 0 are there", count * n));
    }

    #[test]
    fn wrong_lengths_are_refused() {
        let model = Model::read(format!("{}/../../models/planar2r.yaml", env!("CARGO_MANIFEST_DIR"))).unwrap();
        let torque = Evaluation::new(&model, Quantity::Torque).unwrap();
        let (q, x) = ([0.0; 4], vec![0.0; model.parameters.len()]);
        let states = ManyStates { q: &q, dq: &q, ddq: &q[..2], parameters: &x, others: &[] };
        let refused = torque.fill(&model, &states, &mut [0.0; 4]).unwrap_err().to_string();
        assert_eq!(refused, "ddq: 4 numbers are expected for 2 states, 2 are there");
        let states = ManyStates { ddq: &q, parameters: &x[1..], ..states };
        assert!(torque.fill(&model, &states, &mut [0.0; 4]).is_err());
    }
}
