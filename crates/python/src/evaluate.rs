//! Evaluates functions of a model at states in NumPy arrays.
//!
//! A function is derived at its first use and then kept. States are evaluated in blocks; between two blocks, Ctrl-C is handled.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PySlice, PyTuple};
use rist::describe::evaluation::{Evaluation, ManyStates, ParametersOf, Quantity};

use crate::arrays::{RowMajor, StateArrays, empty};
use crate::error::{OrError, error};
use crate::estimate::Estimate;
use crate::model::Model;
use crate::work::alone;

/// Number of states that are evaluated between two checks for signals (Ctrl-C).
const STATES_PER_PASS: usize = 1 << 14;

/// An argument that can be absent.
pub type OptionalArgument<'a, 'py> = Option<&'a Array<'py>>;

/// An argument with numbers: an array, or an object that NumPy converts to an array.
pub type Array<'py> = Bound<'py, PyAny>;

/// The functions of a model that were derived so far, by name.
#[derive(Default)]
pub struct Evaluations(Mutex<HashMap<String, Arc<Evaluation>>>);

impl Evaluations {
    fn of(&self, py: Python<'_>, model: &Model, function: &str) -> PyResult<Arc<Evaluation>> {
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known().get(function) {
            return Ok(found.clone());
        }
        let inner = &model.inner;
        let made = alone(py, || match function {
            // The base regressor of the model may be compiled code.
            "base-regressor" => Evaluation::new(inner, Quantity::BaseRegressor),
            _ => Evaluation::of_function(inner, function),
        })?;
        Ok(known().entry(function.into()).or_insert(Arc::new(made.or_error()?)).clone())
    }
}

impl Model {
    /// Evaluates a function with one output at states.
    pub fn one(
        &self,
        function: &str,
        states: [OptionalArgument; 3],
        parameters: OptionalArgument,
        others: &[(&str, &Array)],
    ) -> PyResult<Py<PyAny>> {
        let Some(q) = states[0] else { return Err(error("q is missing")) };
        Ok(evaluate(q.py(), self, function, states, parameters, others)?.remove(0).1.unbind())
    }

    /// Evaluates a function at states, and returns all its outputs.
    pub fn several(
        &self,
        function: &str,
        states: [OptionalArgument; 3],
        parameters: OptionalArgument,
        others: &[(&str, &Array)],
    ) -> PyResult<Py<PyTuple>> {
        let Some(q) = states[0] else { return Err(error("q is missing")) };
        let found = evaluate(q.py(), self, function, states, parameters, others)?;
        Ok(PyTuple::new(q.py(), found.into_iter().map(|(_, x)| x))?.unbind())
    }

    /// The parameters for a function: given numbers, the parameters of an estimate, or nominal parameters. Fails if the
    /// function needs standard parameters, but base parameters are given.
    fn parameters(&self, wanted: ParametersOf, given: OptionalArgument<'_, '_>) -> PyResult<Vec<f64>> {
        let (p, standard) = (self.inner.parameters.len(), self.inner.parameters.standard.len());
        let Some(given) = given.filter(|x| !x.is_none()) else {
            let described = match wanted {
                ParametersOf::Base(_) => self.inner.nominal_parameters(),
                ParametersOf::Standard(_) => self.inner.nominal_standard_parameters(),
            };
            return described.ok_or_else(|| {
                let path = self.inner.path.display();
                error(format_args!(
                    "{path}: it has no inertial parameters; give parameters=, {p} base or {standard} standard ones"
                ))
            });
        };
        // Standard parameters cannot be computed from base parameters, because X_base = K X_standard has no inverse.
        let of_bodies = || {
            error(format_args!(
                "parameters: {standard} standard parameters are expected: base ones do not tell what this function needs"
            ))
        };
        if let Ok(estimate) = given.cast::<Estimate>() {
            return match wanted {
                ParametersOf::Base(_) => self.inner.values(&estimate.get().inner).or_error(),
                ParametersOf::Standard(_) => Err(of_bodies()),
            };
        }
        // The number of parameters shows whether they are base or standard parameters.
        let rows = RowMajor::new("parameters", given)?;
        let numbers = rows.numbers()?;
        match (rows.shape(), wanted) {
            ([k], ParametersOf::Standard(_)) if *k == standard => Ok(numbers.to_vec()),
            ([k], ParametersOf::Base(_)) if *k == p => Ok(numbers.to_vec()),
            ([k], ParametersOf::Base(_)) if *k == standard => Ok(self.inner.parameters.values(numbers)),
            ([k], ParametersOf::Standard(_)) if *k == p => Err(of_bodies()),
            _ => Err(error(format_args!(
                "parameters: {p} base parameters or {standard} standard ones are expected, or an Estimate; {} numbers are there",
                numbers.len()
            ))),
        }
    }
}

