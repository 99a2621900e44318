//! Computes the equations of the paper cited below: spectral equations of swings (periodic motions), and centred equations of
//! gravity sweeps (slow motions).
//!
//! Sp(m, v, f) = Re(m(f) conj v(f)) / |v(f)|^2: the spectrum m(f) of a signal, projected on the spectrum v(f) of another. k: fast
//! joint; f_P: frequency of its swing; D_j, tau_j: rows of the regressor and torques of joint j; X: parameters.
//!
//! (8), (11)  Sp(D_j, ddq_k, f_P) X = Sp(tau_j, ddq_k, f_P)       (j = k or a slow joint)
//! (10)       Sp(D_j, dq_k^2, 2 f_P) X = Sp(tau_j, dq_k^2, 2 f_P)
//! (13)       (D - mean D) X = tau - mean tau, each direction on its own, columns at dq = ddq = 0
//!
//! The torque noise is white with standard deviation sigma per sample; the variance of Sp(tau) of N samples is sigma^2 N / (2
//! |v(f)|^2). The gravity equations are reduced to R X = Q' y by a column-pivoted QR decomposition, cut at its rank. R X = Q' y
//! has the information of (13) without the squared condition number of the normal equations (14).
//!
//! [Vandanjon, Gautier, Desbats 1995, sections 3.1 and 3.2]. Locked joints give no equation.

use linear_model::regressor::Regressor;
use nalgebra::{DMatrix, DVector};
use numerics::fourier::{Bins, sp};
use numerics::information_matrix::WeightedRows;

use crate::plan::exciting_trajectory::{ExcitingTrajectory, JointMotion, Projector};
use crate::plan::measured_motion::{INSTANTS_PER_PASS, MeasuredMotion};

/// A row of the R of a QR decomposition is dropped if its pivot is below this share of the first pivot (of 1, if that is
/// greater).
const RANK_TOLERANCE: f64 = 1e-9;
/// A block of equations: regressor rows times the parameters X = right-hand sides. Each right-hand side has a standard deviation.
#[derive(Clone, Debug)]
pub struct EquationBlock {
    /// Rows of the regressor, N m per unit of the parameter.
    pub rows: WeightedRows,
    /// Torques of a known load, N m, one per row: regressor row times X, plus this torque, equals the right-hand side. Zero
    /// without a load.
    pub known: Vec<f64>,
    /// Right-hand sides, N m, one per row.
    pub right: Vec<f64>,
    /// Standard deviation of each right-hand side, N m.
    pub deviation: Vec<f64>,
    /// Index of the coordinate of each row.
    pub joint: Vec<usize>,
}

/// The spectral equations (8), (10) and (11) of a swing (periodic motion), see the head of this file, from the whole periods of
/// `motion`.
///
/// `torque[j]`: torque of coordinate j, N m; `noise[j]`: its standard deviation per sample, N m. An equation is left out if the
/// signal on which it projects is zero. Empty for a slow sweep.
pub fn spectral_rows(
    trajectory: &ExcitingTrajectory,
    regressor: &dyn Regressor,
    motion: &MeasuredMotion,
    torque: &[Vec<f64>],
    noise: &[f64],
) -> EquationBlock {
    let mut block = EquationBlock::new(regressor.parameters().len());
    let JointMotion::Swing { period, .. } = &trajectory.motion else { return block };
    // Only whole periods are used, so that the frequency f_P of the swing is a bin of the Fourier transform.
    let count = motion.len();
    let periods = count / period;
    if periods == 0 {
        return block;
    }
    let columns = motion.regressor_columns(regressor);
    let bins = Bins::new(count);
    // One equation per projector signal v and moving joint j: Sp(D_j, v, f) X = Sp(tau_j, v, f).
    for equation in trajectory.equations() {
        let (k, j) = (trajectory.fast, equation.joint);
        let bin = equation.projector.harmonic() * periods;
        let v = match equation.projector {
            Projector::Acceleration => bins.of(&motion.ddq[k], bin),
            Projector::SquaredVelocity => bins.of(&motion.dq[k].iter().map(|v| v * v).collect::<Vec<_>>(), bin),
        };
        if v.norm() == 0.0 {
            continue;
        }
        let row: Vec<f64> = columns[j].iter().map(|d| sp(bins.of(d, bin), v)).collect();
        // The variance of Sp(tau) is sigma^2 N / (2 |v(f)|^2); sigma: noise per sample, N: number of samples.
        let deviation = noise[j] * (count as f64 / 2.0).sqrt() / v.norm();
        block.push(&row, sp(bins.of(&torque[j], bin), v), deviation, j);
    }
    block
}

