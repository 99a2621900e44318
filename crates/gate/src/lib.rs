//! Handling of untrusted input: [`source`] reads bytes within a cap and a [`budget`]; [`shown`] escapes names for the output;
//! [`opened`] lists the files that were read. [`suggestion`] finds the valid word that is nearest to a mistyped one.

pub mod budget;
pub mod opened;
pub mod shown;
pub mod source;
pub mod suggestion;
pub mod unfolding;
