//! A base regressor that says how it changes with the state.

use crate::regressor::Regressor;

/// A regressor with the derivative of its entries.
pub trait DifferentiableRegressor: Regressor {
    /// For each of many states, one after the other as [`Regressor::fill_many`] takes them, the gradient of
    /// sum_ic w_ic Y_ic with respect to q, dq, ddq: n entries each. `weights`: n x p a state, row by row.
    fn pull_back(&self, states: &[f64], weights: &[f64], gradient: &mut [f64]);

    /// The torques Y X of these parameters, which cost a small part of what Y does.
    fn torques(&self, parameters: &[f64]) -> Box<dyn DifferentiableTorques + '_>;
}

/// The torques of a robot with given parameters, with their derivatives.
pub trait DifferentiableTorques: Send + Sync {
    /// N m (N), n a state, at many states, one after the other as [`Regressor::fill_many`] takes them.
    fn fill_many(&self, states: &[f64], torques: &mut [f64]);

    /// For each of many states the gradient of sum_i w_i tau_i with respect to q, dq, ddq: n entries each. `weights`: n a
    /// state.
    fn pull_back(&self, states: &[f64], weights: &[f64], gradient: &mut [f64]);
}
