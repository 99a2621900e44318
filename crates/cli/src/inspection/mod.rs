//! Command of the wing (optional package) `inspection`: visibility.

pub(crate) mod visibility;
