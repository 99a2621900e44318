//! Inputs from a model and its estimate, for a replay and for a generated monitor. A replay runs the observer of external
//! torques over a log. A monitor is the same computation as generated C code.
//!
//! The covariance of the parameters gives the errors of the torques that the model predicts.

use identification::estimate::artefact::Estimate;
use identification::estimate::identified::Identified;
use linear_model::linear_model::Model as LinearModel;
use nalgebra::DMatrix;

use crate::describe::model::Model;

/// Contact ends after this time below half of the threshold, s. Pushes of a person last longer.
pub(crate) const HOLD_S: f64 = 0.1;

/// The name of the last link: the link with the most links before it. If several links have this number, the first of them.
pub(crate) fn last_link(model: &Model) -> String {
    let before = |link: &robot::Link| link.antecedent.map(|before| model.robot.link(before));
    let depth = |link: &robot::Link| std::iter::successors(before(link), |link| before(link)).count();
    let deepest = model.robot.links.iter().rev().max_by_key(|link| depth(link));
    deepest.map_or(String::new(), |link| link.name.clone())
}

/// The covariance of all parameters of the linear model, in the order of the model, for the errors of predicted torques.
/// `None` if the estimate has no covariance.
///
/// In the covariance of an estimate, possible faults inflate the standard deviation of each parameter separately, while the
/// correlations stay the same. With this covariance, errors of several parameters that cancel in every torque would no longer
/// cancel. So the covariance for white noise is used for torques. It is multiplied by the median ratio of the variances for
/// correlated and for white residuals.
pub(crate) fn covariance(linear: &LinearModel, estimate: &Estimate) -> Option<DMatrix<f64>> {
    if estimate.covariance.is_empty() {
        return None;
    }
    let place = |k: usize| estimate.parameters.iter().position(|p| p.id == linear.parameters[k].id);
    let places: Vec<Option<usize>> = (0..linear.p()).map(place).collect();
    let correlated = estimate.discount().sqrt();
    let to_white = |p: &Identified| Some(correlated * p.white_sigma? / p.sigma?).filter(|ratio| ratio.is_finite());
    let ratios: Vec<f64> = estimate.parameters.iter().map(|p| to_white(p).unwrap_or(1.0)).collect();
    let entry = |r: usize, c: usize| {
        let of = |(r, c): (usize, usize)| ratios[r] * ratios[c] * estimate.covariance[r][c];
        let value = places[r].zip(places[c]).map_or(0.0, of);
        if value.is_finite() { value } else { 0.0 }
    };
    Some(DMatrix::from_fn(linear.p(), linear.p(), entry))
}
