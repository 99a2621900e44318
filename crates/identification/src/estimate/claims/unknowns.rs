//! Estimates parameters together with several unknowns that the user requests: mount (orientation of the base), zeros of
//! positions, scales of torques, or springs.
//!
//! This module makes one Gauss-Newton step from the guess of the unknowns with which the records were made. X: parameters; H:
//! columns of [`hypotheses`], one per unknown; u: difference of the unknowns from the guess:
//!
//! ```text
//! min |W X + H u - tau|
//! ```
//! W: regressor; tau: torques. An unknown is not identifiable if its column is a linear combination of the columns of W and of
//! the preceding unknowns. Such an unknown keeps its guess. The standard deviation of u is a jackknife over tenths of the
//! record, and at least the standard deviation for white noise.
//!
//! Zeros have a prior: guess + u = 0 with the standard deviation [`ZERO_PRIOR_RAD`]. Without this prior, the zero of the first
//! joint of a nearly upright robot would diverge, because only the small tilt of the base determines this zero.
//!
//! [`hypotheses`]: crate::estimate::claims::hypotheses

use linear_model::linear_model::Model;
use linear_model::parameter::ParameterId;
use logs::Error;
use numerics::triangle::{Triangle, TriangleBuilder};

use crate::estimate::artefact::Estimate;
use crate::estimate::claims::hypotheses::{
    EXPLAINED_COLUMN_SHARE, FitPoint, Hypothesis, LEFT_OUT_PARTS, MOST_COORDINATES, UndeterminedMechanics,
    coefficients, held, jackknife, merged, triangles,
};
use crate::estimate::hypothesis::all;
use crate::signals::records::Records;

/// Prior standard deviation of a zero about its described value, rad (11 degrees). The prior changes an identifiable zero
/// little: for example, if the standard deviation of the zero is 1 degree, the prior changes the zero by 1 % of its offset.
pub const ZERO_PRIOR_RAD: f64 = 0.2;

/// The result of one Gauss-Newton step for one unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownStep {
    /// The unknown.
    pub of: Hypothesis,
    /// Difference of the unknown from its guess, and the standard deviation of this difference; `None` if the unknown is not
    /// identifiable.
    pub identified: Option<(f64, f64)>,
    /// Whether the prior, not the data, determines the unknown. This is the case if the standard deviation of the unknown
    /// without the prior exceeds half of the standard deviation of the prior.
    pub is_prior: bool,
    /// Change of each parameter per unit of the unknown; empty if the unknown is not identifiable.
    pub effect: Vec<(ParameterId, f64)>,
}

/// Makes one Gauss-Newton step for the unknowns that `is_wanted` selects; one result per unknown. `fit`: parameters and
/// weights of a fit; `zeros`: guess of the zero of each coordinate relative to the description, rad.
///
/// Fails if the robot has more than 12 coordinates, or if a record cannot be read.
pub fn step<R: Records + ?Sized>(
    model: &Model,
    records: &R,
    fit: FitPoint,
    open: UndeterminedMechanics,
    zeros: &[f64],
    is_wanted: impl Fn(&Hypothesis) -> bool,
) -> Result<Vec<UnknownStep>, Error> {
    if model.n() > MOST_COORDINATES {
        let n = model.n();
        let message =
            format!("additional unknowns are for robots of at most {MOST_COORDINATES} coordinates; this one has {n}");
        return Err(Error::new(message));
    }
    let wanted: Vec<Hypothesis> = all(model, open).into_iter().filter(is_wanted).collect();
    let (parts, _) = triangles(model, records, fit, open, &wanted, LEFT_OUT_PARTS)?;
    let ids: Vec<ParameterId> = model.parameters.iter().map(|p| p.id.clone()).collect();
    Ok(solved(&parts, fit.x, &wanted, &ids, zeros))
}

