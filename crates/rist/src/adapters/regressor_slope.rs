//! A model's base regressor with its exact derivative.

use std::sync::Mutex;

use expr::{Adjoint, AdjointWorkspace};
use linear_model::differentiable::DifferentiableRegressor;
use linear_model::parameter::BaseParameter;
use linear_model::regressor::Regressor;

use crate::error::Error;
use crate::model::Model;

/// The regressor of a model, compiled or not, together with the reverse mode of its function.
pub(crate) struct RegressorSlope<'a> {
    regressor: &'a dyn Regressor,
    adjoint: Adjoint,
    /// Workspaces of finished evaluations, to be used again: one a thread at most.
    idle: Mutex<Vec<AdjointWorkspace>>,
}

impl<'a> RegressorSlope<'a> {
    /// Fails where joints are found numerically, because the function does not know how they follow the coordinates.
    pub(crate) fn new(model: &'a Model) -> Result<RegressorSlope<'a>, Error> {
        match model.robot.passive.first() {
            None => Ok(RegressorSlope {
                regressor: model.regressor(),
                adjoint: Adjoint::new(&model.base_regressor),
                idle: Mutex::new(vec![]),
            }),
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
        self.regressor.coordinates()
    }

    fn parameters(&self) -> &[BaseParameter] {
        self.regressor.parameters()
    }

    fn is_prismatic(&self, k: usize) -> bool {
        self.regressor.is_prismatic(k)
    }

    fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) {
        self.regressor.fill(q, dq, ddq, y);
    }

    fn fill_many(&self, states: &[f64], y: &mut [f64]) {
        self.regressor.fill_many(states, y);
    }

    fn non_zeros(&self) -> Vec<(usize, usize)> {
        self.regressor.non_zeros()
    }
}

impl DifferentiableRegressor for RegressorSlope<'_> {
    fn pull_back(&self, states: &[f64], weights: &[f64], gradient: &mut [f64]) {
        let idle = self.idle.lock().ok().and_then(|mut idle| idle.pop());
        let mut work = idle.unwrap_or_else(|| self.adjoint.workspace());
        self.adjoint.pull_back(states, weights, &mut work, gradient);
        // If a panic poisoned the lock, the workspace is just not kept.
        if let Ok(mut idle) = self.idle.lock() {
            idle.push(work);
        }
    }
}
