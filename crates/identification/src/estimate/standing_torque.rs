//! Torques at rest, by which bodies are compared with those of a description.
//!
//! A joint that slides along gravity carries the same weight everywhere, which no motion tells from an offset of its drive: the
//! force at rest is told, and its mass is not. A file of bodies has no offset, so all of that force counts as weight there.

use linear_model::linear_model::Model;
use linear_model::parameter::{FrictionParameter, Parameter, ParameterId};
use linear_model::regressor::Regressor;
use random::Random;

/// Poses at which torques are compared.
const POSES: usize = 40;
/// Rounding of a row, as a share of its largest entry.
const ROUNDING: f64 = 1e-9;
/// Share of the torque at rest by which bodies may be farther than the description.
const COUNTED_SHARE: f64 = 0.01;

/// The rows of the base parameters at rest, at poses within this range: n x p each.
fn rows_at_rest(regressor: &dyn Regressor, range: &[(f64, f64)], poses: usize) -> Vec<Vec<f64>> {
    let (n, p) = (regressor.coordinates().len(), regressor.parameters().len());
    let (mut random, rest) = (Random::new(9), vec![0.0; n]);
    let mut row = |_: usize| {
        let q: Vec<f64> = range.iter().map(|(low, high)| random.between(*low, *high)).collect();
        let mut y = vec![0.0; n * p];
        regressor.fill(&q, &rest, &rest, &mut y);
        y
    };
    (0..poses).map(&mut row).collect()
}

/// Whether joint j slides and carries the same weight in every pose.
pub(super) fn carries_weight(regressor: &dyn Regressor, j: usize) -> bool {
    let (n, p) = (regressor.coordinates().len(), regressor.parameters().len());
    let rows = rows_at_rest(regressor, &vec![(-1.0, 1.0); n], 3);
    let of = |row: usize| &rows[row][j * p..][..p];
    let largest = of(0).iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let is_same = |row: usize| of(0).iter().zip(of(row)).all(|(a, b)| (a - b).abs() <= ROUNDING * largest);
    regressor.is_prismatic(j) && largest > 0.0 && (1..rows.len()).all(is_same)
}

/// The joint whose offset a parameter is, where that joint carries the same weight in every pose.
pub fn offset_beside_weight(model: &Model, parameter: &Parameter) -> Option<usize> {
    let is_offset = matches!(parameter.id, ParameterId::Friction(FrictionParameter::Offset, _));
    let joint = *parameter.coordinates.first().filter(|_| is_offset)?;
    carries_weight(model.regressor, joint).then_some(joint)
}

/// Why bodies are not to be used: at rest some joint's torque by them is farther from that of the fit `x` than that by the
/// description. `range`: where the joints were seen.
pub fn farther_at_rest(
    model: &Model,
    x: &[f64],
    bodies: &[f64],
    described: &[f64],
    range: &[(f64, f64)],
) -> Option<String> {
    let p = model.regressor.parameters().len();
    let rows = rows_at_rest(model.regressor, range, POSES);
    let mut offsets = vec![0.0; model.n()];
    for (parameter, x) in model.parameters.iter().zip(x) {
        offset_beside_weight(model, parameter).into_iter().for_each(|j| offsets[j] = *x);
    }
    let torque = |row: &[f64], x: &[f64]| row.iter().zip(x).map(|(y, x)| y * x).sum::<f64>();
    let root = |j: usize, of: &dyn Fn(&[f64]) -> f64| {
        (rows.iter().map(|row| of(&row[j * p..][..p]).powi(2)).sum::<f64>() / POSES as f64).sqrt()
    };
    (0..model.n()).find_map(|j| {
        let told = |row: &[f64]| torque(row, &x[..p]) + offsets[j];
        let error = |x: &[f64]| root(j, &|row| told(row) - torque(row, x));
        let (by_bodies, by_description) = (error(&bodies[..p]), error(described));
        (by_bodies > by_description + COUNTED_SHARE * root(j, &told)).then(|| {
            format!(
                "at rest the torque of {} by these bodies is farther from the log ({by_bodies:.2}) than by the description \
                 ({by_description:.2})",
                model.regressor.coordinates()[j]
            )
        })
    })
}
