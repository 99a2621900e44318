//! From experiments to parameters.

pub mod algebra;
pub mod benchmark;
#[cfg(test)]
mod coverage;
pub mod estimate;
pub mod estimators;
pub mod experiments;
pub mod model;
pub mod rows;
pub mod signals;
pub mod simulate;
pub mod spectrum;
#[cfg(test)]
mod test_arm;
pub mod write;

pub use logs::Error;

#[cfg(test)]
extern crate self as identification;
#[cfg(test)]
#[path = "../tests/tree_robot/candidates.rs"]
mod robot_candidates;
#[cfg(test)]
#[path = "../tests/tally/mod.rs"]
mod tally;
#[cfg(test)]
#[path = "../tests/tree_robot/mod.rs"]
mod tree_robot;
