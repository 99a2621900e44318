//! Identifies parameters from the spectra of periodic experiments, with two methods. One is the method of the paper
//! [Vandanjon, Gautier, Desbats 1995] (`paper`). The other is RIST-MH (`rist_mh`): weighted least squares on all harmonics,
//! with friction as nuisance.

pub mod experiment;
pub mod harmonics;
pub mod identify;
pub mod paper;
pub mod rist_mh;
pub mod validate;
pub mod words;
