//! Bodies that can exist, where the logs are poor: least squares gives what a poor log leaves open to noise, and other motions
//! are then predicted badly.
//!
//! A log is poor where least squares predicts parts left out much worse than what was fitted, or where the description
//! predicts about as well: noise then decides. Bodies that can exist are taken where quarters of the record are predicted better
//! with them, by far in the first case. Measured, error on another motion: 0.501 -> 0.177 (KUKA KR300, B for A), 0.114 -> 0.064
//! (cobot6, 1 for 2). A for B would be 0.351 -> 0.144, but the quarters of A say the opposite, and it is left alone.

use identification::estimate::consistent::errors_on_quarters;
use identification::estimate::described::described_residuals;
use identification::estimate::identify::Fit;
use identification::estimate::options::Options;
use identification::estimate::topics::BODIES_TAKEN;

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::search::{Decisions, Evidence, Fitted, Kept, Proposal, Tried, Variant, WORTHWHILE_ERROR_RATIO};

/// Error on tenths left out over that of the fit, from which on a log is poor. Rich logs of a UR10e have 1.09 to 1.12, a log
/// of five harmonics, which predicts others worse, 1.17.
const POOR_ERROR_RATIO: f64 = 1.15;
/// Error of the description, its friction fitted, over that on tenths left out, up to which noise decides.
const DESCRIBED_ERROR_RATIO: f64 = 1.1;
/// The solver takes too long with more coordinates.
const MOST_COORDINATES: usize = 12;

/// |tau - W X| / |tau| with these base parameters, and friction fitted to the remainder.
pub(crate) fn described_error(model: &Model, fit: &Fit, options: &Options, parameters: &[f64]) -> f64 {
    let linear = options.linear_model(model.regressor());
    described_residuals(&linear, &fit.observation.joints(|_| true), &fit.weights, parameters).total
}

/// All parameters, of bodies that can exist.
pub(crate) fn possible_bodies(tried: &mut Tried<'_>) -> Result<Option<Proposal>, Error> {
    let (model, options) = (tried.model, tried.options.clone());
    if tried.asked.kept != Kept::All || model.robot.n_coordinates() > MOST_COORDINATES {
        return Ok(None);
    }
    let Fitted { fit, .. } = tried.fitted()?;
    let Some((fitted, left_out)) = fit.estimate.total.zip(fit.estimate.cross_validation) else { return Ok(None) };
    let described = model.described_parameters().map(|x| described_error(model, fit, &options, &x));
    let is_noisy = described.is_some_and(|described| described <= DESCRIBED_ERROR_RATIO * left_out);
    if left_out < POOR_ERROR_RATIO * fitted && !is_noisy {
        return Ok(None);
    }
    let (map, known) = (model.standard_map(), model.reference_bodies());
    let Some(errors) = errors_on_quarters(model.regressor(), &map, &known, fit, &options) else { return Ok(None) };
    let [without, with] = errors;
    let sentence = format!(
        "the log is poor, and the values are those of bodies that can exist: quarters left out are predicted with an error of \
         {with:.4} instead of {without:.4} ([free_bodies=true] leaves bodies free)"
    );
    let evidence = match is_noisy {
        true => Evidence::Significant(errors),
        false => Evidence::Errors { errors, limit: WORTHWHILE_ERROR_RATIO },
    };
    let mut proposal = Proposal::mending(Variant { model: None, options }, evidence, BODIES_TAKEN, sentence);
    proposal.found = Decisions { possible_bodies: true, ..proposal.found };
    Ok(Some(proposal))
}
