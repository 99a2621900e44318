//! Candidates of the search for the best model and options, one decision per file.

pub(crate) mod contact;
pub(crate) mod dead_current;
pub(crate) mod delay;
pub(crate) mod friction;
pub(crate) mod gains;
pub(crate) mod mount;
pub(crate) mod possible_bodies;
pub(crate) mod rates;
pub(crate) mod rotors;
pub(crate) mod unknowns;
