//! From logs to parameters, and what may be said of them.
//!
//! The folders follow the walk of the data, each importing only from those before it: [`signals`] (a log becomes
//! states), [`rows`] (states become triangles), [`estimators`] (triangles become a solution), [`estimate`] (a solution
//! becomes an estimate with its evidence), [`portrait`] (what it makes of logs, ready to be drawn), [`spectrum`] (the
//! experiments of a plan).
//!
//! It knows the linear model, the numbers, experiments, robots and logs.
//!
//! Not here: tau = Y X itself (`linear_model`), triangles and transforms (`numerics`), motions, plans and simulation
//! (`experiments`), writing back into descriptions (`rist`). It never sees an expression.

#![warn(missing_docs)]

pub mod estimate;
pub mod estimators;
pub mod portrait;
pub mod rows;
pub mod signals;
pub mod spectrum;
#[cfg(test)]
mod test_arm;

pub use logs::Error;
