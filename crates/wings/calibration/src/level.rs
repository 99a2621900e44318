//! A fit of some groups of parameters, and what it says of zeros and gears.

use crate::base_geometry::GeometricBase;
use crate::fit::{Fit, Fitter};
use crate::folds::PredictionError;
use crate::measurement::{Problem, Unknowns};
use crate::parameter::Parameter;

/// A zero above this is far off, rad (m).
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
    /// Error on postures left out in turn.
    pub left_out: PredictionError,
}

/// The coordinates of the chain whose zeros are far off: indices of [`Chain::coordinates`].
pub(crate) fn far_zeros(problem: &Problem, at: &Unknowns) -> Vec<usize> {
    let count = problem.chain.coordinates.len();
    (0..count).filter(|&k| at.chain[k].abs() > FAR_ZERO).collect()
}

/// A gear scale that was tested: the coordinate, its estimate with its standard deviation, and how sure a fault would show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TestedGear {
    pub coordinate: usize,
    /// Estimate and standard deviation; `None` if the postures do not determine it.
    pub estimate: Option<(f64, f64)>,
}

/// Tests each gear scale alone: the derivative by the scale, without what the fitted parameters explain of it.
pub(crate) fn tested_gears(problem: &Problem, level: &Level) -> Vec<TestedGear> {
    let fit = &level.fit;
    let all: Vec<usize> = (0..problem.postures.len()).collect();
    let fitter = Fitter { problem, active: &fit.active, prior: None, rows: &all };
    let of = |(k, parameter): (usize, &Parameter)| match parameter {
        Parameter::Gear { coordinate } => {
            Some(TestedGear { coordinate: *coordinate, estimate: fitter.one_more(fit, k) })
        }
        _ => None,
    };
    problem.parameters.iter().enumerate().filter_map(of).collect()
}
