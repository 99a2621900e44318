//! Identifies parameters from the spectra of periodic experiments: the method of the paper [Vandanjon, Gautier, Desbats 1995] and
//! RIST-MH.

pub mod experiment;
pub mod harmonics;
pub mod identify;
pub mod paper;
pub mod rist_mh;
pub mod validate;
pub mod words;