/// The full name of a function of a link in a frame, for example `jacobian=5:base`.
pub fn of_link(word: &str, link: &str, frame: Option<&str>) -> String {
    frame.map_or_else(|| format!("{word}={link}"), |frame| format!("{word}={link}:{frame}"))
}

/// Keyword arguments as pairs of name and value.
pub fn by_keyword<'py>(given: Option<&Bound<'py, PyDict>>) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    let Some(given) = given else { return Ok(Vec::new()) };
    given.iter().map(|(name, x)| Ok((name.extract()?, x))).collect()
}

/// Evaluates a function at states. Returns its outputs with their names. The first dimension of an output is the state, unless
/// a single state of shape (n,) was given.
pub fn evaluate<'py>(
    py: Python<'py>,
    model: &Model,
    function: &str,
    [q, dq, ddq]: [OptionalArgument<'_, 'py>; 3],
    parameters: OptionalArgument<'_, 'py>,
    others: &[(&str, &Bound<'py, PyAny>)],
) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    let evaluation = model.evaluations.of(py, model, function)?;
    let coordinates = model.inner.regressor().coordinates();
    let needed = [evaluation.needs("dq"), evaluation.needs("ddq")];
    let states = match q {
        Some(q) => Some(StateArrays::new(coordinates, q, dq, ddq, needed)?),
        None if evaluation.needs("q") => return Err(error("q is missing")),
        None => None,
    };
    let others = ExtraInputs::new(&evaluation, others, states.as_ref().map(|s| (s.count, s.is_one)))?;
    let parameters = match evaluation.parameters() {
        Some(wanted) => model.parameters(wanted, parameters)?,
        None => Vec::new(),
    };
    // Without q, the number of states follows from the other inputs.
    let (count, is_one) = states.as_ref().map_or((others.count, others.is_one), |s| (s.count, s.is_one));
    let shapes = evaluation.outputs();
    let size: usize = shapes.iter().map(|o| o.rows * o.columns).sum();
    let outputs = empty(py, &[count, size])?;
    {
        // States are evaluated in blocks, and Ctrl-C is handled between the blocks.
        let mut filled = outputs.readwrite();
        let filled = filled.as_slice_mut().map_err(error)?;
        let [q, dq, ddq] = states.as_ref().map_or(Ok([&[] as &[f64]; 3]), StateArrays::numbers)?;
        let given = others.numbers()?;
        let n = coordinates.len();
        let passes = (0..count).step_by(STATES_PER_PASS).zip(filled.chunks_mut((STATES_PER_PASS * size).max(1)));
        for (first, outputs) in passes {
            let end = count.min(first + STATES_PER_PASS);
            let cut = |x: &[f64], n: usize| (first * n).min(x.len())..(end * n).min(x.len());
            let others: Vec<(&str, &[f64])> =
                given.iter().map(|(name, width, x)| (*name, &x[cut(x, *width)])).collect();
            let [q, dq, ddq] = [q, dq, ddq].map(|x| &x[cut(x, n)]);
            let some = ManyStates { q, dq, ddq, parameters: &parameters, others: &others };
            alone(py, || evaluation.fill(&model.inner, &some, outputs))?.or_error()?;
            py.check_signals()?;
        }
    }
    divided(&outputs, &evaluation, function, (count, is_one))
}

