//! Methods that all artefacts have in Python: `read`, `to_yaml`, `save`, a repr that is their table, pickles that are
//! their text.

use std::path::Path;

use pyo3::prelude::*;

use crate::error::OrError;

/// The text of a file.
pub fn read_text(path: &Path) -> PyResult<String> {
    rist::read_text(path).or_error()
}

/// Writes a text to a file that is no input of it.
pub fn save(path: &Path, text: &str, inputs: &[&Path]) -> PyResult<()> {
    rist::output::write_file(path, text, inputs).or_error()
}

/// A class that holds one artefact of the library.
macro_rules! artefact {
    ($name:ident, $inner:ty, $doc:literal, $($more:tt)*) => {
        #[doc = $doc]
        #[pyclass(frozen, module = "rist")]
        pub struct $name {
            pub inner: $inner,
        }

        #[pymethods]
        impl $name {
            /// Reads the YAML file that `save` writes.
            #[staticmethod]
            fn read(path: std::path::PathBuf) -> PyResult<$name> {
                let text = $crate::artefact::read_text(&path)?;
                let inner = <$inner>::from_yaml(&path.display().to_string(), &text).or_error()?;
                Ok($name { inner })
            }

            /// From the text of `to_yaml`.
            #[staticmethod]
            fn from_yaml(text: &str) -> PyResult<$name> {
                Ok($name { inner: <$inner>::from_yaml("text", text).or_error()? })
            }

            /// The text of the file, that of the program byte for byte.
            fn to_yaml(&self) -> PyResult<String> {
                self.inner.to_yaml().or_error()
            }

            /// Writes the YAML file.
            fn save(&self, path: std::path::PathBuf) -> PyResult<()> {
                $crate::artefact::save(&path, &self.to_yaml()?, &[])
            }

            fn __repr__(&self) -> String {
                self.inner.to_string()
            }

            fn _repr_html_(&self) -> String {
                $crate::html::text(&self.inner.to_string())
            }

            fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
                let class = py.get_type::<$name>();
                Ok((class.getattr("from_yaml")?, (self.to_yaml()?,)))
            }

            $($more)*
        }
    };
}
pub(crate) use artefact;
