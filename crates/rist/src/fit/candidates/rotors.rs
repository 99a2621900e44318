//! Rotor inertias that a description does not give: taken where parts left out are predicted better with them, or where
//! their deviation tells one.

use identification::estimate::digits::significant;
use identification::estimate::rotors::WithRotors;
use identification::estimate::topics::ROTORS_TAKEN;
use linear_model::unit::Unit;

use crate::error::Error;
use crate::fit::search::{Evidence, Proposal, Tried, Variant, WORTHWHILE_ERROR_RATIO};
use crate::fit::unspoken::{lack, may_lack_rotors, rotating};

/// Rotors of all joints, by the errors. Where they are not worth it, the rows that were made for it are kept.
pub(crate) fn rotors(tried: &mut Tried<'_>) -> Result<Option<Proposal>, Error> {
    let model = tried.model;
    if !may_lack_rotors(model) {
        return Ok(None);
    }
    let options = tried.options.clone();
    let looked = tried.looked()?;
    let made = match looked.with_rotors.take() {
        None => WithRotors::of_records(model.regressor(), &looked.records, &options)?,
        made => made,
    };
    let Some(rows) = made else { return Ok(None) };
    let errors = <[f64; 2]>::from(rows.errors(model.regressor(), &options));
    looked.rows = Some(rows.without(model.regressor(), &options));
    let evidence = Evidence::Errors { errors, limit: WORTHWHILE_ERROR_RATIO };
    let [without, with] = errors;
    let sentence = format!(
        "rotor inertias are among the parameters, which {}: parts left out are predicted with an error of \
         {with:.4} instead of {without:.4} ([rotor_inertia=none] leaves them out)",
        lack(model)
    );
    proposal(tried, evidence, sentence)
}

/// The same where the fit tells one by its deviation, too small for the errors to tell it by far.
pub(crate) fn significant_rotors(tried: &mut Tried<'_>) -> Result<Option<Proposal>, Error> {
    let model = tried.model;
    let fitted = tried.fitted()?;
    let told = fitted.faults.iter().filter_map(|f| Some((f.told_rotor()?, f)));
    let Some((k, rotor)) = told.max_by(|a, b| a.1.value.total_cmp(&b.1.value)) else { return Ok(None) };
    let joint = &fitted.fit.estimate.joints[k];
    let unit = if joint.unit == Unit::TORQUE { "kg m^2" } else { "kg" };
    let sentence = format!(
        "rotor inertias are among the parameters, which {}: that of {} is told with {} +- {} {unit} \
         ([rotor_inertia=none] leaves them out)",
        lack(model),
        joint.coordinate,
        significant(rotor.value),
        significant(rotor.deviation)
    );
    let evidence = Evidence::Significant(rotor.held_out.map_or([0.0; 2], |(without, with)| [without, with]));
    proposal(tried, evidence, sentence)
}

/// The model with rotors, which costs a derivation, where the evidence is enough.
fn proposal(tried: &Tried<'_>, evidence: Evidence, sentence: String) -> Result<Option<Proposal>, Error> {
    if !evidence.is_enough() {
        return Ok(None);
    }
    let variant = Variant { model: Some(rotating(tried.model)?), options: tried.start.clone() };
    Ok(Some(Proposal::mending(variant, evidence, ROTORS_TAKEN, sentence)))
}
