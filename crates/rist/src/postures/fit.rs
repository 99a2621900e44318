//! Least squares whose joints are each weighted by what is left of their torques.

use nalgebra::{DMatrix, DVector};

use crate::error::Error;

/// A parameter with a larger part in such a direction is not told.
const UNTOLD_PART: f64 = 1e-6;

/// A value with its deviation; `None` where the postures do not tell it.
pub type Told = Option<(f64, f64)>;

/// Least squares over joints that are each weighted by their own residual.
pub(super) struct Fit {
    pub told: Vec<Told>,
    pub solution: DVector<f64>,
    pub residuals: Vec<DVector<f64>>,
    /// Of each joint's torques.
    pub deviations: Vec<f64>,
}

impl Fit {
    pub(super) fn of(joints: &[DMatrix<f64>], torques: &[DVector<f64>], untold: f64) -> Result<Fit, Error> {
        let (n, unknowns) = (joints.len(), joints.first().map_or(0, DMatrix::ncols));
        let count = torques.first().map_or(0, DVector::len) as f64;
        let free = (count - unknowns as f64 / n.max(1) as f64).max(1.0);
        let mut deviations = vec![1.0; n];
        let mut fit = Fit::weighted(joints, torques, &deviations, untold)?;
        // The weights settle in a few rounds.
        for _ in 0..5 {
            for ((deviation, residual), torque) in deviations.iter_mut().zip(&fit.residuals).zip(torques) {
                let least = 1e-9 * (torque.norm() / count.sqrt()).max(f64::MIN_POSITIVE);
                *deviation = (residual.norm_squared() / free).sqrt().max(least);
            }
            fit = Fit::weighted(joints, torques, &deviations, untold)?;
        }
        Ok(fit)
    }

    pub(super) fn weighted(
        joints: &[DMatrix<f64>],
        torques: &[DVector<f64>],
        deviations: &[f64],
        untold: f64,
    ) -> Result<Fit, Error> {
        let unknowns = joints.first().map_or(0, DMatrix::ncols);
        let (mut normal, mut right) = (DMatrix::zeros(unknowns, unknowns), DVector::zeros(unknowns));
        for ((columns, torque), deviation) in joints.iter().zip(torques).zip(deviations) {
            let weight = deviation.powi(-2);
            normal += columns.tr_mul(columns) * weight;
            right += columns.tr_mul(torque) * weight;
        }
        let scale = normal.diagonal().map(|x: f64| if x > 0.0 { x.sqrt().recip() } else { 0.0 });
        let scaled = DMatrix::from_fn(unknowns, unknowns, |r, c| scale[r] * normal[(r, c)] * scale[c]);
        if !scaled.iter().all(|x| x.is_finite()) {
            return Err(Error::new("the numbers of the postures leave the range of numbers"));
        }
        let eigen = scaled.symmetric_eigen();
        let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
        let is_told = |k: usize| eigen.eigenvalues[k] > untold * largest;
        let (mut solution, mut variance, mut open) =
            (DVector::zeros(unknowns), vec![0.0; unknowns], vec![0.0; unknowns]);
        let right = right.component_mul(&scale);
        for k in 0..unknowns {
            let direction = eigen.eigenvectors.column(k);
            if is_told(k) {
                solution += direction * (direction.dot(&right) / eigen.eigenvalues[k]);
                variance.iter_mut().zip(direction.iter()).for_each(|(v, d)| *v += d * d / eigen.eigenvalues[k]);
            } else {
                open.iter_mut().zip(direction.iter()).for_each(|(o, d)| *o += d * d);
            }
        }
        let solution = solution.component_mul(&scale);
        let told = (0..unknowns)
            .map(|c| (open[c] < UNTOLD_PART && scale[c] > 0.0).then(|| (solution[c], scale[c] * variance[c].sqrt())))
            .collect();
        let residuals = joints.iter().zip(torques).map(|(columns, torque)| torque - columns * &solution).collect();
        Ok(Fit { told, solution, residuals, deviations: deviations.to_vec() })
    }
}