/// The centred equations (13) of a slow gravity sweep, see the head of this file, reduced to the R of a QR decomposition.
/// `directions`: number of samples in each direction; `q`, `torque`: series of each coordinate; `noise`: standard deviation of a
/// torque sample, N m.
pub fn gravity_rows(
    trajectory: &ExcitingTrajectory,
    regressor: &dyn Regressor,
    q: &[Vec<f64>],
    torque: &[Vec<f64>],
    noise: &[f64],
    directions: &[usize],
) -> EquationBlock {
    let (n, p, k) = (q.len(), regressor.parameters().len(), trajectory.fast);
    let count = directions.iter().sum::<usize>().min(q.first().map_or(0, Vec::len));
    let mut block = EquationBlock::new(p);
    if count == 0 {
        return block;
    }
    // One row per instant: regressor row of the moving joint at rest, then its torque.
    let mut w = DMatrix::<f64>::zeros(count, p + 1);
    let mut y = vec![0.0; INSTANTS_PER_PASS * n * p];
    let mut states = vec![0.0; INSTANTS_PER_PASS * 3 * n];
    for first in (0..count).step_by(INSTANTS_PER_PASS) {
        let instants = first..count.min(first + INSTANTS_PER_PASS);
        for (state, i) in states.chunks_exact_mut((3 * n).max(1)).zip(instants.clone()) {
            (0..n).for_each(|j| state[j] = q[j][i]);
        }
        let y = &mut y[..instants.len() * n * p];
        regressor.fill_many(&states[..instants.len() * 3 * n], y);
        for (y, i) in y.chunks_exact((n * p).max(1)).zip(instants) {
            (0..p).for_each(|c| w[(i, c)] = y[k * p + c]);
            w[(i, p)] = torque[k][i];
        }
    }
    // The rows of each direction are centred separately. This cancels friction that depends only on the direction.
    let mut first = 0;
    for &length in directions {
        let length = length.min(count - first);
        for c in 0..=p {
            let mean = w.column(c).rows(first, length).sum() / length.max(1) as f64;
            w.column_mut(c).rows_mut(first, length).add_scalar_mut(-mean);
        }
        first += length;
    }
    let (reduced, right) = reduce(w, p);
    for (row, right) in reduced.iter().zip(right) {
        block.push(row, right, noise[k], k);
    }
    block
}

/// Reduces the equations A X = y, stored as w = [A y], to the R of the column-pivoted QR decomposition of A, cut at the rank of
/// A. Returns the rows and their right-hand sides.
fn reduce(w: DMatrix<f64>, p: usize) -> (Vec<Vec<f64>>, Vec<f64>) {
    // Added rows of zeros do not change the triangle. They make it square if there are few instants.
    let few = (p + 1).saturating_sub(w.nrows());
    let instants = w.nrows();
    let triangle = w.insert_rows(instants, few, 0.0).qr().unpack_r();
    let a = triangle.columns(0, p).into_owned();
    let y: DVector<f64> = triangle.column(p).into_owned();
    let pivoted = a.col_piv_qr();
    let mut rotated = y;
    pivoted.q_tr_mul(&mut rotated);
    let mut r = pivoted.r();
    let first = r.diagonal().amax();
    let rank = r.diagonal().iter().take_while(|d| d.abs() > RANK_TOLERANCE * first.max(1.0)).count();
    pivoted.p().inv_permute_columns(&mut r);
    let rows = (0..rank).map(|i| r.row(i).iter().copied().collect()).collect();
    (rows, rotated.iter().take(rank).copied().collect())
}

