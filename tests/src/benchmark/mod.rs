//! Robots, experiments and estimators to compare. Benches measure them, and tests check their bounds.
//!
//! A recipe of `dataset` runs on measured logs; everything else is simulated.

pub mod arms;
pub mod candidates;
pub mod dataset;
pub mod defects;
pub mod filtered_estimation;
pub mod fleet;
pub mod gain_monte_carlo;
pub mod lack_of_fit;
pub mod monte_carlo;
pub mod plans;
pub mod robots;
pub mod scenario;
pub mod tally;
