//! The data of RIST-MH: the spectra of every experiment and joint, and the choices open to the search.

use experiments::plan::measured_motion::MeasuredMotion;
use experiments::plan::paper_rows::EquationBlock;
use linear_model::regressor::Regressor;

use crate::spectrum::experiment::NoiseLevels;
use crate::spectrum::harmonics::{Band, JointSpectrum};
use crate::spectrum::rist_mh::effects::Effect;

/// The unknowns beside the parameters, and the choices of the search.
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicOptions {
    /// Which harmonics are used.
    pub band: Band,
    /// Velocities over which the sign of friction may turn, rad/s; the best by BIC is used.
    pub rest_velocities: Vec<f64>,
    /// Stribeck velocities tried, rad/s.
    pub stribeck_velocities: Vec<f64>,
    /// Try Coulomb friction that grows with the load.
    pub load: bool,
    /// Let friction differ from experiment to experiment.
    pub drift: bool,
    /// Let the weights count the noise of the position, and what each joint's rows leave unexplained.
    pub weights: bool,
    /// Let the motion end at another position or velocity than it began with.
    pub ends: bool,
    /// Effects beside friction that are estimated with the rest.
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
/// Above it a link follows its own yielding more than its motor. R3G with joints of 12 Hz errs by 0.08 % with a chi^2
/// of 5; with equations up to 20 Hz, by 0.19 % with 28. Joints of 15 and 25 Hz err by 0.14 and 0.10 %; with equations
/// up to 20 Hz, by 0.13 and 0.08 % (`tests/benches/misfit.rs`, six draws).
const MAX_YIELDING_FREQUENCY_HZ: f64 = 10.0;

impl HarmonicOptions {
    /// Estimates these effects with the rest; behind springs and gaps the equations end earlier.
    pub fn with_effects(mut self, effects: Vec<Effect>) -> HarmonicOptions {
        if effects.iter().any(|e| matches!(e, Effect::Elastic { .. } | Effect::Play { .. })) {
            self.band.equations = self.band.equations.min(MAX_YIELDING_FREQUENCY_HZ);
        }
        self.effects.extend(effects);
        self
    }

    /// Equation (5) alone, the same in all experiments, weights of the torque noise.
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
    /// Of each sweep what these rows make of a spring of 1 N m/rad.
    pub(crate) swept_springs: Vec<Vec<f64>>,
    pub(crate) noise: NoiseLevels,
    /// The noise of the harmonics that give equations.
    pub(crate) noise_of_band: NoiseLevels,
    pub(crate) gain: Vec<f64>,
    /// The effects that are in the fit, and their columns: `[spectrum][row][column]`, N m per unit.
    pub(crate) effects: Vec<Effect>,
    pub(crate) effect_rows: Vec<Vec<Vec<f64>>>,
}
