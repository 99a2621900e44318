//! From experiments to parameters.

#![warn(missing_docs)]

pub mod algebra;
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
