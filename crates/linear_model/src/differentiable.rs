//! The interface of a base regressor Y(q, dq, ddq) that also computes derivatives with respect to q, dq and ddq. n: number of
//! coordinates; p: number of base parameters X; the torques are Y X.

use crate::regressor::Regressor;

/// A base regressor Y(q, dq, ddq) that also computes derivatives of its entries.
pub trait DifferentiableRegressor: Regressor {
    /// Writes for each of many states the gradient of sum_ic w_ic Y_ic with respect to q, dq and ddq: 3 n numbers per state.
    /// `states`: in the order of [`Regressor::fill_many`]; `weights`: w, n x p per state, row by row.
    fn pull_back(&self, states: &[f64], weights: &[f64], gradient: &mut [f64]);

    /// The function that computes the torques Y X for the parameters X, N m (N). This function is much faster than the
    /// computation of Y.
    fn torques(&self, parameters: &[f64]) -> Box<dyn DifferentiableTorques + '_>;
}

/// The torques Y X of a robot with fixed parameters X, and their derivatives with respect to q, dq and ddq.
pub trait DifferentiableTorques: Send + Sync {
    /// Writes the torques at many states, N m (N), n per state. `states`: in the order of [`Regressor::fill_many`].
    fn fill_many(&self, states: &[f64], torques: &mut [f64]);

    /// Writes for each of many states the gradient of sum_i w_i tau_i with respect to q, dq and ddq: 3 n numbers per state.
    /// `weights`: w, n per state.
    fn pull_back(&self, states: &[f64], weights: &[f64], gradient: &mut [f64]);
}
