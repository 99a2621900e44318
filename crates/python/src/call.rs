//! Converts the keyword arguments of a Python call to the fields of a request, as the program does with its flags.
//!
//! A request is a struct with all options of a command (crate `rist`). Keywords that are not options of the request, such as
//! callbacks or estimates, are the function's own.

use std::collections::BTreeSet;
use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use rist::request::{Method, Request, unknown};
use serde_json::{Map, Number, Value};

use crate::error::error;

/// The keyword arguments of a call. Arguments with the value None count as absent.
pub struct Call<'py> {
    /// The name of the Python function, for error messages.
    pub function: &'static str,
    /// Names of arguments that are not fields of a request: callbacks, estimates, logs.
    own: &'static [&'static str],
    given: Vec<(String, Bound<'py, PyAny>)>,
}

impl<'py> Call<'py> {
    /// Takes the keywords of `function`. `own`: its keywords that are not fields of its request.
    pub fn new(
        function: &'static str,
        own: &'static [&'static str],
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Call<'py>> {
        let mut given = Vec::new();
        for (name, value) in options.into_iter().flatten() {
            if !value.is_none() {
                given.push((name.extract()?, value));
            }
        }
        Ok(Call { function, own, given })
    }

    /// Takes the keyword `name` of `function` and ignores all others.
    pub fn only(
        function: &'static str,
        name: &'static str,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Call<'py>> {
        let all = Call::new(function, &[], options)?;
        Ok(Call { given: all.given.into_iter().filter(|(given, _)| given == name).collect(), ..all })
    }

    /// Fails if an option does not belong to the identification method. The error names the methods that have it.
    pub fn check_method(&self, method: Method) -> PyResult<()> {
        let others: Vec<&str> =
            self.given.iter().map(|(name, _)| name.as_str()).filter(|name| *name != "method").collect();
        for name in others {
            let mut fields = Method::all().flat_map(|method| [method.fields(), method.files()].concat());
            if fields.all(|field| field.name != name) {
                if self.own.contains(&name) {
                    continue;
                }
                let known = Method::all().flat_map(|method| method.fields()).map(|field| field.name);
                let known: BTreeSet<&str> = known.chain(self.own.iter().copied()).collect();
                return Err(self.refused(unknown(name, known)));
            }
            if let Some(refusal) = method.refusal(name) {
                return Err(self.refused(refusal));
            }
        }
        Ok(())
    }

    /// The argument `name`, which is not a field of the request; `None` if it is absent.
    pub fn own(&self, name: &str) -> Option<&Bound<'py, PyAny>> {
        debug_assert!(self.own.contains(&name), "{name} is in the list of {}", self.function);
        self.given.iter().find(|(given, _)| given == name).map(|(_, value)| value)
    }

    /// Makes the request from all arguments that are not in `own`.
    ///
    /// Fails if there is no such field, or if a field does not accept the value.
    pub fn request<R: Request>(&self) -> PyResult<R> {
        let (mut request, fields) = (R::default(), R::fields());
        for (name, given) in self.given.iter().filter(|(name, _)| !self.own.contains(&name.as_str())) {
            let Some(field) = fields.iter().find(|field| field.name == name) else {
                let known = fields.iter().map(|field| field.name).chain(self.own.iter().copied());
                return Err(self.refused(unknown(name, known)));
            };
            let value = value(given).ok_or_else(|| {
                let found = given.repr().map_or(String::new(), |repr| repr.to_string());
                let expected = &field.shape.expected;
                error(format_args!("{}: [{name}] is {found}; expected is {expected}", self.function))
            })?;
            request.set_value(name, &value).map_err(|e| self.refused(e))?;
        }
        Ok(request)
    }

    /// An error that starts with the name of the Python function.
    fn refused(&self, e: rist::Error) -> PyErr {
        error(format_args!("{}: {e}", self.function))
    }
}

/// Converts a JSON value of the library to a Python object.
pub fn object<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Null => py.None().into_bound(py),
        Value::Bool(truth) => truth.into_pyobject(py)?.to_owned().into_any(),
        Value::Number(number) => match number.as_u64() {
            Some(whole) => whole.into_pyobject(py)?.into_any(),
            None => number.as_f64().into_pyobject(py)?.into_any(),
        },
        Value::String(text) => text.into_pyobject(py)?.into_any(),
        Value::Array(list) => {
            let list = list.iter().map(|x| object(py, x)).collect::<PyResult<Vec<_>>>()?;
            list.into_pyobject(py)?.into_any()
        }
        Value::Object(by_name) => {
            let dict = PyDict::new(py);
            by_name.iter().try_for_each(|(name, x)| dict.set_item(name, object(py, x)?))?;
            dict.into_any()
        }
    })
}

/// Converts a Python object to a JSON value of the library; `None` if JSON has no such value.
fn value(given: &Bound<'_, PyAny>) -> Option<Value> {
    if given.is_none() {
        return Some(Value::Null);
    }
    if let Ok(text) = given.cast::<PyString>() {
        return Some(text.to_string().into());
    }
    // bool is a subclass of int in Python, so it is checked first.
    if let Ok(truth) = given.extract::<bool>() {
        return Some(truth.into());
    }
    if let Ok(whole) = given.extract::<u64>() {
        return Some(whole.into());
    }
    if let Ok(whole) = given.extract::<i64>() {
        return Some(whole.into());
    }
    if let Ok(number) = given.extract::<f64>() {
        return Number::from_f64(number).map(Value::Number);
    }
    if let Ok(by_name) = given.cast::<PyDict>() {
        let one = |(name, x): (Bound<'_, PyAny>, Bound<'_, PyAny>)| Some((name.extract().ok()?, value(&x)?));
        return by_name.iter().map(one).collect::<Option<Map<String, Value>>>().map(Value::Object);
    }
    if let Ok(path) = given.extract::<PathBuf>() {
        return path.to_str().map(Value::from);
    }
    let list = given.try_iter().ok()?;
    list.map(|x| value(&x.ok()?)).collect::<Option<Vec<Value>>>().map(Value::Array)
}
