//! Tells whether rotor inertias that the model lacks would predict better.
//!
//! The rows with the columns of rotors contain those without, so one pass over the records gives both.

use linear_model::friction::terms::FrictionTerm;
use linear_model::linear_model::Model;
use linear_model::regressor::Regressor;
use logs::Error;

use crate::estimate::held_out::cross_validate;
use crate::estimate::options::Options;
use crate::rows::observation::Observation;
use crate::signals::records::Records;

/// Held-out error with rotor inertias over that without, below which we say so. On measured robots that need none,
/// chance alone stays above it.
const WORTHWHILE_ERROR_RATIO: f64 = 0.97;

/// With errors below this nothing is left to explain, and a difference is rounding.
const NEGLIGIBLE_HELD_OUT_ERROR: f64 = 1e-3;

/// The rows of a model that lacks rotor inertias, with the columns of these inertias added.
pub struct WithRotors {
    friction: Vec<FrictionTerm>,
    observation: Observation,
}

impl WithRotors {
    /// `None` where the model has the columns already.
    ///
    /// Fails when there is no record, or when one cannot be read.
    pub fn of_records<R: Records + ?Sized>(
        regressor: &dyn Regressor,
        records: &R,
        options: &Options,
    ) -> Result<Option<WithRotors>, Error> {
        if options.friction.contains(&FrictionTerm::Rotor) {
            return Ok(None);
        }
        let couplings = options.transmission.coupled();
        let mut friction = options.friction.clone();
        friction.push(FrictionTerm::Rotor);
        let observation = Observation::of_records(&Model::new(regressor, &friction, &couplings), records, None)?;
        Ok(Some(WithRotors { friction, observation }))
    }

    /// The rows without the added columns.
    pub fn without(&self, regressor: &dyn Regressor, options: &Options) -> Observation {
        let couplings = options.transmission.coupled();
        let [wider, model] =
            [&self.friction, &options.friction].map(|friction| Model::new(regressor, friction, &couplings));
        let is_kept = |c: &usize| model.parameters.iter().any(|parameter| parameter.id == wider.parameters[*c].id);
        let columns: Vec<usize> = (0..wider.p()).filter(is_kept).collect();
        self.observation.select(&columns)
    }

    /// A sentence where rotor inertias predict the tenths left out better than the model `without` them.
    pub fn remark(&self, regressor: &dyn Regressor, without: f64, options: &Options) -> Option<String> {
        let couplings = options.transmission.coupled();
        let model = Model::new(regressor, &self.friction, &couplings);
        let with = cross_validate(&model, &self.observation, options.weights).total;
        (with < WORTHWHILE_ERROR_RATIO * without && without > NEGLIGIBLE_HELD_OUT_ERROR).then(|| {
            format!(
                "the model has no rotor inertias; with them ([rotor_inertia=actuated]) the error on tenths left out is \
                 {with:.4} instead of {without:.4}"
            )
        })
    }
}