impl EquationBlock {
    /// An empty block of equations for `p` parameters.
    pub fn new(p: usize) -> EquationBlock {
        EquationBlock { rows: WeightedRows::new(p), known: vec![], right: vec![], deviation: vec![], joint: vec![] }
    }

    /// Adds an equation: regressor row; right-hand side, N m; standard deviation of the right-hand side, N m; index of the
    /// coordinate. The known torque is zero.
    pub fn push(&mut self, row: &[f64], right: f64, deviation: f64, joint: usize) {
        self.rows.push(row);
        self.known.push(0.0);
        self.right.push(right);
        self.deviation.push(deviation);
        self.joint.push(joint);
    }

    /// Sets the torques of a known load. `parameters`: the values that the load adds to the parameters X.
    pub fn with_known(mut self, parameters: &[f64]) -> EquationBlock {
        let torque = |d: &[f64]| d.iter().zip(parameters).map(|(d, x)| d * x).sum();
        self.known = self.rows.iter().map(torque).collect();
        self
    }

    /// The regressor rows W divided by the standard deviations of their right-hand sides. W'W is then the information matrix.
    pub fn weighted(&self) -> WeightedRows {
        let mut rows = WeightedRows::new(self.rows.width());
        for (row, s) in self.rows.iter().zip(&self.deviation) {
            rows.push(&row.iter().map(|x| x / s).collect::<Vec<_>>());
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pendulum::Pendulum;

    #[test]
    fn few_instants_are_few_rows() {
        let arm = Pendulum::new();
        for sample_time in [1.2, 0.8, 0.5, 0.1] {
            let sweep = ExcitingTrajectory::sweep(0, &[0.3], 2.0, 1.0, sample_time);
            let reference = sweep.reference();
            let motion = MeasuredMotion::of_reference(&reference);
            let directions: Vec<usize> = reference.windows.iter().map(|w| w.len()).collect();
            let torque = vec![vec![0.0; motion.len()]];
            let block = gravity_rows(&sweep, &arm, &motion.q, &torque, &[0.1], &directions);
            assert!(block.right.len() <= motion.len().min(2), "{sample_time}: {}", block.right.len());
        }
    }

    #[test]
    fn gravity_rows_keep_the_information_of_the_centred_equations() {
        let arm = Pendulum::new();
        let sweep = ExcitingTrajectory::sweep(0, &[0.3], 2.0, 1.0, 1e-3);
        let reference = sweep.reference();
        let motion = MeasuredMotion::of_reference(&reference);
        let columns = &motion.regressor_columns(&arm)[0];
        let torque = |i: usize| columns.iter().zip(arm.truth).map(|(d, x)| d[i] * x).sum::<f64>();
        let mut tau: Vec<f64> = (0..motion.len()).map(torque).collect();
        let directions: Vec<usize> = reference.windows.iter().map(|w| w.len()).collect();
        // Friction that depends only on the direction must not affect the rows.
        for (i, tau) in tau.iter_mut().enumerate() {
            *tau += if i < directions[0] { 0.6 } else { -0.75 };
        }
        let block = gravity_rows(&sweep, &arm, &motion.q, &[tau], &[0.1], &directions);
        // The gravity torque of the joint depends on two first moments, along and across the link, so there are two rows.
        assert_eq!(block.right.len(), 2);
        for (row, y) in block.rows.iter().zip(&block.right) {
            let x: f64 = row.iter().zip(arm.truth).map(|(a, b)| a * b).sum();
            // Tolerance: rounding of sums of thousands of torques of about 10 N m.
            assert!((x - y).abs() < 1e-10, "{x} {y}");
        }
    }
}
