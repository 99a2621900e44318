//! `rist.BaseParameters`.

use numpy::PyArrayDyn;
use pyo3::prelude::*;
use rist::Parameter;

use crate::arrays::array;
use crate::model::Model;

/// Names of the standard parameters, in the order of their columns.
pub fn standard_names(model: &rist::Model) -> Vec<String> {
    model.parameters.standard.iter().map(|s| s.display(&model.robot).to_string()).collect()
}

/// The least set of parameters on which the torques depend.
#[pyclass(frozen, module = "rist")]
pub struct BaseParameters {
    model: Py<Model>,
}

impl BaseParameters {
    /// Those of a model.
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

    /// How each follows from the standard parameters, exact in the symbols of the description: "ZZR1 = ZZ1 + IA1 + ..".
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

/// What a pickle of base parameters calls.
#[pyfunction]
pub fn _base_parameters(model: Py<Model>) -> BaseParameters {
    BaseParameters::of(model)
}