/// Splits the array of outputs into one array per output, each with its own shape. A single output is not copied.
fn divided<'py>(
    outputs: &Bound<'py, PyArrayDyn<f64>>,
    evaluation: &Evaluation,
    function: &str,
    (count, is_one): (usize, bool),
) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    let py = outputs.py();
    let mut first = 0;
    let is_matrix = function.ends_with("regressor") || function.ends_with("matrix");
    let one = |o: &rist::describe::evaluation::OutputShape| {
        let mut shape = if is_one { vec![] } else { vec![count] };
        shape.push(o.rows);
        if o.columns != 1 || is_matrix {
            shape.push(o.columns);
        }
        let end = first + o.rows * o.columns;
        let columns = PySlice::new(py, first as isize, end as isize, 1);
        first = end;
        let part = outputs.get_item((PySlice::full(py), columns))?;
        Ok((o.name.clone(), part.call_method1("reshape", (PyTuple::new(py, shape)?,))?))
    };
    evaluation.outputs().iter().map(one).collect()
}

/// Inputs of a function other than q, dq, ddq and parameters.
struct ExtraInputs<'py> {
    /// For each input: name, number of entries per state, and its array.
    given: Vec<(String, usize, RowMajor<'py>)>,
    count: usize,
    is_one: bool,
}

impl<'py> ExtraInputs<'py> {
    /// `states`: number of states, and whether it is a single state of shape (n,). `None` if q is not given.
    fn new(
        evaluation: &Evaluation,
        given: &[(&str, &Bound<'py, PyAny>)],
        states: Option<(usize, bool)>,
    ) -> PyResult<ExtraInputs<'py>> {
        let wanted = evaluation.others();
        let names = || match wanted.is_empty() {
            true => "nothing else".to_string(),
            false => wanted.iter().map(|(name, _)| format!("{name}=")).collect::<Vec<_>>().join(", "),
        };
        if let Some((name, _)) = given.iter().find(|(name, _)| wanted.iter().all(|(w, _)| w != name)) {
            return Err(error(format_args!("{name}= is not what the function takes: it takes {}", names())));
        }
        let (mut found, mut count) = (Vec::new(), states);
        for (name, width) in &wanted {
            let Some((_, x)) = given.iter().find(|(given, _)| given == name) else {
                return Err(error(format_args!("{name} is missing: the function takes {}", names())));
            };
            let rows = RowMajor::new(name, x)?;
            // For one state, a matrix may have its own shape, without a dimension of states.
            let entries: usize = rows.shape().iter().product();
            let lone = count.map_or(rows.shape().len() == 1 || entries == *width, |(_, is_one)| is_one);
            let (rows_there, is_lone) =
                if lone { (1, true) } else { (rows.shape().first().copied().unwrap_or(0), false) };
            let (expected, is_one) = *count.get_or_insert((rows_there, is_lone));
            if entries != expected * width || (!is_one && rows_there != expected) {
                let shape = if is_one { format!("({width},)") } else { format!("({expected}, {width})") };
                return Err(error(format_args!("{name} has {entries} numbers; the shape {shape} is expected")));
            }
            found.push((name.to_string(), *width, rows));
        }
        let (count, is_one) = count.unwrap_or((0, false));
        Ok(ExtraInputs { given: found, count, is_one })
    }

    fn numbers(&self) -> PyResult<Vec<(&str, usize, &[f64])>> {
        self.given.iter().map(|(name, width, rows)| Ok((name.as_str(), *width, rows.numbers()?))).collect()
    }
}
