//! A level: the fit of some groups of parameters (frames, zeros, geometry, compliances), with its error on postures that were
//! left out.
//!
//! Base parameters are the errors that measurements at any posture can determine. The postures are divided into folds, and each
//! fold is left out of the fit once and predicted.

use rist::Error;

use crate::base_geometry::GeometricBase;
use crate::fit::{Fit, Noise};
use crate::folds::{Candidate, ErrorSums, PredictionError, error_of, error_on};
use crate::measurement::{Problem, Unknowns};

/// A fit without a prior needs at least this number of rows per parameter.
const ROWS_PER_PARAMETER: f64 = 1.25;
/// A zero error above this value counts as far off (probably a mistake in the table), rad (m).
const FAR_ZERO: f64 = 1.0;

/// A fit of some groups of parameters, with its error on postures that were left out.
#[derive(Clone, Debug)]
pub struct Level {
    /// What is fitted: `frames`, `zeros`, `geometry`, `stiffness`.
    pub what: &'static str,
    /// The base parameters at any posture.
    pub base: GeometricBase,
    /// Base parameters that these postures do not determine.
    pub undetermined: Vec<usize>,
    /// The fit of all postures.
    pub fit: Fit,
    /// Standard deviation of the errors of the geometry in the prior, m and rad; `None`: no prior.
    pub deviation: Option<f64>,
    /// Error on the fitted postures.
    pub fitted: PredictionError,
    /// Error on postures that are left out in turn. It includes postures that the fit of all postures leaves out as wrong.
    pub left_out: PredictionError,
    /// The errors of each posture when it was left out.
    pub(crate) each: Vec<ErrorSums>,
}

/// The fit of the parameters `active` with the base parameters `base`. The errors of the geometry of the level `geometry` may have
/// a prior.
fn candidate<'a>(
    problem: &'a Problem,
    what: &str,
    base: &'a GeometricBase,
    active: &'a [usize],
    rows: usize,
) -> Candidate<'a> {
    let may_be_free = rows as f64 > ROWS_PER_PARAMETER * active.len() as f64;
    Candidate { problem, base, active, may_hold: what == "geometry", may_be_free }
}

impl Level {
    /// Fits a level, with the prior that predicts best, and predicts it fold by fold. `from`: start and noise.
    ///
    /// Fails if the derivatives are not finite.
    pub(crate) fn fitted(
        problem: &Problem,
        what: &'static str,
        base: GeometricBase,
        from: &(Unknowns, Noise),
    ) -> Result<Level, Error> {
        let rows = problem.linearised(&from.0);
        let of_data = GeometricBase::of(&rows.jacobian, &base.kept)?;
        let all: Vec<usize> = (0..problem.postures.len()).collect();
        let one = candidate(problem, what, &base, &of_data.kept, rows.residual.len());
        let (fit, deviation) = one.chosen(&from.0, from.1);
        let each = one.left_out(&from.0, from.1);
        let left_out = error_of(problem, &each, |_| true);
        let fitted = error_on(problem, &fit.unknowns, &all);
        let undetermined = base.kept.iter().copied().filter(|k| !of_data.kept.contains(k)).collect();
        Ok(Level { what, base, undetermined, fit, deviation, fitted, left_out, each })
    }

    /// The error on postures left out, computed only over the postures that are `used`.
    pub(crate) fn left_out_on(&self, problem: &Problem, used: &[bool]) -> PredictionError {
        error_of(problem, &self.each, |r| used[r])
    }

    /// The candidate with the settings of this level and with the parameters `active`.
    pub(crate) fn candidate<'a>(&'a self, problem: &'a Problem, active: &'a [usize]) -> Candidate<'a> {
        let all: Vec<usize> = (0..problem.postures.len()).collect();
        let rows = problem.residuals_of(&self.fit.unknowns, &all).len();
        candidate(problem, self.what, &self.base, active, rows)
    }
}

/// The coordinates of the chain whose zeros are far off: indices of [`Chain::coordinates`].
pub(crate) fn far_zeros(problem: &Problem, at: &Unknowns) -> Vec<usize> {
    let count = problem.chain.coordinates.len();
    (0..count).filter(|&k| at.chain[k].abs() > FAR_ZERO).collect()
}
