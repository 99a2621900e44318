//! States as NumPy arrays. Inputs are not copied if they are float64 and row-major. Outputs are new arrays.
//!
//! A state has q, dq and ddq. An argument has the shape (N, n) for N states of n coordinates, or (n,) for one state.

use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyTuple, PyWeakrefReference};

use crate::error::error;

/// The numbers of one argument, in row-major order.
pub struct RowMajor<'py> {
    array: PyReadonlyArrayDyn<'py, f64>,
    /// A weak reference to the array. NumPy does not resize an array with such a reference, so its numbers stay at their
    /// address.
    _stays: Bound<'py, PyWeakrefReference>,
}

impl<'py> RowMajor<'py> {
    /// Converts an argument to an array of numbers, as NumPy does. It is copied only if it is not row-major float64. Fails if
    /// values are masked.
    pub fn new(name: &str, x: &Bound<'py, PyAny>) -> PyResult<RowMajor<'py>> {
        if has_masked(x)? {
            return Err(error(format_args!(
                "{name}: some of its values are masked; fill them, or leave their rows out"
            )));
        }
        RowMajor::without_mask(name, x)
    }

    /// Converts an array of a log. Masked values become NaN, like missing values of a log file.
    pub fn of_log(name: &str, x: &Bound<'py, PyAny>) -> PyResult<RowMajor<'py>> {
        if !has_masked(x)? {
            return RowMajor::without_mask(name, x);
        }
        let filled = x.call_method1("astype", ("float64",))?.call_method1("filled", (f64::NAN,))?;
        RowMajor::without_mask(name, &filled)
    }

    fn without_mask(name: &str, x: &Bound<'py, PyAny>) -> PyResult<RowMajor<'py>> {
        let numpy = x.py().import("numpy")?;
        let array = numpy.call_method1("asarray", (x,));
        let expected = |e: PyErr| error(format_args!("{name}: an array of numbers is expected: {e}"));
        let array = array.map_err(expected)?;
        // These types are refused, because NumPy would drop imaginary parts and units of time.
        let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
        let refused = match kind.as_str() {
            "c" => Some("complex numbers; take their real parts"),
            "M" | "m" => Some("times with a unit; give seconds"),
            _ => None,
        };
        if let Some(what) = refused {
            return Err(error(format_args!("{name}: an array of real numbers is expected, and it holds {what}")));
        }
        let options = [("dtype", numpy.getattr("float64")?)].into_py_dict(x.py())?;
        let array = numpy.call_method("ascontiguousarray", (array,), Some(&options)).map_err(expected)?;
        let array = array.cast_into::<PyArrayDyn<f64>>()?;
        let stays = PyWeakrefReference::new(array.as_any())?;
        Ok(RowMajor { array: array.readonly(), _stays: stays })
    }

    /// Length of each dimension.
    pub fn shape(&self) -> &[usize] {
        self.array.shape()
    }

    /// The numbers in row-major order.
    pub fn numbers(&self) -> PyResult<&[f64]> {
        self.array.as_slice().map_err(error)
    }
}

/// Whether `x` is a NumPy masked array in which some values are masked.
fn has_masked(x: &Bound<'_, PyAny>) -> PyResult<bool> {
    let masked = x.py().import("numpy")?.getattr("ma")?;
    let is_masked = x.is_instance(&masked.getattr("MaskedArray")?)?;
    Ok(is_masked && masked.call_method1("is_masked", (x,))?.extract::<bool>()?)
}

/// Converts an array of times (datetime64, timedelta64) to seconds, datetime64 relative to its first instant. `None` for other
/// arrays.
pub fn seconds<'py>(x: &Bound<'py, PyAny>) -> PyResult<Option<Bound<'py, PyAny>>> {
    let numpy = x.py().import("numpy")?;
    let Ok(array) = numpy.call_method1("asanyarray", (x,)) else { return Ok(None) };
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    let durations = match kind.as_str() {
        "M" if array.getattr("size")?.extract::<usize>()? > 0 => {
            array.call_method1("__sub__", (array.getattr("flat")?.get_item(0)?,))?
        }
        "m" => array,
        _ => return Ok(None),
    };
    let second = numpy.call_method1("timedelta64", (1, "s"))?;
    Ok(Some(numpy.call_method1("true_divide", (durations, second))?))
}

/// States of n coordinates in arrays of shape (N, n), or (n,) for one state.
pub struct StateArrays<'py> {
    q: RowMajor<'py>,
    dq: RateArgument<'py>,
    ddq: RateArgument<'py>,
    /// Number of states.
    pub count: usize,
    /// Whether a single state was given, as an array of shape (n,).
    pub is_one: bool,
}

