//! Compares identified bodies with nominal bodies by their torques at rest.
//!
//! A prismatic joint along gravity carries the same weight in every pose. No motion separates this weight from an offset of the
//! drive: the force at rest is identifiable, but the mass is not. A robot description has no offset of a drive, so the
//! identified bodies get the whole force as weight. Bodies: the inertial parameters of the links.

use linear_model::linear_model::Model;
use linear_model::parameter::{FrictionParameter, Parameter, ParameterId};
use linear_model::regressor::Regressor;
use random::Random;

use crate::estimate::residuals::JointResidual;

/// Number of random poses at which torques at rest are compared.
const COMPARED_POSES: usize = 40;
/// Two rows count as equal if their entries differ by at most this share of the largest entry.
const ROW_ROUNDING_SHARE: f64 = 1e-9;
/// The bodies are refused only if their torque error at rest exceeds the error of the description by more than this share of the
/// rms torque at rest.
const TOLERATED_TORQUE_SHARE: f64 = 0.01;

/// Rows of the regressor at rest (dq = ddq = 0), for each coordinate one row per random pose. `range`: smallest and largest
/// position of each coordinate, rad (m).
fn rows_at_rest(regressor: &dyn Regressor, range: &[(f64, f64)]) -> Vec<Vec<Vec<f64>>> {
    let (n, p) = (regressor.coordinates().len(), regressor.parameters().len());
    let (mut random, rest, mut y) = (Random::new(9), vec![0.0; n], vec![0.0; n * p]);
    let mut rows = vec![Vec::with_capacity(COMPARED_POSES); n];
    for _ in 0..COMPARED_POSES {
        let q: Vec<f64> = range.iter().map(|(low, high)| random.between(*low, *high)).collect();
        regressor.fill(&q, &rest, &rest, &mut y);
        rows.iter_mut().zip(y.chunks(p.max(1))).for_each(|(rows, y)| rows.push(y.to_vec()));
    }
    rows
}

/// Number j of a prismatic joint that carries the same weight in every pose, if the parameter is the drive offset of j;
/// otherwise `None`.
pub fn offset_beside_weight(model: &Model, parameter: &Parameter) -> Option<usize> {
    let is_offset =
        matches!(parameter.id, ParameterId::Friction(FrictionParameter::Offset, _)) && parameter.is_prismatic;
    let joint = *parameter.coordinates.first().filter(|_| is_offset)?;
    let rows = &rows_at_rest(model.regressor, &vec![(-1.0, 1.0); model.n()])[joint];
    let largest = rows[0].iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let is_same = |row: &Vec<f64>| rows[0].iter().zip(row).all(|(a, b)| (a - b).abs() <= ROW_ROUNDING_SHARE * largest);
    (largest > 0.0 && rows.iter().all(is_same)).then_some(joint)
}

/// A reason not to use the identified bodies, from torques at rest; `None` if there is none.
///
/// The torques of the fit `x` are the reference. At one joint, let d be the rms difference between the torques of the bodies
/// and the reference. d is computed for the identified and for the nominal bodies. The identified bodies are refused if their d
/// clearly exceeds the d of the nominal bodies, and also exceeds the rms residual of the fit. `range`: positions in the logs,
/// rad (m); `left`: residuals of the fit.
pub fn farther_at_rest(
    model: &Model,
    x: &[f64],
    bodies: &[f64],
    described: &[f64],
    range: &[(f64, f64)],
    left: &[JointResidual],
) -> Option<String> {
    let mut offsets = vec![0.0; model.n()];
    for (parameter, x) in model.parameters.iter().zip(x) {
        offset_beside_weight(model, parameter).into_iter().for_each(|j| offsets[j] = *x);
    }
    let torque = |row: &[f64], x: &[f64]| row.iter().zip(x).map(|(y, x)| y * x).sum::<f64>();
    let mut joints = left.iter().zip(rows_at_rest(model.regressor, range)).zip(offsets);
    joints.find_map(|((joint, rows), offset)| {
        let root = |of: &[f64]| {
            let square = |row: &Vec<f64>| (torque(row, x) + offset - torque(row, of)).powi(2);
            (rows.iter().map(square).sum::<f64>() / COMPARED_POSES as f64).sqrt()
        };
        let (by_bodies, by_description, whole) = (root(bodies), root(described), root(&[]));
        (by_bodies > by_description + TOLERATED_TORQUE_SHARE * whole && by_bodies > joint.rms).then(|| {
            let name = &joint.coordinate;
            format!(
                "at rest the torque of {name} by these bodies is farther from the log ({by_bodies:.2}) than by the description \
                 ({by_description:.2})"
            )
        })
    })
}