fn solved(
    parts: &[Triangle],
    x: &[f64],
    wanted: &[Hypothesis],
    ids: &[ParameterId],
    zeros: &[f64],
) -> Vec<UnknownStep> {
    let p = x.len();
    let whole = merged(parts, None);
    let held = held(&whole, x);
    let rows = |out: Option<usize>, prior: Option<&Triangle>| {
        let mut sum = merged(parts, out);
        sum.merge(&held, 1.0);
        prior.iter().for_each(|prior| sum.merge(prior, 1.0));
        sum
    };
    let all_rows = rows(None, None);
    let is_identifiable: Vec<bool> = (0..wanted.len())
        .map(|e| all_rows.at(p + e, p + e).abs() > EXPLAINED_COLUMN_SHARE * whole.column_norm(p + e))
        .collect();
    let free = whole.rows.saturating_sub(p + wanted.len()).max(1) as f64;
    let width = all_rows.columns();
    let noise = all_rows.at(width, width).abs() / free.sqrt();
    let unknowns = |triangle: &Triangle| substituted(triangle, p, &is_identifiable);
    // Values, standard deviations, and standard deviations for white noise of all unknowns; with or without the prior.
    let found = |prior: Option<&Triangle>| {
        let all_rows = rows(None, prior);
        let leaving: Vec<Vec<f64>> = (0..parts.len()).map(|part| unknowns(&rows(Some(part), prior))).collect();
        let scatter = |e: usize| jackknife(&leaving.iter().map(|u| u[e]).collect::<Vec<f64>>());
        let white: Vec<f64> = all_rows.inverse_products(p..width).iter().map(|x| noise * x.sqrt()).collect();
        let deviations: Vec<f64> = (0..wanted.len()).map(|e| scatter(e).max(white[e])).collect();
        (unknowns(&all_rows), deviations, white)
    };
    let (_, alone, white) = found(None);
    let mut prior = TriangleBuilder::new(width);
    for (e, of) in wanted.iter().enumerate().filter(|(e, _)| is_identifiable[*e]) {
        let Hypothesis::Zero(k) = *of else { continue };
        // The row of the prior is scaled by the noise of one data row. This noise is chosen so that the standard deviation for
        // white noise would equal the standard deviation of the jackknife.
        let noise = noise * alone[e] / white[e].max(f64::MIN_POSITIVE);
        let mut row = vec![0.0; width];
        row[p + e] = noise / ZERO_PRIOR_RAD;
        prior.push(&row, -row[p + e] * zeros[k]);
    }
    let prior = prior.finish();
    let (values, deviations, _) = found(Some(&prior));
    let all_rows = rows(None, Some(&prior));
    let one = |(e, of): (usize, &Hypothesis)| {
        if !is_identifiable[e] {
            return UnknownStep { of: *of, identified: None, is_prior: false, effect: Vec::new() };
        }
        // W X + h u = tau, so X changes by -R^-1 h per unit of u.
        let made_of = coefficients(&all_rows, p, p + e);
        let effect = ids.iter().cloned().zip(made_of.into_iter().map(|x| -x)).collect();
        let is_zero = matches!(of, Hypothesis::Zero(_));
        let prior = if is_zero { ZERO_PRIOR_RAD } else { f64::INFINITY };
        // The jackknife does not contain the variance of the prior. So the standard deviation is raised to at least the
        // standard deviation of the posterior (data and prior).
        let deviation = deviations[e].max((alone[e].powi(-2) + prior.powi(-2)).powf(-0.5));
        UnknownStep { of: *of, identified: Some((values[e], deviation)), is_prior: alone[e] > 0.5 * prior, effect }
    };
    wanted.iter().enumerate().map(one).collect()
}

/// The unknowns u by back substitution; their columns follow the first p columns. Unknowns that are not identifiable are
/// zero.
fn substituted(triangle: &Triangle, p: usize, is_identifiable: &[bool]) -> Vec<f64> {
    let width = triangle.columns();
    let mut left: Vec<f64> = (p..width).map(|i| triangle.at(i, width)).collect();
    let mut u = vec![0.0; width - p];
    for e in (0..u.len()).rev().filter(|&e| is_identifiable[e] && triangle.at(p + e, p + e) != 0.0) {
        u[e] = left[e] / triangle.at(p + e, p + e);
        (0..e).for_each(|i| left[i] -= u[e] * triangle.at(p + i, p + e));
    }
    u
}

/// Inflates standard deviations and covariance of the parameters by the uncertainty of the unknowns. Each variance becomes
/// sigma^2 + sum of (effect * deviation)^2. Parameters that were not in the step, such as friction chosen later, do not
/// change.
pub fn inflate_by_unknowns(estimate: &mut Estimate, steps: &[UnknownStep]) {
    let ids: Vec<ParameterId> = estimate.parameters.iter().map(|p| p.id.clone()).collect();
    let square = |step: &UnknownStep, id: &ParameterId| {
        let effect = step.effect.iter().find(|(of, _)| of == id).map_or(0.0, |(_, effect)| *effect);
        step.identified.map_or(0.0, |(_, deviation)| (deviation * effect).powi(2))
    };
    estimate.inflate_sigma(|c| steps.iter().map(|step| square(step, &ids[c])).sum::<f64>().sqrt());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::identified::{Deviations, Identified};
    use linear_model::unit::Unit;

    #[test]
    fn deviations_of_unknowns_reach_their_parameters() {
        let one = |id: &str| {
            let deviations = Deviations { sigma: 0.03, white: Some(0.03), weak: false };
            Identified::new(id.parse().unwrap(), Unit::VISCOUS, 1.0, deviations)
        };
        let mut wide = Estimate { parameters: vec![one("FR1"), one("FV1")], ..Estimate::default() };
        let step = |told, effect: f64| UnknownStep {
            of: Hypothesis::Zero(0),
            identified: told,
            is_prior: false,
            effect: vec![("FV1".parse().unwrap(), effect)],
        };
        inflate_by_unknowns(&mut wide, &[step(Some((0.5, 0.01)), -4.0), step(None, 9.0)]);
        let sigmas: Vec<f64> = wide.parameters.iter().filter_map(|p| p.sigma).collect();
        // Expected: sqrt(sigma^2 + (deviation effect)^2) with sigma = 0.03, deviation = 0.01 and effect = -4.
        assert!(sigmas[0] == 0.03 && (sigmas[1] - 0.05).abs() < 1e-15, "{sigmas:?}");
    }
}
