//! Command of the wing (optional package) `formulas`: derive.

pub(crate) mod derive;
