use pyo3::prelude::*;

#[pymodule(name = "rist")]
mod module {}
