//! Computes the drive gains of `likelihood` by mixed least squares and total least squares.
//!
//! The equations are [D, t, -I_1, -I_2, .. | y] (X, 1, k, -1) = 0, where y = sum of k_j I_j over the joints whose gains are
//! known. D and the known torque t are exact, the currents are noisy. The noisy columns are projected onto the orthogonal
//! complement of the exact columns. The gains are the direction of the smallest singular value of this projection
//! [Van Huffel, Vandewalle 1991], after column c is scaled by G_c^-1/2. G_c is the sum of diag(1 - Q Q') over the rows of
//! column c, Q: basis of the exact columns. G_c is the variance of the noise in the projected column. Without this scaling the
//! solution is biased, because the parameters take unequal shares of the degrees of freedom of the joints. If a gain is known,
//! t is part of y. If no gain is known, t is an exact column, and the coefficient of t fixes the common scale of the gains.
//!
//! Maximum likelihood needs no scaling and gives standard deviations; this file is an independent check of it.

use nalgebra::{DMatrix, Dyn, SVD};

use crate::estimators::drive_gains::equations::JointEquations;
use crate::estimators::drive_gains::likelihood::{Gain, least_squares};

/// The scaling of the columns of currents in total least squares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scaling {
    /// Each column is divided by the standard deviation of the noise in its projection.
    Noise,
    /// No scaling. The result is biased if the noise is large.
    None,
}

/// Singular values of the exact columns count as zero if they are below this share of the largest singular value.
const RELATIVE_RANK_TOLERANCE: f64 = 1e-10;
/// Least noise variance of a projected column, divided by the noise variance of the column before projection.
const SMALLEST_NOISE_VARIANCE: f64 = 1e-12;
/// The gains are not determined if the entry that fixes the common scale of the gains is below this value.
const SMALLEST_SCALE_COEFFICIENT: f64 = 1e-12;

/// An orthonormal basis of the column space of the decomposed matrix. Singular values up to `tolerance` count as zero.
fn range(svd: &SVD<f64, Dyn, Dyn>, tolerance: f64) -> Option<DMatrix<f64>> {
    let u = svd.u.as_ref()?;
    let kept: Vec<usize> = (0..svd.singular_values.len()).filter(|&i| svd.singular_values[i] > tolerance).collect();
    Some(DMatrix::from_fn(u.nrows(), kept.len(), |r, c| u[(r, kept[c])]))
}

/// The direction d with the smallest |rest d| under the condition |d / scale| = 1. `rest`: projected noisy columns; `scale`: one
/// factor per column.
fn least_direction(rest: &DMatrix<f64>, scale: &[f64]) -> Option<Vec<f64>> {
    let scaled = DMatrix::from_fn(rest.nrows(), rest.ncols(), |r, c| rest[(r, c)] * scale[c]);
    let values = scaled.svd(false, true);
    let v = values.v_t.as_ref()?.row(values.singular_values.imin()).transpose();
    Some(v.iter().zip(scale).map(|(v, s)| v * s).collect())
}

/// The scale G_c^-1/2 of each noisy column c, with G_c = sum over the rows r of column c of 1 - |Q_r|^2. Q (`basis`): orthonormal
/// basis of the exact columns. `column(r)`: the column of row r.
fn noise_scale(basis: &DMatrix<f64>, column: impl Fn(usize) -> usize, columns: usize) -> Vec<f64> {
    let left = |r: usize| 1.0 - basis.row(r).norm_squared();
    let of_column = |c: usize| (0..basis.nrows()).filter(|&r| column(r) == c).map(left).sum::<f64>();
    (0..columns).map(|c| 1.0 / of_column(c).max(SMALLEST_NOISE_VARIANCE).sqrt()).collect()
}

