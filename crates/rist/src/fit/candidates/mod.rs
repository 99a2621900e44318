//! Candidates of the search for the best model and options, one decision per file.
//!
//! A candidate proposes a variant: a changed model or changed options of the fit. Module `search` compares the errors on
//! held-out data (segments of the logs that are left out of the fit and predicted) without and with the variant, and keeps or
//! rejects it.

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
