//! Methods that all artefacts (results of rist that are saved as files) have in Python: `read`, `to_yaml`, `to_dict`, `save`,
//! equality, a table as repr, a page for notebooks, and pickling.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

use pyo3::exceptions::{PyIndexError, PyKeyError, PyTypeError};
use pyo3::prelude::*;

use crate::error::{OrError, error};
use crate::model::Model;

/// Reads a text file.
pub fn read_text(path: &Path) -> PyResult<String> {
    rist::read_text(path).or_error()
}

/// The path of a model's description, as a list; empty without a model.
pub fn description(model: Option<&Py<Model>>) -> Vec<&Path> {
    model.map(|model| model.get().inner.path.as_path()).into_iter().collect()
}

/// Writes a text to a file. Fails if the file is one of the inputs, or a file that an input includes.
pub fn save(path: &Path, text: &str, inputs: &[&Path]) -> PyResult<()> {
    rist::output::write_file(path, text, inputs).or_error()
}

/// Makes a directory, and its parents if necessary.
pub fn make_directory(path: &Path) -> PyResult<()> {
    std::fs::create_dir_all(path).map_err(|e| error(format_args!("{}: {e}", path.display())))
}

/// A hash of a text that is the same in every process.
pub fn hash(text: &str) -> u64 {
    let mut hasher = DefaultHasher::new();
    text.hash(&mut hasher);
    hasher.finish()
}

/// The index of a parameter, given by its name or by a number as for a list (negative: from the end). Raises KeyError with a
/// suggestion, IndexError or TypeError.
pub fn place(given: &Bound<'_, PyAny>, names: &[String]) -> PyResult<usize> {
    if let Ok(index) = given.extract::<isize>() {
        let count = names.len();
        let from_end = if index < 0 { index.checked_add_unsigned(count) } else { Some(index) };
        let found = from_end.and_then(|index| usize::try_from(index).ok()).filter(|index| *index < count);
        return found
            .ok_or_else(|| PyIndexError::new_err(format!("there are {count} parameters, and none at {index}")));
    }
    let Ok(name) = given.extract::<String>() else {
        let found = given.get_type().qualname()?;
        return Err(PyTypeError::new_err(format!("a parameter is asked for by its name or its place, not by {found}")));
    };
    names.iter().position(|known| *known == name).ok_or_else(|| {
        let all: Vec<&str> = names.iter().map(String::as_str).collect();
        let meant = rist::gate::suggestion::did_you_mean(&name, all.iter().copied());
        PyKeyError::new_err(format!("there is no parameter {name}{meant}; there are {}", all.join(", ")))
    })
}

/// Defines a Python class for one artefact type of the library.
macro_rules! artefact {
    ($name:ident, $inner:ty, $doc:literal, $($more:tt)*) => {
        #[doc = $doc]
        #[pyclass(frozen, module = "rist")]
        pub struct $name {
            pub inner: $inner,
            /// The model with which the artefact was made; `None` if it is unknown.
            pub model: Option<Py<$crate::model::Model>>,
        }

        #[pymethods]
        impl $name {
            /// Reads the YAML file that `save` writes.
            #[staticmethod]
            fn read(path: std::path::PathBuf) -> PyResult<$name> {
                let text = $crate::artefact::read_text(&path)?;
                let inner = <$inner>::from_yaml(&path.display().to_string(), &text).or_error()?;
                Ok($name { inner, model: None })
            }

            /// Makes the object from the text of `to_yaml`.
            #[staticmethod]
            fn from_yaml(text: &str) -> PyResult<$name> {
                Ok($name { inner: <$inner>::from_yaml("text", text).or_error()?, model: None })
            }

            /// The text of the file, byte for byte the same as the file of the program.
            fn to_yaml(&self) -> PyResult<String> {
                self.inner.to_yaml().or_error()
            }

            /// Writes the YAML file.
            fn save(&self, path: std::path::PathBuf) -> PyResult<()> {
                let inputs = $crate::artefact::description(self.model.as_ref());
                $crate::artefact::save(&path, &self.to_yaml()?, &inputs)
            }

            fn __repr__(&self) -> String {
                self.inner.to_string()
            }

            fn _repr_html_(&self) -> String {
                let page = self.page(None).and_then(|page| $crate::html::frame(&page));
                page.unwrap_or_else(|| $crate::html::text(&self.inner.to_string()))
            }

            /// The content of the file, as dicts, lists, texts and numbers.
            fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                let values = serde_json::to_value(&self.inner).map_err($crate::error::error)?;
                $crate::call::object(py, &values)
            }

            /// Two objects are equal if their files are the same.
            fn __eq__(&self, other: &Bound<'_, $name>) -> PyResult<bool> {
                Ok(self.to_yaml()? == other.get().to_yaml()?)
            }

            fn __hash__(&self) -> PyResult<u64> {
                Ok($crate::artefact::hash(&self.to_yaml()?))
            }

            /// From the text of a pickle and its model.
            #[staticmethod]
            fn _of(text: &str, model: Option<Py<$crate::model::Model>>) -> PyResult<$name> {
                Ok($name { model, ..$name::from_yaml(text)? })
            }

            fn __reduce__<'py>(
                &self,
                py: Python<'py>,
            ) -> PyResult<(Bound<'py, PyAny>, (String, Option<Py<$crate::model::Model>>))> {
                let class = py.get_type::<$name>();
                let model = self.model.as_ref().map(|model| model.clone_ref(py));
                Ok((class.getattr("_of")?, (self.to_yaml()?, model)))
            }

            $($more)*
        }
    };
}
pub(crate) use artefact;