/// Estimates gains, N m/A, and parameters by total least squares. An expected gain is treated as free.
///
/// `None` if there are too few equations, or if the equations do not determine the common scale of gains and parameters.
pub fn gains_by_total_least_squares(
    joints: &[JointEquations],
    known: &[Gain],
    scaling: Scaling,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let (_, start) = least_squares(joints, known);
    let of_joint = |j: usize| (0..joints[j].rows.len()).map(move |r| (j, r));
    let place: Vec<(usize, usize)> = (0..joints.len()).flat_map(of_joint).collect();
    let p = joints.iter().find_map(|e| e.rows.first())?.len();
    let is_known = |j: usize| matches!(known[j], Gain::Known(_));
    // Each unknown gain has a column. All known gains share the last column.
    let unknown: Vec<usize> = (0..joints.len()).filter(|&j| !is_known(j)).collect();
    let (count, has_known) = (place.len(), unknown.len() < joints.len());
    let currents = unknown.len() + usize::from(has_known);
    if count <= p + currents {
        return None;
    }
    // Rows are divided by the initial gain of their joint, so that the noise of every current is 1.
    let weight = |j: usize| 1.0 / start[j].abs();
    let torque = |(j, r): (usize, usize)| joints[j].known[r] * weight(j);
    let exact = DMatrix::from_fn(count, p + usize::from(!has_known), |r, c| {
        let (j, at) = place[r];
        if c < p { joints[j].rows[at][c] * weight(j) } else { torque(place[r]) }
    });
    let noisy = DMatrix::from_fn(count, currents, |r, c| {
        let (j, at) = place[r];
        let current = joints[j].current[at];
        match unknown.get(c) {
            Some(&u) if u == j => -current,
            Some(_) => 0.0,
            None if is_known(j) => start[j] * weight(j) * current - torque(place[r]),
            None => -torque(place[r]),
        }
    });
    // The noisy columns are projected onto the complement of the exact columns.
    let svd = exact.svd(true, true);
    let tolerance = RELATIVE_RANK_TOLERANCE * svd.singular_values.max();
    let basis = range(&svd, tolerance)?;
    let rest = &noisy - &basis * (basis.transpose() * &noisy);
    let column = |r: usize| unknown.iter().position(|&u| u == place[r].0).unwrap_or(unknown.len());
    let scale: Vec<f64> = match scaling {
        Scaling::None => vec![1.0; currents],
        Scaling::Noise => noise_scale(&basis, column, currents),
    };
    let direction = least_direction(&rest, &scale)?;
    // `direction` gives a combination of the noisy columns. X is the least-squares solution for which the exact columns times X
    // give the negative of this combination.
    let right = DMatrix::from_fn(count, 1, |r, _| -(0..currents).map(|c| noisy[(r, c)] * direction[c]).sum::<f64>());
    let x = svd.solve(&right, tolerance).ok()?;
    let unit = if has_known { -direction[currents - 1] } else { x[p] };
    if unit.abs() < SMALLEST_SCALE_COEFFICIENT {
        return None;
    }
    let mut gains: Vec<f64> = known.iter().map(|k| if let Gain::Known(k) = k { *k } else { 1.0 }).collect();
    // The rows are divided by start_j (initial gain), but the currents are not. So `direction` gives the gain divided by start_j.
    unknown.iter().enumerate().for_each(|(c, &j)| gains[j] = direction[c] / unit / weight(j));
    Some((gains, x.iter().take(p).map(|x| x / unit).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimators::drive_gains::likelihood::drive_gains;
    use crate::estimators::drive_gains::likelihood::tests::{GAINS, THIRD, TRUTH, joints};
    use random::Random;

    #[test]
    fn without_noise_the_gains_come_back() {
        for (is_loaded, known) in [(false, THIRD), (true, [Gain::Free; 3])] {
            let joints = joints(&mut Random::new(2), 1e-6, is_loaded);
            let (gains, x) = gains_by_total_least_squares(&joints, &known, Scaling::Noise).unwrap();
            // The allowed error follows from the noise of 1e-6; the torques are some hundred.
            assert!(gains.iter().zip(GAINS).all(|(k, truth)| (k - truth).abs() < 1e-7), "{gains:?}");
            assert!(x.iter().zip(TRUTH).all(|(x, truth)| (x - truth).abs() < 1e-7), "{x:?}");
        }
    }

    #[test]
    fn the_columns_are_scaled_to_their_noise() {
        for (is_loaded, known) in [(false, THIRD), (true, [Gain::Free; 3])] {
            let mut random = Random::new(3);
            let draws = 400;
            let (mut scaled, mut unscaled, mut sigma) = (0.0, 0.0, 0.0);
            for _ in 0..draws {
                let joints = joints(&mut random, 20.0, is_loaded);
                let deviation = drive_gains(&joints, &known).unwrap().gain_deviation[0];
                let error = |scaling| {
                    let (gains, _) = gains_by_total_least_squares(&joints, &known, scaling).unwrap();
                    (gains[0] - GAINS[0]) / deviation / f64::from(draws)
                };
                scaled += error(Scaling::Noise);
                unscaled += error(Scaling::None);
                sigma = deviation / GAINS[0];
            }
            // Allowed bias: five standard errors of the mean of 400 standard normal numbers, plus the bias of second order of
            // the estimate, about sigma.
            assert!(scaled.abs() < 0.25 + sigma, "{is_loaded}: {scaled}");
            assert!(unscaled.abs() > 0.25 + sigma, "{is_loaded}: {unscaled}");
        }
    }
}
