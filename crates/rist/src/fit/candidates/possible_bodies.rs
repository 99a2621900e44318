//! Restricts the parameters to those of physically possible bodies (mass, centre of mass and inertia that a real body can have)
//! if the logs are poor. Otherwise least squares would fit weakly identified parameters to the noise and predict other motions
//! badly.
//!
//! A log is poor in two cases. In the first case, the error of least squares on held-out data is much larger than on the fitted
//! data. In the second case, the error on held-out data is about as large as the error of the description, because noise
//! dominates. The restriction is kept if it lowers the error on held-out quarters of the record, in the first case by far.
//! Measured errors on another motion, without -> with the restriction: 0.501 -> 0.177 (KUKA KR300, fitted to log B, predicts
//! log A), 0.114 -> 0.064 (cobot6, fitted to log 1, predicts log 2). Counterexample: a fit to log A would predict B with 0.144
//! instead of 0.351, but its error on held-out quarters is larger, so the restriction is not kept.
//!
//! tau: torques; W: regression matrix; X: parameters.

use identification::estimate::consistent::errors_on_quarters;
use identification::estimate::identify::Fit;
use identification::estimate::nominal_prediction::nominal_residuals;
use identification::estimate::options::Options;
use identification::estimate::topics::BODIES_TAKEN;

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::search::{
    Decisions, Evidence, Fitted, KeptParameters, Proposal, TriedVariant, Variant, WORTHWHILE_ERROR_RATIO,
};

/// A log is poor if the error on held-out tenths of the log, divided by the error of the fit, is at least this value. Rich logs
/// of a UR10e have 1.09 to 1.12. A log of five harmonics has 1.17, and the fit to this log predicts other motions worse.
const POOR_ERROR_RATIO: f64 = 1.15;
/// Noise dominates if the error of the description with fitted friction, divided by the fit's error on held-out tenths of the
/// log, is at most this value.
const NOISY_ERROR_RATIO: f64 = 1.1;
/// Largest number of coordinates for which physically possible bodies are tried. With more coordinates, the solver takes too
/// long.
const MOST_COORDINATES: usize = 12;

/// Relative error |tau - W X| / |tau| with the base parameters `parameters`, and friction fitted to the residual of these
/// parameters.
pub(crate) fn nominal_error(model: &Model, fit: &Fit, options: &Options, parameters: &[f64]) -> f64 {
    let linear = options.linear_model(model.regressor());
    nominal_residuals(&linear, &fit.observation.joints(|_| true), &fit.weights, parameters).total
}

/// Proposes a fit with physically possible bodies. `None` if the log is rich, if a quarter of the record cannot be fitted, or
/// if the request already decides about the bodies.
pub(crate) fn possible_bodies(tried: &mut TriedVariant<'_>) -> Result<Option<Proposal>, Error> {
    let (model, options) = (tried.model, tried.options.clone());
    if tried.asked.kept != KeptParameters::All || model.robot.n_coordinates() > MOST_COORDINATES {
        return Ok(None);
    }
    let Fitted { fit, .. } = tried.fitted()?;
    let Some((fitted, left_out)) = fit.estimate.total.zip(fit.estimate.cross_validation) else { return Ok(None) };
    let described = model.nominal_parameters().map(|x| nominal_error(model, fit, &options, &x));
    let is_noisy = described.is_some_and(|described| described <= NOISY_ERROR_RATIO * left_out);
    if left_out < POOR_ERROR_RATIO * fitted && !is_noisy {
        return Ok(None);
    }
    let (map, known) = (model.standard_map(), model.reference_bodies());
    let Some(errors) = errors_on_quarters(model.regressor(), &map, &known, fit, &options) else { return Ok(None) };
    let [without, with] = errors;
    let sentence = format!(
        "the log is poor, and the bodies are constrained to be physically possible: the error of held-out quarters is {with:.4} instead of {without:.4} ([free_bodies=true] removes the constraint)"
    );
    let evidence = match is_noisy {
        true => Evidence::Significant(errors),
        false => Evidence::Errors { errors, limit: WORTHWHILE_ERROR_RATIO },
    };
    let mut proposal = Proposal::mending(Variant { model: None, options }, evidence, BODIES_TAKEN, sentence);
    proposal.found = Decisions { possible_bodies: true, ..proposal.found };
    Ok(Some(proposal))
}
