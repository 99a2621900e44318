//! Estimates drive gains together with the parameters.

pub mod equations;
pub mod likelihood;
pub mod replicates;
pub mod total_least_squares;