/// Velocities or accelerations of the states: given, or zero.
enum RateArgument<'py> {
    Given(RowMajor<'py>),
    Zero(Vec<f64>),
}

impl<'py> RateArgument<'py> {
    fn new(
        name: &str,
        given: Option<&Bound<'py, PyAny>>,
        q: &RowMajor<'py>,
        needed: bool,
    ) -> PyResult<RateArgument<'py>> {
        let Some(given) = given.filter(|x| !x.is_none()) else {
            return Ok(RateArgument::Zero(if needed { vec![0.0; q.numbers()?.len()] } else { Vec::new() }));
        };
        let given = RowMajor::new(name, given)?;
        if given.shape() != q.shape() {
            let (found, expected) = (shape_text(given.shape()), shape_text(q.shape()));
            return Err(error(format_args!("{name} has the shape {found}; that of q, {expected}, is expected")));
        }
        Ok(RateArgument::Given(given))
    }

    fn numbers(&self) -> PyResult<&[f64]> {
        match self {
            RateArgument::Given(rows) => rows.numbers(),
            RateArgument::Zero(zeros) => Ok(zeros),
        }
    }
}

impl<'py> StateArrays<'py> {
    /// Checks q, dq and ddq, which must have one shape. Absent rates are zero; the zeros are allocated only if they are
    /// `needed`.
    pub fn new(
        coordinates: &[String],
        q: &Bound<'py, PyAny>,
        dq: Option<&Bound<'py, PyAny>>,
        ddq: Option<&Bound<'py, PyAny>>,
        needed: [bool; 2],
    ) -> PyResult<StateArrays<'py>> {
        let (n, q) = (coordinates.len(), RowMajor::new("q", q)?);
        let (count, is_one) = match *q.shape() {
            [columns] if columns == n => (1, true),
            [rows, columns] if columns == n => (rows, false),
            _ => {
                let (found, names) = (shape_text(q.shape()), coordinates.join(", "));
                return Err(error(format_args!(
                    "q has the shape {found}; (N, {n}) is expected, or ({n},) for one state: a column for each of {names}"
                )));
            }
        };
        let dq = RateArgument::new("dq", dq, &q, needed[0])?;
        let ddq = RateArgument::new("ddq", ddq, &q, needed[1])?;
        Ok(StateArrays { q, dq, ddq, count, is_one })
    }

    /// q, dq and ddq with one state per row.
    pub fn numbers(&self) -> PyResult<[&[f64]; 3]> {
        Ok([self.q.numbers()?, self.dq.numbers()?, self.ddq.numbers()?])
    }
}

fn shape_text(shape: &[usize]) -> String {
    match shape {
        [n] => format!("({n},)"),
        _ => format!("({})", shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// A new array with uninitialised content.
pub fn empty<'py>(py: Python<'py>, shape: &[usize]) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let shape = PyTuple::new(py, shape)?;
    Ok(py.import("numpy")?.call_method1("empty", (shape,))?.cast_into()?)
}

/// A new array of shape `shape` with these numbers in row-major order.
pub fn array<'py>(py: Python<'py>, shape: &[usize], numbers: &[f64]) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let array = empty(py, shape)?;
    array.readwrite().as_slice_mut().map_err(error)?.copy_from_slice(numbers);
    Ok(array)
}
