//! A base regressor that says how it changes with the state.

use crate::regressor::Regressor;

/// A regressor with the derivative of its entries.
pub trait DifferentiableRegressor: Regressor {
    /// For each of many states, one after the other as [`Regressor::fill_many`] takes them, the gradient of
    /// sum_ic w_ic Y_ic with respect to q, dq, ddq: n entries each. `weights`: n x p a state, row by row.
    fn pull_back(&self, states: &[f64], weights: &[f64], gradient: &mut [f64]);
}
