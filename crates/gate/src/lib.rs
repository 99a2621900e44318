//! The gate: bytes of a stranger come in through [`source`], within a cap and a [`budget`]; names of a stranger go out
//! through [`shown`], as what they are. Which files came in, [`opened`] knows. A word that nobody knows goes back with the one that was meant ([`suggestion`]).

pub mod budget;
pub mod opened;
pub mod shown;
pub mod source;
pub mod suggestion;
pub mod unfolding;
