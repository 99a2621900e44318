//! RIST-MH: least squares on all harmonics, with friction coefficients as nuisance parameters.

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
