//! Robots, experiments and estimators for comparisons. Benches print their results, and tests check bounds.
//!
//! `dataset` uses measured logs; all other modules use simulated ones.

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
