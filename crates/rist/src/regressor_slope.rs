//! A model's base regressor with its exact derivative.

use expr::Adjoint;
use identification::model::differentiable::DifferentiableRegressor;
use identification::model::parameter::BaseParameter;
use identification::model::regressor::Regressor;

use crate::error::Error;
use crate::model::Model;

/// The regressor of a model, compiled or not, beside the reverse of its function.
pub struct RegressorSlope<'a> {
    regressor: &'a dyn Regressor,
    adjoint: Adjoint,
}

impl<'a> RegressorSlope<'a> {
    /// Fails where joints are found numerically: the function does not know how they follow the coordinates.
    pub fn new(model: &'a Model) -> Result<RegressorSlope<'a>, Error> {
        match model.robot.passive.first() {
            None => Ok(RegressorSlope { regressor: model.regressor(), adjoint: Adjoint::new(&model.base_regressor) }),
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
}

impl DifferentiableRegressor for RegressorSlope<'_> {
    fn pull_back(&self, states: &[f64], weights: &[f64], gradient: &mut [f64]) {
        self.adjoint.pull_back(states, weights, &mut self.adjoint.workspace(), gradient);
    }
}
