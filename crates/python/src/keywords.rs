//! The options of a call. They are read one by one, and an unknown one is refused with the list of known ones.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::error;

/// The keyword arguments of a call, `None` counting as absent.
pub struct Keywords<'py> {
    function: &'static str,
    known: &'static [&'static str],
    given: Vec<(String, Bound<'py, PyAny>)>,
}

impl<'py> Keywords<'py> {
    /// Refuses a keyword that `function` does not know, with those that it knows.
    pub fn new(
        function: &'static str,
        known: &'static [&'static str],
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Keywords<'py>> {
        let mut given = Vec::new();
        for (name, value) in options.into_iter().flatten() {
            let name: String = name.extract()?;
            if !known.contains(&name.as_str()) {
                let known = known.join(", ");
                return Err(error(format_args!("{function} has no option `{name}`; it has {known}")));
            }
            if !value.is_none() {
                given.push((name, value));
            }
        }
        Ok(Keywords { function, known, given })
    }

    /// The value of an option as given; `None` where it is absent.
    pub fn any(&self, name: &str) -> Option<&Bound<'py, PyAny>> {
        debug_assert!(self.known.contains(&name), "{name} is in the list of {}", self.function);
        self.given.iter().find(|(given, _)| given == name).map(|(_, value)| value)
    }

    /// The value of an option; `expected` says what it can be.
    pub fn get<T>(&self, name: &str, expected: &str) -> PyResult<Option<T>>
    where
        T: for<'a> FromPyObject<'a, 'py>,
    {
        let Some(value) = self.any(name) else { return Ok(None) };
        match value.extract::<T>() {
            Ok(value) => Ok(Some(value)),
            Err(_) => Err(self.wrong(name, expected)),
        }
    }

    /// The error that the value of an option is not as expected.
    pub fn wrong(&self, name: &str, expected: &str) -> PyErr {
        let found = self.any(name).and_then(|value| value.repr().ok()).map_or(String::new(), |r| r.to_string());
        error(format_args!("{}: {name}={found}: {expected} is expected", self.function))
    }

    /// The value of an option that is one of some words.
    pub fn word<T: Copy>(&self, name: &str, words: &[(&str, T)]) -> PyResult<Option<T>> {
        let listed = words.iter().map(|(word, _)| *word).collect::<Vec<_>>().join(", ");
        let Some(word) = self.get::<String>(name, &format!("one of {listed}"))? else { return Ok(None) };
        match words.iter().find(|(known, _)| *known == word) {
            Some((_, value)) => Ok(Some(*value)),
            None => Err(error(format_args!("{}: {name}='{word}': one of {listed} is expected", self.function))),
        }
    }

    /// The given options of a list, as far as they are given.
    pub fn given(&self, names: &[&str]) -> Vec<&str> {
        self.given.iter().map(|(name, _)| name.as_str()).filter(|name| names.contains(name)).collect()
    }
}
