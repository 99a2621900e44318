//! Which column is which signal.

pub mod mapping;
pub mod names;
pub mod words;
