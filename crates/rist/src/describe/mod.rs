//! Derives a model from a description: base parameters, functions of a state, generated source.

pub(crate) mod adapters;
pub(crate) mod conversion;
pub mod description;
pub mod evaluation;
pub mod inspection;
pub mod linting;
pub mod model;
pub(crate) mod named_function;
pub mod source;
pub mod states_file;
pub mod symbols;
pub mod torque_difference;
