//! Finds a small tilt of the base relative to the description. The tilt is kept if it lowers the error on held-out data.
//!
//! Held-out data are segments of the logs that are left out of the fit and predicted. The tilt is two unknown rotations of the
//! base, which the fit identifies (`unknowns`).

use std::f64::consts::PI;

use identification::estimate::claims::hypotheses::Hypothesis;
use identification::estimate::digits::significant;
use identification::estimate::held_out::cross_validate;
use identification::estimate::options::Options;
use identification::estimate::topics::MOUNT_TAKEN;
use nalgebra::Vector3;

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::candidates::unknowns::{BEFORE_THE_FIT, Unknowns};
use crate::fit::search::{
    Decisions, Evidence, FitQuestion, Fitted, Proposal, TriedVariant, Variant, WORTHWHILE_ERROR_RATIO, search,
};
use crate::request::{SamplesRequest, UnknownKind};

/// Largest tilt that counts as an error of the fixture, rad. For larger tilts, the log check searches another mount.
const LARGEST_TILT_RAD: f64 = 15.0 * PI / 180.0;

/// Proposes the direction of gravity that the fit identifies. `None` if the user gives the mount, or if the tilt is not
/// significant or too large.
pub(crate) fn mount(tried: &mut TriedVariant<'_>) -> Result<Option<Proposal>, Error> {
    let (model, asked) = (tried.model, tried.asked);
    let is_free = model.description.as_ref().is_none_or(|description| description.base.is_none());
    if !is_free || tried.looked()?.log_check.is_gross() {
        return Ok(None);
    }
    let options = tried.options.clone();
    let fitted = tried.fitted()?;
    if !fitted.faults.iter().any(|fault| matches!(fault.of, Hypothesis::Mount(_)) && fault.gain().is_some()) {
        return Ok(None);
    }
    let without = error(model, fitted, &options);
    let request = SamplesRequest { unknowns: vec![UnknownKind::Mount], ..asked.request.clone() };
    // If the base parameters or the fit fail with a tilt, no tilt is proposed.
    let Ok(unknowns) = Unknowns::find(model, asked.logs, &request) else { return Ok(None) };
    let Some(turned) = unknowns.model.filter(|_| unknowns.is_settled) else { return Ok(None) };
    let [from, to] = [model, &turned].map(|model| Vector3::from(model.robot.gravity_number()));
    let tilt = from.angle(&to);
    if tilt > LARGEST_TILT_RAD {
        return Ok(None);
    }
    let of_turned = |mut tried: TriedVariant<'_>| {
        let (model, options) = (tried.model, tried.options.clone());
        Ok(error(model, tried.fitted()?, &options))
    };
    let asked = FitQuestion { request: &unknowns.request, ..asked };
    let Ok(searched) = search(&turned, asked, tried.start.clone(), &BEFORE_THE_FIT, &of_turned) else {
        return Ok(None);
    };
    let with = searched.end;
    let sentence = format!(
        "the base is taken as tilted by {} deg: the held-out error is {:.4} instead of {:.4} ([base=0,0,0] keeps the nominal one)",
        significant(tilt.to_degrees()),
        with,
        without
    );
    let evidence = Evidence::Errors { errors: [without, with], limit: WORTHWHILE_ERROR_RATIO };
    let variant = Variant { model: Some(turned), options: tried.start.clone() };
    let mut proposal = Proposal::mending(variant, evidence, MOUNT_TAKEN, sentence);
    proposal.found = Decisions {
        unknowns: unknowns.steps,
        sentences: proposal.found.sentences.into_iter().chain(unknowns.remarks).collect(),
        ..proposal.found
    };
    Ok(Some(proposal))
}

/// Relative torque error of a fit on held-out segments of its logs.
fn error(model: &Model, Fitted { fit, .. }: &Fitted, options: &Options) -> f64 {
    cross_validate(&options.linear_model(model.regressor()), &fit.observation, options.weights).total
}
