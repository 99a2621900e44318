//! Monte Carlo, scenarios, recipes.

pub mod dataset;
pub mod filtered_estimation;
pub mod gain_monte_carlo;
pub mod monte_carlo;
pub mod scenario;
