//! Base regressor of a model with exact derivatives, for the search of an exciting motion.
//!
//! Y: base regressor, tau = Y X, X: base parameters. One backward pass through the operations of a function (reverse
//! differentiation) gives the derivatives of a weighted sum of its outputs with respect to all inputs.

use std::sync::Mutex;

use expr::{Adjoint, AdjointWorkspace, Function, Tape};
use linear_model::differentiable::{DifferentiableRegressor, DifferentiableTorques};
use linear_model::parameter::BaseParameter;
use linear_model::regressor::Regressor;

use crate::describe::model::Model;
use crate::error::Error;
use crate::tape::thread_tapes::ThreadTapes;

/// The base regressor of a model, with derivatives by reverse differentiation.
pub(crate) struct RegressorSlope<'a> {
    model: &'a Model,
    slope: Slope,
}

/// The torques of a model with fixed parameter values, with derivatives by reverse differentiation.
struct TorqueSlope {
    tapes: ThreadTapes,
    slope: Slope,
}

/// Derivatives of a function by reverse differentiation. Several threads may use this struct at the same time.
struct Slope {
    adjoint: Adjoint,
    /// Workspaces of finished evaluations, for reuse: at most one per thread.
    idle: Mutex<Vec<AdjointWorkspace>>,
}

impl Slope {
    fn new(function: &Function) -> Slope {
        Slope { adjoint: Adjoint::new(function), idle: Mutex::new(vec![]) }
    }

    fn pull_back(&self, states: &[f64], weights: &[f64], gradient: &mut [f64]) {
        let idle = self.idle.lock().ok().and_then(|mut idle| idle.pop());
        let mut work = idle.unwrap_or_else(|| self.adjoint.workspace());
        self.adjoint.pull_back(states, weights, &mut work, gradient);
        // If a panic poisoned the lock, the workspace is dropped instead of being reused.
        if let Ok(mut idle) = self.idle.lock() {
            idle.push(work);
        }
    }
}

impl<'a> RegressorSlope<'a> {
    /// Fails if a loop is closed numerically, because the function then lacks the dependence of the passive joints on q.
    pub(crate) fn new(model: &'a Model) -> Result<RegressorSlope<'a>, Error> {
        match model.robot.passive.first() {
            None => Ok(RegressorSlope { model, slope: Slope::new(&model.base_regressor) }),
            Some(passive) => Err(Error::new(format_args!(
                "{}: `{}` is found numerically by the closure of a loop; exciting motions are for robots whose joints \
                 are functions of the coordinates; `rist plan` has experiments for the others",
                model.path.display(),
                passive.name
            ))),
        }
    }
}

impl Regressor for RegressorSlope<'_> {
    fn coordinates(&self) -> &[String] {
        self.model.regressor().coordinates()
    }

    fn parameters(&self) -> &[BaseParameter] {
        self.model.regressor().parameters()
    }

    fn is_prismatic(&self, k: usize) -> bool {
        self.model.regressor().is_prismatic(k)
    }

    fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) {
        self.model.regressor().fill(q, dq, ddq, y);
    }

    fn fill_many(&self, states: &[f64], y: &mut [f64]) {
        self.model.regressor().fill_many(states, y);
    }

    fn non_zeros(&self) -> Vec<(usize, usize)> {
        self.model.regressor().non_zeros()
    }
}

impl DifferentiableRegressor for RegressorSlope<'_> {
    fn pull_back(&self, states: &[f64], weights: &[f64], gradient: &mut [f64]) {
        self.slope.pull_back(states, weights, gradient);
    }

    /// Uses the torque function of standard parameters. Each base parameter is written to the standard parameter of the column
    /// that the base regressor keeps for it, and all other standard parameters are zero. The resulting torques are equal.
    fn torques(&self, parameters: &[f64]) -> Box<dyn DifferentiableTorques + '_> {
        let mut standard = vec![0.0; self.model.parameters.standard.len()];
        self.model.parameters.base.iter().zip(parameters).for_each(|(base, x)| standard[base.column] = *x);
        let function = self.model.torque.at_input("torque_of_robot", "x", &standard);
        Box::new(TorqueSlope { tapes: ThreadTapes::new(vec![Tape::new(&function)]), slope: Slope::new(&function) })
    }
}

impl DifferentiableTorques for TorqueSlope {
    fn fill_many(&self, states: &[f64], torques: &mut [f64]) {
        self.tapes.with(|tapes, work, _| tapes[0].evaluate_many(states, &mut work[0], torques));
    }

    fn pull_back(&self, states: &[f64], weights: &[f64], gradient: &mut [f64]) {
        self.slope.pull_back(states, weights, gradient);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    #[test]
    fn torques_are_those_of_the_regressor() {
        for name in ["ur5.urdf", "scara.yaml", "stanford.yaml", "race.yaml"] {
            let path = format!("{}/../../models/{name}", env!("CARGO_MANIFEST_DIR"));
            let model = Model::read(&path).unwrap();
            let slope = RegressorSlope::new(&model).unwrap();
            let (n, p) = (slope.coordinates().len(), slope.parameters().len());
            let mut random = Random::new(5);
            let mut normal = |count: usize| (0..count).map(|_| random.normal()).collect::<Vec<f64>>();
            let (states, x, weights) = (normal(11 * 3 * n), normal(p), normal(11 * n));
            let torques = slope.torques(&x);
            let (mut tau, mut gradient) = (vec![0.0; 11 * n], vec![0.0; 11 * 3 * n]);
            torques.fill_many(&states, &mut tau);
            torques.pull_back(&states, &weights, &mut gradient);
            let (mut y, mut expected) = (vec![0.0; 11 * n * p], vec![0.0; 11 * 3 * n]);
            slope.fill_many(&states, &mut y);
            let outer: Vec<f64> = weights.iter().flat_map(|w| x.iter().map(move |x| w * x)).collect();
            slope.pull_back(&states, &outer, &mut expected);
            let products = y.chunks_exact(p).map(|row| row.iter().zip(&x).map(|(y, x)| y * x).sum::<f64>());
            let pairs = tau.iter().copied().zip(products).chain(gradient.iter().copied().zip(expected));
            for (found, expected) in pairs.collect::<Vec<(f64, f64)>>() {
                // Tolerance: rounding of sums of some hundred terms of order one.
                assert!((found - expected).abs() < 1e-11 * (1.0 + expected.abs()), "{name}: {found} {expected}");
            }
        }
    }
}
