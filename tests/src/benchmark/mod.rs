//! Robots, experiments and estimators for comparisons of estimators. Benches print the errors of the estimates, and tests check
//! bounds of these errors.
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
