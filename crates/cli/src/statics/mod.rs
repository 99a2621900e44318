//! The commands of the wing `statics`: postures and wrench.

pub(crate) mod postures;
pub(crate) mod wrench;
