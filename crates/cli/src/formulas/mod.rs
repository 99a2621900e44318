//! The command of the wing `formulas`.

pub(crate) mod derive;
