//! Commands of the wing inspection.

pub(crate) mod visibility;
