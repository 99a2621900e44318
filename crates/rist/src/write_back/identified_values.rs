//! Selects the values of an estimate that are written into generated source code.
//!
//! The values are the base parameters X and the friction of each joint. Other identified parameters cannot be written and are
//! listed.

use std::path::Path;

use identification::estimate::artefact::Estimate;
use linear_model::parameter::{FrictionParameter, ParameterId};

use crate::describe::model::{Model, predicts};
use crate::describe::source::IdentifiedValues;
use crate::error::Error;
use crate::fit::verdict::refuse_estimate;
use crate::request::GenerateRequest;

impl IdentifiedValues {
    /// The values of an estimate that was made with the model `model`.
    ///
    /// Fails if a base parameter of the model is missing in the estimate, or is not a finite number.
    pub fn of(model: &Model, estimate: &Estimate) -> Result<IdentifiedValues, Error> {
        use FrictionParameter::{Coulomb, Offset, Viscous};
        let regressor = model.regressor();
        let ids: Vec<ParameterId> = regressor.parameters().iter().map(|p| ParameterId::Base(p.name.clone())).collect();
        let base = ids.iter().map(|id| predicts(estimate, id)).collect::<Result<Vec<f64>, _>>()?;
        let of_coordinate = |c: &String| [Viscous, Coulomb, Offset].map(|f| ParameterId::friction(f, c));
        let friction_ids: Vec<ParameterId> = regressor.coordinates().iter().flat_map(of_coordinate).collect();
        let friction: Vec<f64> = friction_ids.iter().map(|id| estimate.prediction(id).unwrap_or(0.0)).collect();
        if let Some(i) = base.iter().chain(&friction).position(|x| !x.is_finite()) {
            let id = ids.iter().chain(&friction_ids).nth(i).map(ParameterId::to_string).unwrap_or_default();
            return Err(Error::new(format_args!("the value of {id} in the estimate is no finite number")));
        }
        let is_held = |id: &ParameterId| ids.contains(id) || friction_ids.contains(id);
        let left_out = estimate.parameters.iter().filter(|p| !is_held(&p.id)).map(|p| p.id.to_string()).collect();
        Ok(IdentifiedValues { base, friction, left_out, logs: estimate.logs.clone(), monitor: None })
    }
}

impl GenerateRequest {
    /// The values of an estimate for generated source code. `file`: name of the estimate's file, for messages.
    ///
    /// Fails if the estimate was made with another model. Fails if the verdict on the estimate is no, unless `anyway` is set.
    pub fn values(&self, model: &Model, file: &Path, estimate: &Estimate) -> Result<IdentifiedValues, Error> {
        model.check_estimate(file, estimate)?;
        refuse_estimate(file, estimate, self.anyway, "nothing is written ([anyway=true] writes it)")?;
        let refused = |e| Error::new(format_args!("{}: {e}", file.display()));
        IdentifiedValues::of(model, estimate).map_err(refused)
    }
}
