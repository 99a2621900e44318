//! The gate: bytes of a stranger come in through [`source`], within a cap and a [`budget`]; names of a stranger go out
//! through [`shown`], as what they are.

pub mod budget;
pub mod shown;
pub mod source;
pub mod unfolding;
