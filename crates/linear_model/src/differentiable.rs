//! A base regressor with derivatives with respect to the state.

use crate::regressor::Regressor;

/// A regressor with the derivatives of its entries.
pub trait DifferentiableRegressor: Regressor {
    /// Writes for each of many states the gradient of sum_ic w_ic Y_ic with respect to q, dq and ddq, n entries each. `states`:
    /// in the order of [`Regressor::fill_many`]; `weights`: w, n x p per state, row by row.
    fn pull_back(&self, states: &[f64], weights: &[f64], gradient: &mut [f64]);

    /// The torques Y X for the parameters X, N m (N). They take a small share of the time of Y.
    fn torques(&self, parameters: &[f64]) -> Box<dyn DifferentiableTorques + '_>;
}

/// The torques of a robot with given parameters, and their derivatives.
pub trait DifferentiableTorques: Send + Sync {
    /// Writes the torques at many states, N m (N), n per state. `states`: in the order of [`Regressor::fill_many`].
    fn fill_many(&self, states: &[f64], torques: &mut [f64]);

    /// Writes for each of many states the gradient of sum_i w_i tau_i with respect to q, dq and ddq, n entries each. `weights`:
    /// w, n per state.
    fn pull_back(&self, states: &[f64], weights: &[f64], gradient: &mut [f64]);
}
