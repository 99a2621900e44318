//! The data of RIST-MH: the spectra of all experiments and joints, and the options of the search for friction columns. RIST-MH
//! is weighted least squares on all harmonics of periodic experiments (`search` explains the method).

use experiments::plan::measured_motion::MeasuredMotion;
use experiments::plan::paper_rows::EquationBlock;
use linear_model::regressor::Regressor;

use crate::spectrum::experiment::NoiseLevels;
use crate::spectrum::harmonics::{Band, JointSpectrum};
use crate::spectrum::rist_mh::effects::Effect;

/// The options of RIST-MH: which unknowns are estimated in addition to the parameters, and what the search tries.
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicOptions {
    /// The frequency band of the equations and of the motion.
    pub band: Band,
    /// Candidates for the velocity range within which friction changes its sign, rad/s. The Bayesian information criterion (BIC)
    /// selects one.
    pub rest_velocities: Vec<f64>,
    /// Candidates for the Stribeck velocity, rad/s. The Bayesian information criterion (BIC) selects one, or no Stribeck term.
    pub stribeck_velocities: Vec<f64>,
    /// Whether to try Coulomb friction that grows with the load.
    pub load: bool,
    /// Whether friction may drift from experiment to experiment.
    pub drift: bool,
    /// Whether the weights of the rows also include the noise of the position and the residual of each joint.
    pub weights: bool,
    /// Whether the motion may end in another position or velocity than it starts with.
    pub ends: bool,
    /// Effects other than friction that are estimated together with the parameters.
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

/// Highest frequency of the equations if links are behind springs or gaps, Hz.
///
/// At higher frequencies the motion of a link depends more on the deflection than on the motor. The limit of 10 Hz was compared
/// with 20 Hz by the largest error of the parameters of the benchmark robot R3G (`tests/benches/misfit.rs`, six simulated data
/// sets). Errors with 10 Hz and with 20 Hz: 0.08 % and 0.19 % for joints with a natural frequency of 12 Hz (chi^2 5 and 28),
/// 0.14 % and 0.13 % for 15 Hz, 0.10 % and 0.08 % for 25 Hz.
const MAX_YIELDING_FREQUENCY_HZ: f64 = 10.0;

impl HarmonicOptions {
    /// A copy with additional effects. With springs or gaps, the highest frequency of the equations is lowered to
    /// `MAX_YIELDING_FREQUENCY_HZ`.
    pub fn with_effects(mut self, effects: Vec<Effect>) -> HarmonicOptions {
        if effects.iter().any(|e| matches!(e, Effect::Elastic { .. } | Effect::Play { .. })) {
            self.band.equations = self.band.equations.min(MAX_YIELDING_FREQUENCY_HZ);
        }
        self.effects.extend(effects);
        self
    }

    /// The simplest options: only asymmetric viscous and Coulomb friction, no drift, and weights from the torque noise.
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

/// The spectra of all experiments, which are computed once.
#[derive(Clone)]
pub struct HarmonicData<'a> {
    pub(crate) regressor: &'a dyn Regressor,
    /// The measured motion of each experiment; `None` for a sweep.
    pub(crate) motions: Vec<Option<MeasuredMotion>>,
    pub(crate) p: usize,
    pub(crate) n: usize,
    pub(crate) spectra: Vec<JointSpectrum>,
    /// The gravity rows of each sweep, in the unit of currents.
    pub(crate) sweeps: Vec<EquationBlock>,
    /// For each sweep, the column of a spring of 1 N m/rad in its gravity rows.
    pub(crate) swept_springs: Vec<Vec<f64>>,
    pub(crate) noise: NoiseLevels,
    /// The noise that is measured only in the harmonics of the frequency band of the equations.
    pub(crate) noise_of_band: NoiseLevels,
    pub(crate) gain: Vec<f64>,
    /// The effects of the fit, and their columns `effect_rows[spectrum][row][column]`, N m per unit.
    pub(crate) effects: Vec<Effect>,
    pub(crate) effect_rows: Vec<Vec<Vec<f64>>>,
}
