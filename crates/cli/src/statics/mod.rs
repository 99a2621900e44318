//! Commands of the wing (optional package) `statics`: postures and wrench.

pub(crate) mod postures;
pub(crate) mod wrench;
