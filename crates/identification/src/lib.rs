//! From logs and experiments to parameters.
//!
//! The folders follow the walk of the data, each importing only from those before it: [`algebra`], [`model`]
//! (tau = Y X + friction + couplings), [`experiments`], [`signals`] (a log becomes states), [`rows`] (states become
//! triangles), [`estimators`] (triangles become a solution), [`estimate`] (a solution becomes an estimate with its
//! evidence), [`portrait`] (what it makes of logs, ready to be drawn), [`simulate`], [`spectrum`] (the experiments of a
//! plan), [`mod@write`].

#![warn(missing_docs)]

pub mod algebra;
pub mod estimate;
pub mod estimators;
pub mod experiments;
pub mod model;
pub mod portrait;
pub mod rows;
pub mod signals;
pub mod simulate;
pub mod spectrum;
#[cfg(test)]
mod test_arm;
pub mod write;
mod yaml;

pub use logs::Error;
