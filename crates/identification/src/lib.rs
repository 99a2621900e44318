//! Identifies inertial and friction parameters from logs, with their standard deviations and claims. A claim is a statement of
//! rist about a log or an estimate, with the evidence for it.
//!
//! The folders follow the order of data processing, and each imports only from the previous ones: [`signals`] (from a log to
//! states), [`rows`] (from states to triangles), [`estimators`] (from triangles to a solution), [`estimate`] (from a solution to
//! an estimate with its evidence), [`plot_data`] (data of plots of logs and estimates), [`spectrum`] (identification from the
//! experiments of a plan). A triangle is the R of a QR decomposition.
//!
//! This crate depends on the linear model, the numerics, experiments, robots and logs.
//!
//! Not here: the model tau = Y X (`linear_model`); triangles and transforms (`numerics`); motions, plans and simulation
//! (`experiments`); changes of descriptions (`rist`). This crate uses no symbolic expressions.

#![warn(missing_docs)]

pub mod estimate;
pub mod estimators;
pub mod plot_data;
pub mod rows;
pub mod signals;
pub mod spectrum;
#[cfg(test)]
mod test_arm;

pub use logs::Error;
