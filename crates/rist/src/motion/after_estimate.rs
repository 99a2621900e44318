//! Uses an earlier estimate as prior information in the search of the next motion.
//!
//! Let S be the covariance of the estimate and R'R = S^-1. The rows R are appended to the regression rows of the motion, so
//! that the determinant is computed from the information of the estimate and of the motion. If an estimate has no covariance,
//! its parameters count as uncorrelated, with their standard deviations. By Hadamard's inequality, this does not overstate the
//! determinant. The noise of a torque sample is computed from the estimate's residuals:
//!
//! ```text
//! sigma_j = rms_j sqrt(rate / (2 cutoff)) sqrt(discount)
//! ```
//! rms_j, N m (N): rms residual of joint j below the cut-off. rate and cutoff, Hz. discount: the factor by which the
//! variances for white noise are too small ([`Estimate::discount`]).

use experiments::excitation::proof::NominalFriction;
use identification::estimate::artefact::Estimate;
use linear_model::linear_model::Model as LinearModel;
use linear_model::parameter::{FrictionParameter, ParameterId};
use nalgebra::{Cholesky, DMatrix};

/// The rows R, row by row, with one entry per column of `model`; columns of parameters that the estimate lacks are zero. Also
/// returns notes if the file was changed or has no covariance.
pub(crate) fn prior_rows(estimate: &Estimate, model: &LinearModel) -> (Vec<f64>, Vec<String>) {
    let p = model.p();
    let column = |id: &ParameterId| model.parameters.iter().position(|own| own.id == *id);
    // Each entry: (index in the estimate, index in the model, sigma).
    let known: Vec<(usize, usize, f64)> = estimate
        .parameters
        .iter()
        .enumerate()
        .filter_map(|(i, found)| Some((i, column(&found.id)?, found.sigma.filter(|s| s.is_finite() && *s > 0.0)?)))
        .collect();
    let m = known.len();
    // The covariance is scaled to a correlation matrix, because parameters differ by orders of magnitude.
    let entry = |a: usize, b: usize| {
        let ((i, _, s), (j, _, t)) = (known[a], known[b]);
        estimate.covariance.get(i).and_then(|row| row.get(j)).map_or(f64::NAN, |x| x / (s * t))
    };
    let correlation = DMatrix::from_fn(m, m, entry);
    let inverse = Cholesky::new(correlation).map(|c| c.inverse()).and_then(Cholesky::new);
    let note = inverse.is_none().then(|| {
        "the earlier estimate has no covariance that can be used: its errors are taken as independent, and what it \
         says only about sums of parameters is lost (covariance: true in the [options] of identify keeps it)"
            .to_string()
    });
    let upper = inverse.map_or(DMatrix::identity(m, m), |c| c.l().transpose());
    let mut rows = vec![0.0; m * p];
    for a in 0..m {
        for (b, (_, c, sigma)) in known.iter().enumerate() {
            rows[a * p + c] = upper[(a, b)] / sigma;
        }
    }
    (rows, estimate.checksum.note("[after]").into_iter().chain(note).collect())
}

/// Noise (sigma) of a torque sample of a coordinate at `rate`, Hz, from the residuals, N m (N); `None` for a joint without
/// residuals.
pub(crate) fn residual_noise(estimate: &Estimate, coordinate: &str, rate: f64) -> Option<f64> {
    let joint = estimate.joints.iter().find(|j| j.coordinate == coordinate)?;
    let band = estimate.cutoff.map_or(1.0, |hz| (rate / (2.0 * hz)).max(1.0));
    Some(joint.rms * (band * estimate.discount()).sqrt()).filter(|x| x.is_finite() && *x > 0.0)
}

/// Friction of the joint of `coordinate` by an estimate. Friction parameters that the estimate lacks are taken from
/// `described`.
pub(crate) fn identified_friction(
    estimate: &Estimate,
    coordinate: &str,
    described: NominalFriction,
) -> NominalFriction {
    let value =
        |parameter, otherwise| estimate.prediction(&ParameterId::friction(parameter, coordinate)).unwrap_or(otherwise);
    // If the friction differs by direction, the greater of the two values is used.
    let greater = |forward, backward, otherwise: f64| {
        value(forward, otherwise).abs().max(value(backward, otherwise).abs()).max(otherwise)
    };
    let viscous = value(FrictionParameter::Viscous, described.viscous);
    let coulomb = value(FrictionParameter::Coulomb, described.coulomb).abs();
    NominalFriction {
        viscous: greater(FrictionParameter::ViscousForward, FrictionParameter::ViscousBackward, viscous),
        coulomb: greater(FrictionParameter::CoulombForward, FrictionParameter::CoulombBackward, coulomb),
        offset: value(FrictionParameter::Offset, described.offset),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::describe::model::Model;
    use identification::estimate::identified::Identified;
    use linear_model::friction::terms::FrictionTerm;
    use linear_model::linear_model::Model as LinearModel;

    /// R'R must equal the inverse of the covariance; without a covariance, the inverse of the diagonal matrix of the variances.
    #[test]
    fn rows_are_the_information_of_the_estimate() {
        let model = Model::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/planar2r.yaml")).unwrap();
        let linear = LinearModel::new(model.regressor(), &[FrictionTerm::Viscous], &[]);
        let p = linear.p();
        let sigma = |c: usize| 0.1 * (c + 1) as f64;
        let parameters: Vec<Identified> = linear
            .parameters
            .iter()
            .enumerate()
            .map(|(c, own)| {
                let mut found = Identified::given(own.id.clone(), own.unit(), 1.0);
                found.sigma = Some(sigma(c));
                found
            })
            .collect();
        let correlation = |i: usize, j: usize| if i == j { 1.0 } else { 0.3_f64.powi(i.abs_diff(j) as i32) };
        let covariance: Vec<Vec<f64>> =
            (0..p).map(|i| (0..p).map(|j| correlation(i, j) * sigma(i) * sigma(j)).collect()).collect();
        for (covariance, has_note) in [(covariance.clone(), false), (vec![], true)] {
            let estimate =
                Estimate { parameters: parameters.clone(), covariance: covariance.clone(), ..Estimate::default() };
            let (rows, notes) = prior_rows(&estimate, &linear);
            assert_eq!(!notes.is_empty(), has_note);
            let r = DMatrix::from_row_slice(p, p, &rows);
            let independent = |i: usize, j: usize| if i == j { sigma(i) * sigma(j) } else { 0.0 };
            let known = |i, j| covariance.get(i).map_or(independent(i, j), |row: &Vec<f64>| row[j]);
            let product = r.transpose() * &r * DMatrix::from_fn(p, p, known);
            // Tolerance: rounding of two factorisations of a matrix with a condition number below ten.
            assert!((product - DMatrix::identity(p, p)).amax() < 1e-12);
        }
    }
}
