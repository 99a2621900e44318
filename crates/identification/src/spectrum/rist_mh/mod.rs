//! RIST-MH: weighted least squares on all harmonics of periodic experiments, with friction coefficients as nuisance parameters.
//! `search` explains the method.

pub mod cause;
pub mod data;
pub mod effects;
pub mod fit;
pub mod gains;
pub mod layout;
pub mod misfit;
mod noise_by_frequency;
pub mod search;
mod yielding;
