//! The estimator of [Vandanjon, Gautier, Desbats 1995] ("the paper"): least squares on rows of the operator Sp(m, v) = Re(m
//! conj v) / |v|^2. m: spectrum of a signal; v: spectrum of a motion.
//!
//! W X = Y has one row per harmonic (its real or its imaginary part), and the gravity rows, from which the mean is subtracted.
//! Without weights, a row of Sp is used unchanged, and the gravity rows of e samples are divided by sqrt(e), so that their
//! weight does not depend on e. With weights, each row is divided by the standard deviation of its right-hand side.
//!
//! C = sigma^2 (W'W)^-1 is the covariance of X, sigma^2 = |rho|^2/(r - p) [Vandanjon, Gautier, Desbats 1995, section 3.3]; rho:
//! residual, W: r x p.
//!
//! Friction has no columns here. The experiments are planned so that the rows are orthogonal to friction. The rows are
//! orthogonal only as far as the motion follows its reference. `rist_mh` does not need this orthogonality.

use experiments::plan::measured_motion::MeasuredMotion;
use experiments::plan::paper_rows::{EquationBlock, gravity_rows, spectral_rows};
use linear_model::regressor::Regressor;
use numerics::least_squares::{Solution, solve};
use numerics::triangle::TriangleBuilder;

use crate::spectrum::experiment::SpectralExperiment;

/// How the rows of the method [Vandanjon, Gautier, Desbats 1995] are weighted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PaperWeights {
    /// All spectral rows have equal weight.
    Equal,
    /// Each row is divided by the standard deviation of its right-hand side.
    Noise,
}

/// Makes the rows for one experiment (see the module). `gain`: N m per unit of the recorded currents; `noise`: standard
/// deviation of the torque of each joint, N m.
pub fn paper_rows(
    experiment: &SpectralExperiment,
    regressor: &dyn Regressor,
    gain: &[f64],
    noise: &[f64],
) -> EquationBlock {
    let torque = experiment.torque(gain);
    let trajectory = &experiment.trajectory;
    let block = if experiment.period().is_none() {
        gravity_rows(trajectory, regressor, &experiment.q, &torque, noise, &experiment.windows)
    } else {
        let motion = MeasuredMotion::by_differences(&experiment.q, trajectory.sample_time);
        spectral_rows(trajectory, regressor, &motion, &torque, noise)
    };
    block.with_known(&experiment.load)
}

/// Least squares on the rows of several experiments. `periodic[i]`: whether experiment i is periodic (no sweep); `samples[i]`:
/// number of samples of experiment i.
pub fn paper_estimate(
    blocks: &[EquationBlock],
    periodic: &[bool],
    samples: &[usize],
    weights: PaperWeights,
) -> Solution {
    let p = blocks.first().map_or(0, |b| b.rows.width());
    let mut rows = TriangleBuilder::new(p);
    for (e, block) in blocks.iter().enumerate() {
        let mean = if periodic[e] { 1.0 } else { 1.0 / (samples[e].max(1) as f64).sqrt() };
        for (i, row) in block.rows.iter().enumerate() {
            let factor = match weights {
                PaperWeights::Equal => mean,
                PaperWeights::Noise => 1.0 / block.deviation[i],
            };
            rows.push(&row.iter().map(|x| factor * x).collect::<Vec<_>>(), factor * (block.right[i] - block.known[i]));
        }
    }
    solve(&rows.finish())
}
