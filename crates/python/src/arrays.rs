//! States as arrays of NumPy. An input is not copied if it is float64, row by row. An output is a new array.

use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyTuple, PyWeakrefReference};

use crate::error::error;

/// Numbers of one argument, row by row.
pub struct Rows<'py> {
    array: PyReadonlyArrayDyn<'py, f64>,
    /// NumPy resizes no array that has a weak reference, so that its numbers stay where they are while they are read.
    _stays: Bound<'py, PyWeakrefReference>,
}

impl<'py> Rows<'py> {
    /// Takes anything that NumPy reads as an array of numbers. It is copied only if it is not float64, row by row.
    pub fn new(name: &str, x: &Bound<'py, PyAny>) -> PyResult<Rows<'py>> {
        if has_masked(x)? {
            return Err(error(format_args!(
                "{name}: some of its values are masked; fill them, or leave their rows out"
            )));
        }
        Rows::without_mask(name, x)
    }

    /// The same; masked values are NaN, as what a log does not hold.
    pub fn of_log(name: &str, x: &Bound<'py, PyAny>) -> PyResult<Rows<'py>> {
        if !has_masked(x)? {
            return Rows::without_mask(name, x);
        }
        let filled = x.call_method1("astype", ("float64",))?.call_method1("filled", (f64::NAN,))?;
        Rows::without_mask(name, &filled)
    }

    fn without_mask(name: &str, x: &Bound<'py, PyAny>) -> PyResult<Rows<'py>> {
        let numpy = x.py().import("numpy")?;
        let array = numpy.call_method1("asarray", (x,));
        let expected = |e: PyErr| error(format_args!("{name}: an array of numbers is expected: {e}"));
        let array = array.map_err(expected)?;
        // NumPy would drop imaginary parts, and units of times.
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
        Ok(Rows { array: array.readonly(), _stays: stays })
    }

    /// Length of each dimension.
    pub fn shape(&self) -> &[usize] {
        self.array.shape()
    }

    /// Row by row.
    pub fn numbers(&self) -> PyResult<&[f64]> {
        self.array.as_slice().map_err(error)
    }
}

/// Whether it is a masked array that hides values.
fn has_masked(x: &Bound<'_, PyAny>) -> PyResult<bool> {
    let masked = x.py().import("numpy")?.getattr("ma")?;
    let is_masked = x.is_instance(&masked.getattr("MaskedArray")?)?;
    Ok(is_masked && masked.call_method1("is_masked", (x,))?.extract::<bool>()?)
}

/// An array of times (datetime64, timedelta64) in seconds, those of an instant from the first; `None` of other arrays.
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

/// States of n coordinates: (N, n), or (n,) for one.
pub struct States<'py> {
    q: Rows<'py>,
    dq: Argument<'py>,
    ddq: Argument<'py>,
    /// Number of states.
    pub count: usize,
    /// Whether a single state was given, without the dimension of states.
    pub is_one: bool,
}

/// Rates: given, or at rest.
enum Argument<'py> {
    Given(Rows<'py>),
    Zero(Vec<f64>),
}

impl<'py> Argument<'py> {
    fn new(name: &str, given: Option<&Bound<'py, PyAny>>, q: &Rows<'py>, needed: bool) -> PyResult<Argument<'py>> {
        let Some(given) = given.filter(|x| !x.is_none()) else {
            return Ok(Argument::Zero(if needed { vec![0.0; q.numbers()?.len()] } else { Vec::new() }));
        };
        let given = Rows::new(name, given)?;
        if given.shape() != q.shape() {
            let (found, expected) = (shape_text(given.shape()), shape_text(q.shape()));
            return Err(error(format_args!("{name} has the shape {found}; that of q, {expected}, is expected")));
        }
        Ok(Argument::Given(given))
    }

    fn numbers(&self) -> PyResult<&[f64]> {
        match self {
            Argument::Given(rows) => rows.numbers(),
            Argument::Zero(zeros) => Ok(zeros),
        }
    }
}

impl<'py> States<'py> {
    /// q, dq and ddq of one shape. Absent rates are zero, and these zeros are made only where they are `needed`.
    pub fn new(
        coordinates: &[String],
        q: &Bound<'py, PyAny>,
        dq: Option<&Bound<'py, PyAny>>,
        ddq: Option<&Bound<'py, PyAny>>,
        needed: [bool; 2],
    ) -> PyResult<States<'py>> {
        let (n, q) = (coordinates.len(), Rows::new("q", q)?);
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
        let dq = Argument::new("dq", dq, &q, needed[0])?;
        let ddq = Argument::new("ddq", ddq, &q, needed[1])?;
        Ok(States { q, dq, ddq, count, is_one })
    }

    /// q, dq and ddq, a state a row.
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

/// A new array, not yet filled.
pub fn empty<'py>(py: Python<'py>, shape: &[usize]) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let shape = PyTuple::new(py, shape)?;
    Ok(py.import("numpy")?.call_method1("empty", (shape,))?.cast_into()?)
}

/// An array of these numbers.
pub fn array<'py>(py: Python<'py>, shape: &[usize], numbers: &[f64]) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let array = empty(py, shape)?;
    array.readwrite().as_slice_mut().map_err(error)?.copy_from_slice(numbers);
    Ok(array)
}
