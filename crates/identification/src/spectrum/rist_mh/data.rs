//! The data of RIST-MH: the spectra of all experiments and joints, and the options of the search.

use experiments::plan::measured_motion::MeasuredMotion;
use experiments::plan::paper_rows::EquationBlock;
use linear_model::regressor::Regressor;

use crate::spectrum::experiment::NoiseLevels;
use crate::spectrum::harmonics::{Band, JointSpectrum};
use crate::spectrum::rist_mh::effects::Effect;

/// The options of RIST-MH: unknowns other than parameters, and the choices of the search.
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicOptions {
    /// The frequency band.
    pub band: Band,
    /// Candidate widths of the velocity interval in which the sign of friction changes, rad/s; BIC selects one.
    pub rest_velocities: Vec<f64>,
    /// Candidate Stribeck velocities, rad/s.
    pub stribeck_velocities: Vec<f64>,
    /// Whether to try Coulomb friction that grows with the load.
    pub load: bool,
    /// Whether friction may drift from experiment to experiment.
    pub drift: bool,
    /// Whether the weights contain the noise of the position and the residual of each joint.
    pub weights: bool,
    /// Whether the motion may end in another position or velocity than it starts with.
    pub ends: bool,
    /// Effects other than friction that are estimated too.
    pub effects: Vec<Effect>,
}

impl Default for HarmonicOptions {
    fn default() -> HarmonicOptions {
        HarmonicOptions {
            band: Band::default(),
            rest_velocities: vec![0.005, 0.02, 0.05, 0.1],
            stribeck_velocities: vec![0.05, 0.1, 0.2],
            load: true,
            drift: true,
            weights: true,
            ends: true,
            effects: vec![],
        }
    }
}

/// Highest frequency of the equations where links are behind springs or gaps, Hz.
///
/// Above it the motion of a link depends more on the deflection than on the motor. R3G with joints of 12 Hz has an error of
/// 0.08 % with a chi^2 of 5; with equations up to 20 Hz, 0.19 % with 28. Joints of 15 and 25 Hz have errors of 0.14 and
/// 0.10 %; with equations up to 20 Hz, 0.13 and 0.08 % (`tests/benches/misfit.rs`, six draws).
const MAX_YIELDING_FREQUENCY_HZ: f64 = 10.0;

impl HarmonicOptions {
    /// The options with additional effects; with springs and gaps the equations have a lower highest frequency.
    pub fn with_effects(mut self, effects: Vec<Effect>) -> HarmonicOptions {
        if effects.iter().any(|e| matches!(e, Effect::Elastic { .. } | Effect::Play { .. })) {
            self.band.equations = self.band.equations.min(MAX_YIELDING_FREQUENCY_HZ);
        }
        self.effects.extend(effects);
        self
    }

    /// The options with friction of equation (5) only, without drift, and weights by the torque noise.
    pub fn plain() -> HarmonicOptions {
        HarmonicOptions {
            rest_velocities: vec![0.005],
            stribeck_velocities: vec![],
            load: false,
            drift: false,
            weights: false,
            ends: false,
            ..HarmonicOptions::default()
        }
    }
}

/// The spectra of the experiments, computed once.
#[derive(Clone)]
pub struct HarmonicData<'a> {
    pub(crate) regressor: &'a dyn Regressor,
    /// The measured motion of each experiment; `None` for a sweep.
    pub(crate) motions: Vec<Option<MeasuredMotion>>,
    pub(crate) p: usize,
    pub(crate) n: usize,
    pub(crate) spectra: Vec<JointSpectrum>,
    /// The gravity rows of each sweep, in the unit of the currents.
    pub(crate) sweeps: Vec<EquationBlock>,
    /// By sweep, the column of a spring of 1 N m/rad in these rows.
    pub(crate) swept_springs: Vec<Vec<f64>>,
    pub(crate) noise: NoiseLevels,
    /// The noise of the harmonics of the equations.
    pub(crate) noise_of_band: NoiseLevels,
    pub(crate) gain: Vec<f64>,
    /// The effects of the fit, and their columns: `[spectrum][row][column]`, N m per unit.
    pub(crate) effects: Vec<Effect>,
    pub(crate) effect_rows: Vec<Vec<Vec<f64>>>,
}
