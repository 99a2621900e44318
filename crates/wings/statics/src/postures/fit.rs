//! Weighted least squares for postures of a robot at rest: each joint has one row per posture, and the weight of the joint
//! follows from the residual of its torques. The result has the values of the unknowns with their standard deviations.

use nalgebra::{DMatrix, DVector};
use numerics::least_squares::solve_within;
use numerics::triangle::TriangleBuilder;

use rist::Error;

/// A value with its standard deviation. `None` if the postures do not determine the value.
pub type ValueWithSigma = Option<(f64, f64)>;
/// Number of weighted fits. The weights of each fit are computed from the residuals of the previous fit.
const REWEIGHTING_ROUNDS: usize = 5;
/// Smallest standard deviation of a joint's torque, as a fraction of the rms of this torque.
const LEAST_DEVIATION_SHARE: f64 = 1e-9;

/// Result of the fit over all joints.
pub(super) struct PostureFit {
    pub identified: Vec<ValueWithSigma>,
    pub solution: DVector<f64>,
    pub residuals: Vec<DVector<f64>>,
    /// Standard deviation of the torque residual of each joint, N m (N).
    pub deviations: Vec<f64>,
}

impl PostureFit {
    /// Fits `torques` to the columns of each joint. A direction is not identifiable if its singular value is below
    /// `not_identifiable` times the largest one.
    pub(super) fn of(
        joints: &[DMatrix<f64>],
        torques: &[DVector<f64>],
        not_identifiable: f64,
    ) -> Result<PostureFit, Error> {
        let (n, unknowns) = (joints.len(), joints.first().map_or(0, DMatrix::ncols));
        let count = torques.first().map_or(0, DVector::len) as f64;
        let free = (count - unknowns as f64 / n.max(1) as f64).max(1.0);
        let mut deviations = vec![1.0; n];
        let mut fit = PostureFit::weighted(joints, torques, &deviations, not_identifiable)?;
        // The weights converge within a few rounds.
        for _ in 0..REWEIGHTING_ROUNDS {
            for ((deviation, residual), torque) in deviations.iter_mut().zip(&fit.residuals).zip(torques) {
                let least = LEAST_DEVIATION_SHARE * (torque.norm() / count.sqrt()).max(f64::MIN_POSITIVE);
                *deviation = (residual.norm_squared() / free).sqrt().max(least);
            }
            fit = PostureFit::weighted(joints, torques, &deviations, not_identifiable)?;
        }
        Ok(fit)
    }

    pub(super) fn weighted(
        joints: &[DMatrix<f64>],
        torques: &[DVector<f64>],
        deviations: &[f64],
        not_identifiable: f64,
    ) -> Result<PostureFit, Error> {
        let unknowns = joints.first().map_or(0, DMatrix::ncols);
        // Least squares weighted by 1/s_j: minimise the sum over the joints j of |torque_j - columns_j x|^2 / s_j^2, where s_j
        // is the standard deviation of joint j. Only the triangle R of the QR decomposition of all rows is kept.
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
            return Err(Error::new("the numbers of the postures exceed the range of floating-point numbers"));
        }
        let found = solve_within(&rows.finish(), not_identifiable);
        // The rows have unit variance after the division by s_j, so the covariance of x is the inverse of R'R.
        let value = |c: usize| found.determined[c].then(|| (found.x[c], found.inverse[(c, c)].sqrt()));
        let solution = DVector::from_column_slice(&found.x);
        let residuals = joints.iter().zip(torques).map(|(columns, torque)| torque - columns * &solution).collect();
        Ok(PostureFit {
            identified: (0..unknowns).map(value).collect(),
            solution,
            residuals,
            deviations: deviations.to_vec(),
        })
    }
}
