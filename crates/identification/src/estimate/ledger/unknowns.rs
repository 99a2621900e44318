//! Unknowns beside the parameters, all at once: what a user who suspects a mount, zeros, scales or springs asks for.
//!
//! One step of Gauss-Newton from a guess that the records were made with. With H the columns of [`hypotheses`]
//! (all of the wanted kinds side by side) and x the fit without them,
//!
//! ```text
//! min |W X + H u - tau|      u: by how much the guess is wrong
//! ```
//! A column that W and the columns before it explain tells nothing; its unknown stays at the guess. The deviation is the
//! scatter of u while tenths of the record are left out (jackknife), at least that of white noise.
//!
//! [`hypotheses`]: crate::estimate::ledger::hypotheses

use linear_model::linear_model::Model;
use linear_model::parameter::ParameterId;
use logs::Error;
use numerics::triangle::Triangle;

use crate::estimate::artefact::Estimate;
use crate::estimate::ledger::hypotheses::{
    EXPLAINED_COLUMN_SHARE, Hypothesis, MOST_COORDINATES, Open, all, coefficients, held, jackknife, merged, triangles,
};
use crate::signals::records::Records;

/// One unknown of a step.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What it is.
    pub of: Hypothesis,
    /// By how much it is beside the guess, and the deviation of that; `None` where nothing tells it.
    pub told: Option<(f64, f64)>,
    /// By how much each parameter changes per unit of it; empty where nothing tells it.
    pub effect: Vec<(ParameterId, f64)>,
}

/// One step for the hypotheses that `is_wanted` takes, beside the parameters `x` with the weights of the joints.
///
/// Fails for a robot of more than 12 coordinates, and when a record cannot be read.
pub fn step<R: Records + ?Sized>(
    model: &Model,
    records: &R,
    x: &[f64],
    weights: &[f64],
    open: Open,
    is_wanted: impl Fn(&Hypothesis) -> bool,
) -> Result<Vec<Step>, Error> {
    if model.n() > MOST_COORDINATES {
        let n = model.n();
        let message = format!(
            "unknowns beside the parameters are for robots of at most {MOST_COORDINATES} coordinates; this one has {n}"
        );
        return Err(Error::new(message));
    }
    let wanted: Vec<Hypothesis> = all(model, open).into_iter().filter(is_wanted).collect();
    let parts = triangles(model, records, x, weights, open, &wanted)?;
    let ids: Vec<ParameterId> = model.parameters.iter().map(|p| p.id.clone()).collect();
    Ok(solved(&parts, x, &wanted, &ids))
}

fn solved(parts: &[Triangle], x: &[f64], wanted: &[Hypothesis], ids: &[ParameterId]) -> Vec<Step> {
    let p = x.len();
    let whole = merged(parts, None);
    let held = held(&whole, x);
    let rows = |out: Option<usize>| {
        let mut sum = merged(parts, out);
        sum.merge(&held, 1.0);
        sum
    };
    let all_rows = rows(None);
    let is_told: Vec<bool> = (0..wanted.len())
        .map(|e| all_rows.at(p + e, p + e).abs() > EXPLAINED_COLUMN_SHARE * whole.column_norm(p + e))
        .collect();
    let unknowns = |triangle: &Triangle| substituted(triangle, p, &is_told);
    let values = unknowns(&all_rows);
    let leaving: Vec<Vec<f64>> = (0..parts.len()).map(|part| unknowns(&rows(Some(part)))).collect();
    let free = whole.rows.saturating_sub(p + wanted.len()).max(1) as f64;
    let width = all_rows.columns();
    let noise = all_rows.at(width, width).abs() / free.sqrt();
    let inverse = all_rows.inverse_products(p..width);
    let one = |(e, of): (usize, &Hypothesis)| {
        if !is_told[e] {
            return Step { of: of.clone(), told: None, effect: Vec::new() };
        }
        let others: Vec<f64> = leaving.iter().map(|u| u[e]).collect();
        let deviation = jackknife(&others).max(noise * inverse[e].sqrt());
        // W X + h u = tau: X changes by -R^-1 of the column.
        let made_of = coefficients(&all_rows, p, p + e);
        let effect = ids.iter().cloned().zip(made_of.into_iter().map(|x| -x)).collect();
        Step { of: of.clone(), told: Some((values[e], deviation)), effect }
    };
    wanted.iter().enumerate().map(one).collect()
}

/// The unknowns behind the first p columns by back substitution; those that are not told are zero.
fn substituted(triangle: &Triangle, p: usize, is_told: &[bool]) -> Vec<f64> {
    let width = triangle.columns();
    let mut left: Vec<f64> = (p..width).map(|i| triangle.at(i, width)).collect();
    let mut u = vec![0.0; width - p];
    for e in (0..u.len()).rev().filter(|&e| is_told[e] && triangle.at(p + e, p + e) != 0.0) {
        u[e] = left[e] / triangle.at(p + e, p + e);
        (0..e).for_each(|i| left[i] -= u[e] * triangle.at(p + i, p + e));
    }
    u
}

/// Widens deviations and covariance by those of unknowns that the parameters were found with: sigma^2 + sum (effect
/// deviation)^2. A parameter that the step did not have, as that of friction chosen later, stays as it is.
pub fn widen_by_unknowns(estimate: &mut Estimate, steps: &[Step]) {
    let ids: Vec<ParameterId> = estimate.parameters.iter().map(|p| p.id.clone()).collect();
    let square = |step: &Step, id: &ParameterId| {
        let effect = step.effect.iter().find(|(of, _)| of == id).map_or(0.0, |(_, effect)| *effect);
        step.told.map_or(0.0, |(_, deviation)| (deviation * effect).powi(2))
    };
    estimate.widen(|c| steps.iter().map(|step| square(step, &ids[c])).sum::<f64>().sqrt());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::identified::{Deviations, Identified};
    use linear_model::unit::Unit;

    /// Parameters are found by their names: friction that was chosen behind the step keeps its deviation, and an unknown that
    /// nothing tells widens nothing.
    #[test]
    fn deviations_of_unknowns_reach_their_parameters() {
        let one = |id: &str| {
            let deviations = Deviations { sigma: 0.03, white: Some(0.03), weak: false };
            Identified::new(id.parse().unwrap(), Unit::VISCOUS, 1.0, deviations)
        };
        let mut wide = Estimate { parameters: vec![one("FR1"), one("FV1")], ..Estimate::default() };
        let step =
            |told, effect: f64| Step { of: Hypothesis::Zero(0), told, effect: vec![("FV1".parse().unwrap(), effect)] };
        widen_by_unknowns(&mut wide, &[step(Some((0.5, 0.01)), -4.0), step(None, 9.0)]);
        let sigmas: Vec<f64> = wide.parameters.iter().filter_map(|p| p.sigma).collect();
        // sqrt(0.03^2 + (0.01 * 4)^2)
        assert!(sigmas[0] == 0.03 && (sigmas[1] - 0.05).abs() < 1e-15, "{sigmas:?}");
    }
}
