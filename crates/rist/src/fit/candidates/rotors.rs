//! Adds rotor inertias that a description does not give. The rotor inertias are kept if they lower the error on held-out data,
//! or if one of them is significant.
//!
//! Held-out data are segments of the logs that are left out of the fit and predicted. A rotor inertia is significant if zero is
//! outside its interval.

use identification::estimate::digits::significant;
use identification::estimate::rotors::WithRotors;
use identification::estimate::topics::ROTORS_TAKEN;
use linear_model::unit::Unit;

use crate::error::Error;
use crate::fit::search::{Evidence, Proposal, TriedVariant, Variant, WORTHWHILE_ERROR_RATIO};
use crate::fit::undetermined::{lack, may_lack_rotors, rotating};

/// Proposes rotor inertias of all joints, if they lower the error on held-out data. If the rotor inertias are rejected, the fit
/// uses the rows without rotor columns, which are already computed.
pub(crate) fn rotors(tried: &mut TriedVariant<'_>) -> Result<Option<Proposal>, Error> {
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
        "rotor inertias are among the parameters, which {}: the held-out error is {with:.4} instead of {without:.4} ([rotor_inertia=none] omits them)",
        lack(model)
    );
    proposal(tried, evidence, sentence)
}

/// Proposes rotor inertias of all joints, if at least one inertia is significant in the fit and the rotor inertias lower the
/// error on held-out data at all.
pub(crate) fn significant_rotors(tried: &mut TriedVariant<'_>) -> Result<Option<Proposal>, Error> {
    let model = tried.model;
    let fitted = tried.fitted()?;
    let significant_ones = fitted.faults.iter().filter_map(|f| Some((f.significant_rotor()?, f)));
    let Some((k, rotor)) = significant_ones.max_by(|a, b| a.1.value.total_cmp(&b.1.value)) else { return Ok(None) };
    let joint = &fitted.fit.estimate.joints[k];
    let unit = if joint.unit == Unit::TORQUE { "kg m^2" } else { "kg" };
    let sentence = format!(
        "rotor inertias are among the parameters, which {}: the rotor inertia of {} is significant: {} +- {} {unit} ([rotor_inertia=none] omits them)",
        lack(model),
        joint.coordinate,
        significant(rotor.value),
        significant(rotor.deviation)
    );
    let evidence = Evidence::Significant(rotor.held_out.map_or([0.0; 2], |(without, with)| [without, with]));
    proposal(tried, evidence, sentence)
}

/// Proposes the model with rotor inertias, derived again; `None` if the evidence is too weak.
fn proposal(tried: &TriedVariant<'_>, evidence: Evidence, sentence: String) -> Result<Option<Proposal>, Error> {
    if !evidence.is_enough() {
        return Ok(None);
    }
    let variant = Variant { model: Some(rotating(tried.model)?), options: tried.start.clone() };
    Ok(Some(Proposal::mending(variant, evidence, ROTORS_TAKEN, sentence)))
}
