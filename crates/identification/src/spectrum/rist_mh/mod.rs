//! RIST-MH: least squares on all harmonics, with friction as nuisance.

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
