//! Compares two errors of cross-validation: of a model without rotor inertias, and of the same model with the columns of rotor
//! inertias added.
//!
//! Rows with rotor columns also contain all columns of the model without rotor inertias. So one pass over the records is enough
//! for both models.

use linear_model::friction::terms::FrictionTerm;
use linear_model::linear_model::Model;
use linear_model::regressor::Regressor;
use logs::Error;

use crate::estimate::held_out::cross_validate;
use crate::estimate::options::Options;
use crate::rows::observation::{Observation, SinglePass};
use crate::signals::records::Records;

/// Rows of records for a model without rotor inertias, with the columns of these inertias added.
pub struct WithRotors {
    friction: Vec<FrictionTerm>,
    observation: Observation,
}

impl WithRotors {
    /// The friction terms of the options with rotor inertias added; `None` if the options already contain rotor inertias.
    fn wider(options: &Options) -> Option<Vec<FrictionTerm>> {
        let is_there = options.friction.contains(&FrictionTerm::Rotor);
        (!is_there).then(|| options.friction.iter().copied().chain([FrictionTerm::Rotor]).collect())
    }

    /// Computes the rows of records with rotor columns; `None` if the options already contain rotor inertias.
    ///
    /// Fails if there is no record, or if a record cannot be read.
    pub fn of_records<R: Records + ?Sized>(
        regressor: &dyn Regressor,
        records: &R,
        options: &Options,
    ) -> Result<Option<WithRotors>, Error> {
        let Some(friction) = WithRotors::wider(options) else { return Ok(None) };
        let observation = Observation::of_records(&options.linear_model_with(regressor, &friction), records, None)?;
        Ok(Some(WithRotors { friction, observation }))
    }

    /// Computes the rows with rotor columns while `look` reads the records (see [`Observation::in_one_pass`]), and also
    /// returns the result of `look`. If the options already contain rotor inertias, `look` is not called and the result is
    /// `None`.
    ///
    /// Fails if a record cannot be read, or if `look` fails.
    pub fn in_one_pass<R: Records + ?Sized, T, E: From<Error>>(
        regressor: &dyn Regressor,
        records: &R,
        options: &Options,
        look: impl FnOnce(&SinglePass<R>) -> Result<T, E>,
    ) -> Result<Option<(T, Option<WithRotors>)>, E> {
        let Some(friction) = WithRotors::wider(options) else { return Ok(None) };
        let (found, rows) = Observation::in_one_pass(&options.linear_model_with(regressor, &friction), records, look)?;
        Ok(Some((found, rows.map(|observation| WithRotors { friction, observation }))))
    }

    /// The rows without the added rotor columns.
    pub fn without(&self, regressor: &dyn Regressor, options: &Options) -> Observation {
        let [wider, model] =
            [&self.friction, &options.friction].map(|friction| options.linear_model_with(regressor, friction));
        let is_kept = |c: &usize| model.parameters.iter().any(|parameter| parameter.id == wider.parameters[*c].id);
        let columns: Vec<usize> = (0..wider.p()).filter(is_kept).collect();
        self.observation.select(&columns)
    }

    /// Relative errors of cross-validation by tenths of the record: (without the added rotor columns, with these columns).
    pub fn errors(&self, regressor: &dyn Regressor, options: &Options) -> (f64, f64) {
        let [wider, model] =
            [&self.friction, &options.friction].map(|friction| options.linear_model_with(regressor, friction));
        let error = |model: &Model, rows: &Observation| cross_validate(model, rows, options.weights).total;
        (error(&model, &self.without(regressor, options)), error(&wider, &self.observation))
    }
}
