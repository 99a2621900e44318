//! RIST-MH: all harmonics, friction as nuisance.

pub mod data;
pub mod fit;
pub mod gains;
pub mod search;
