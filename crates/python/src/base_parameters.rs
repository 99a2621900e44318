//! The class `rist.BaseParameters`.
//!
//! It lists the base parameters of a model, with the rules by which they follow from the standard parameters.

use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator, PyList};
use rist::Parameter;

use crate::arrays::array;
use crate::artefact::{hash, place};
use crate::model::Model;

/// Names of the standard parameters, in the order of their columns.
pub fn standard_names(model: &rist::Model) -> Vec<String> {
    model.parameters.standard.iter().map(|s| s.display(&model.robot).to_string()).collect()
}

/// The smallest set of parameters on which the torques depend.
#[pyclass(frozen, module = "rist")]
pub struct BaseParameters {
    model: Py<Model>,
}

impl BaseParameters {
    /// The base parameters of a model.
    pub fn of(model: Py<Model>) -> BaseParameters {
        BaseParameters { model }
    }

    fn inner(&self) -> &rist::Model {
        &self.model.get().inner
    }
}

#[pymethods]
impl BaseParameters {
    /// p names, in the order of the columns of `base_regressor`.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.inner().parameters.base.iter().map(|b| b.name.clone()).collect()
    }

    /// SI units, one per parameter.
    #[getter]
    fn units(&self) -> Vec<String> {
        self.inner().regressor().parameters().iter().map(|base| Parameter::from(base).unit().to_string()).collect()
    }

    /// The regrouping rule of each base parameter: how it follows from the standard parameters, exact in the symbols of the
    /// description, "ZZR1 = ZZ1 + IA1 + ..".
    #[getter]
    fn rules(&self) -> Vec<String> {
        self.inner().parameters.rules().base
    }

    /// Standard parameters without effect on the torques, by name.
    #[getter]
    fn no_effect(&self) -> Vec<String> {
        let names = standard_names(self.inner());
        self.inner().parameters.no_effect.iter().map(|&k| names[k].clone()).collect()
    }

    /// K, shape (p, p_s): X_base = K X_standard.
    #[getter]
    fn matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (base, columns) = (&self.inner().parameters.base, self.inner().parameters.standard.len());
        let mut numbers = vec![0.0; base.len() * columns];
        for (k, b) in base.iter().enumerate() {
            b.terms.iter().for_each(|t| numbers[k * columns + t.parameter] = t.coefficient);
        }
        array(py, &[base.len(), columns], &numbers)
    }

    /// The rule of a parameter by its name, base["ZZR1"], or by its index, as in a list.
    fn __getitem__(&self, name: &Bound<'_, PyAny>) -> PyResult<String> {
        let (names, mut rules) = (self.names(), self.rules());
        Ok(rules.swap_remove(place(name, &names)?))
    }

    fn __contains__(&self, name: &str) -> bool {
        self.names().iter().any(|known| known == name)
    }

    /// The names.
    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        PyList::new(py, self.names())?.try_iter()
    }

    /// Rules by name.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        self.names().iter().zip(self.rules()).try_for_each(|(name, rule)| dict.set_item(name, rule))?;
        Ok(dict)
    }

    fn __eq__(&self, other: &Bound<'_, BaseParameters>) -> bool {
        let other = other.get();
        self.names() == other.names() && self.rules() == other.rules()
    }

    fn __hash__(&self) -> u64 {
        hash(&self.rules().join("\n"))
    }

    fn __len__(&self) -> usize {
        self.inner().parameters.len()
    }

    fn __repr__(&self) -> String {
        self.inner().parameters.rule_lines().join("\n")
    }

    fn _repr_html_(&self) -> String {
        self.model.get().rules_table()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Py<Model>,))> {
        Ok((py.import("rist")?.getattr("_base_parameters")?, (self.model.clone_ref(py),)))
    }
}

/// Rebuilds base parameters from their pickle.
#[pyfunction]
pub fn _base_parameters(model: Py<Model>) -> BaseParameters {
    BaseParameters::of(model)
}
