//! Tells whether rotor inertias that the model lacks would predict better.

use logs::Error;

use crate::estimate::held_out::cross_validate;
use crate::estimate::options::Options;
use crate::model::friction::terms::FrictionTerm;
use crate::model::linear_model::Model;
use crate::model::regressor::Regressor;
use crate::rows::observation::Observation;
use crate::signals::records::Records;

/// Held-out error with rotor inertias over that without, below which we say so. On measured robots that need none,
/// chance alone stays above it.
const WORTH: f64 = 0.97;

/// Where nothing is left to explain, a difference is rounding.
const NOTHING_LEFT: f64 = 1e-3;

/// A sentence where rotor inertias predict the tenths left out better; `observation` is that of the records without
/// them.
///
/// Fails when a record cannot be read again.
pub fn rotors<R: Records + ?Sized>(
    regressor: &dyn Regressor,
    records: &R,
    observation: &Observation,
    options: &Options,
) -> Result<Option<String>, Error> {
    if options.friction.contains(&FrictionTerm::Rotor) {
        return Ok(None);
    }
    let couplings = options.transmission.coupled();
    let total = |friction: &[FrictionTerm], observation: &Observation| {
        cross_validate(&Model::new(regressor, friction, &couplings), observation, options.weights).total
    };
    let mut friction = options.friction.clone();
    friction.push(FrictionTerm::Rotor);
    let wider = Observation::of_records(&Model::new(regressor, &friction, &couplings), records, None)?;
    let (without, with) = (total(&options.friction, observation), total(&friction, &wider));
    Ok((with < WORTH * without && without > NOTHING_LEFT).then(|| {
        format!(
            "the model has no rotor inertias; with them (--rotor-inertia actuated) the error on tenths left out is \
             {with:.4} instead of {without:.4}"
        )
    }))
}
