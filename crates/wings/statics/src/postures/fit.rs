//! Least squares whose joints are each weighted by what is left of their torques.

use nalgebra::{DMatrix, DVector};
use numerics::least_squares::solve_within;
use numerics::triangle::TriangleBuilder;

use rist::Error;

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
    /// `untold`: the ratio of singular values from which a direction is not told.
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
        let mut rows = TriangleBuilder::new(unknowns);
        let (mut row, mut is_finite) = (vec![0.0; unknowns], true);
        for ((columns, torque), deviation) in joints.iter().zip(torques).zip(deviations) {
            for (r, torque) in torque.iter().enumerate() {
                row.iter_mut().zip(columns.row(r).iter()).for_each(|(x, column)| *x = column / deviation);
                let right = torque / deviation;
                is_finite &= right.is_finite() && row.iter().all(|x| x.is_finite());
                rows.push(&row, right);
            }
        }
        if !is_finite {
            return Err(Error::new("the numbers of the postures leave the range of numbers"));
        }
        let found = solve_within(&rows.finish(), untold);
        let told = |c: usize| found.determined[c].then(|| (found.x[c], found.inverse[(c, c)].sqrt()));
        let solution = DVector::from_column_slice(&found.x);
        let residuals = joints.iter().zip(torques).map(|(columns, torque)| torque - columns * &solution).collect();
        Ok(Fit { told: (0..unknowns).map(told).collect(), solution, residuals, deviations: deviations.to_vec() })
    }
}
