//! Which column is which signal.

pub(crate) mod mapping;
pub(crate) mod names;
pub(crate) mod words;
