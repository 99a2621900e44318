//! Logs as Python arguments: paths, dicts of arrays, data frames.
//!
//! A log has the signals of all joints over time. Output: a path or a table of numbers, which can be used without the
//! interpreter lock.

use std::path::{Path, PathBuf};

use pyo3::exceptions::PyImportError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use rist::{Array, ColumnNames, LogSource, Table};
#[cfg(feature = "statics")]
use statics::{WrenchOptions, Wrenches};

use crate::arrays::{RowMajor, seconds};
use crate::arrow;
use crate::error::{OrError, error};

/// A log argument that can be used without the interpreter lock: a path, or a table of numbers.
pub enum LogArgument {
    Path(PathBuf),
    Table(Box<Table>),
}

impl LogArgument {
    /// Opens the log for a model. `names`: the columns of the signals.
    pub fn open(self, model: &rist::Model, names: &ColumnNames) -> Result<LogSource, rist::Error> {
        match self {
            LogArgument::Path(path) => model.open_log(&path, names).map(|(log, _)| log),
            LogArgument::Table(table) => model.log_of_table(*table, names).map(|(log, _)| log),
        }
    }

    /// Reads the log as a log of a force-torque sensor.
    #[cfg(feature = "statics")]
    pub fn wrenches(self, options: &WrenchOptions) -> Result<Wrenches, rist::Error> {
        Ok(match self {
            LogArgument::Path(path) => Wrenches::read(&path, options)?,
            LogArgument::Table(table) => Wrenches::of_table(&table, options)?,
        })
    }

    /// The path; `None` for a table.
    pub fn path(&self) -> Option<&Path> {
        match self {
            LogArgument::Path(path) => Some(path),
            LogArgument::Table(_) => None,
        }
    }
}

/// The logs of an argument, which is one log or a list of logs.
pub fn logs(given: &Bound<'_, PyAny>) -> PyResult<Vec<LogArgument>> {
    if given.is_instance_of::<PyList>() || given.is_instance_of::<PyTuple>() {
        return given.try_iter()?.enumerate().map(|(k, log)| one(&log?, Some(k + 1))).collect();
    }
    Ok(vec![one(given, None)?])
}

/// Opens logs for a model.
pub fn open(given: Vec<LogArgument>, model: &rist::Model, names: &ColumnNames) -> Result<Vec<LogSource>, rist::Error> {
    given.into_iter().map(|log| log.open(model, names)).collect()
}

/// Takes a path, a dict of arrays, or an object with `__arrow_c_stream__`. `number`: place of the log in a list, for messages.
fn one(given: &Bound<'_, PyAny>, number: Option<usize>) -> PyResult<LogArgument> {
    let named = |what: &str| number.map_or(what.to_string(), |k| format!("{what} {k}"));
    if let Ok(path) = given.extract::<PathBuf>() {
        return Ok(LogArgument::Path(path));
    }
    if let Ok(arrays) = given.cast::<PyDict>() {
        return of_dict(arrays, &named("arrays"));
    }
    if given.hasattr("__arrow_c_stream__")? {
        return of_frame(given, &named("frame"));
    }
    Err(error(format_args!(
        "a log is a path, a dict of arrays ({{'t': .., 'q': .., 'tau': ..}}), or a table with __arrow_c_stream__ (pandas, \
         polars, pyarrow), not {}",
        given.get_type().qualname()?
    )))
}

fn of_dict(given: &Bound<'_, PyDict>, name: &str) -> PyResult<LogArgument> {
    let mut arrays = Vec::new();
    for (key, value) in given {
        let key: String = key.extract().map_err(|_| error(format_args!("{name}: names of arrays are texts")))?;
        arrays.push((key, value));
    }
    of_arrays(arrays, name)
}

/// A table of named arrays of Python.
fn of_arrays(given: Vec<(String, Bound<'_, PyAny>)>, name: &str) -> PyResult<LogArgument> {
    let (mut arrays, mut texts) = (Vec::new(), Vec::new());
    for (key, value) in given {
        let in_seconds = seconds(&value)?;
        match RowMajor::of_log(&key, in_seconds.as_ref().unwrap_or(&value)) {
            // NumPy converts a single number to an array without dimensions.
            Ok(rows) => arrays.push((key, Array { shape: rows.shape().to_vec(), values: rows.numbers()?.to_vec() })),
            Err(_) => texts.push((key, format!("a value of type {}", value.get_type().qualname()?))),
        }
    }
    table(name, arrays, texts)
}

fn of_frame(given: &Bound<'_, PyAny>, name: &str) -> PyResult<LogArgument> {
    let columns = match arrow::columns(given) {
        // pandas needs pyarrow for its Arrow stream; its columns are arrays of NumPy without it.
        Err(e) if e.is_instance_of::<PyImportError>(given.py()) && given.hasattr("columns")? => {
            let mut columns = Vec::new();
            for key in given.getattr("columns")?.try_iter()? {
                let key = key?;
                columns.push((key.str()?.to_string(), given.get_item(&key)?.call_method0("to_numpy")?));
            }
            return of_arrays(columns, name);
        }
        columns => columns?,
    };
    let (mut arrays, mut texts) = (Vec::new(), Vec::new());
    for column in columns {
        match column.content {
            Ok(values) => arrays.push((column.name, Array { shape: vec![values.len()], values })),
            Err(format) => texts.push((column.name, format!("a value of the Arrow type {format}"))),
        }
    }
    table(name, arrays, texts)
}

fn table(name: &str, arrays: Vec<(String, Array)>, texts: Vec<(String, String)>) -> PyResult<LogArgument> {
    let mut table = Table::from_arrays(name, arrays).or_error()?;
    texts.into_iter().for_each(|(column, what)| table.add_text(column, what));
    Ok(LogArgument::Table(Box::new(table)))
}
