//! RIST-MH: identification from the experiments of [Vandanjon, Gautier, Desbats 1995], "the paper", with all harmonics, real and
//! imaginary part, and friction as nuisance.
//!
//! The method is weighted least squares on the rows of `harmonics` and on the gravity rows, equation (13) of the paper. The
//! unknowns are the base parameters X and, for each joint j, the coefficients f_j of its friction columns C. D: rows of the
//! regressor. For experiment e
//!
//! tau_ej = D_ej X + (1 + u_ej) C_ej f_j + noise,   u_ej ~ N(0, s^2).
//!
//! u_ej is the drift of the friction of joint j in experiment e (temperature, grease). The standard deviation s of the drift is
//! estimated too, by s^2 <- sum u^2 / sum(1 - var u / s^2) [MacKay 1992, evidence iteration]. If friction does not drift, s
//! becomes zero, so the unknowns u_ej add no uncertainty. Gauss-Newton linearises the product u f. The first weights follow
//! from the noise of torque and position, measured from the scatter between periods. Later weights follow from the residual of
//! each joint.
//!
//! A motion that does not exactly repeat (a controller with chatter) ends with another position and velocity than at its start.
//! Each of these two differences adds a column of known shape to the rows of each joint. Both unknowns are nuisance parameters.
//!
//! The Bayesian information criterion (BIC) chooses the friction columns: asymmetric viscous and Coulomb friction alone (equation
//! (5) of the paper), or with load and Stribeck terms. The orthogonality of the paper is not needed here: friction is in the
//! model, and its many harmonics distinguish it from other torques.

use linear_model::friction::periodic::FrictionShape;
use linear_model::regressor::Regressor;
use numerics::least_squares::{Solution, solve};

use crate::estimators::drive_gains::likelihood::Gain;
use crate::spectrum::experiment::{NoiseLevels, SpectralExperiment};
use crate::spectrum::harmonics::{Band, JointSpectrum, joint_spectra, mean_period};
use crate::spectrum::paper::paper_rows;
use crate::spectrum::rist_mh::cause::Cause;
use crate::spectrum::rist_mh::data::{HarmonicData, HarmonicOptions};
use crate::spectrum::rist_mh::effects::{Effect, EffectSize};
use crate::spectrum::rist_mh::fit::IterationState;
use crate::spectrum::rist_mh::layout::Layout;
use crate::spectrum::rist_mh::misfit::Misfit;

/// Largest number of linearisations about the sizes of springs and gaps (between motor and link).
const MAX_YIELDING_ROUNDS: usize = 12;
/// The sizes of springs and gaps have converged if no size changes by more than this share.
const SETTLED_SIZE_CHANGE: f64 = 1e-4;

/// The result of RIST-MH: parameters, friction and misfit.
#[derive(Clone, Debug)]
pub struct HarmonicEstimate {
    /// All unknowns, in the order of `layout`. The field `inverse` is the covariance for the noise that the weights contain.
    pub solution: Solution,
    /// The index ranges of the unknowns.
    pub layout: Layout,
    /// For each experiment, a copy of the unknowns in which parameters, friction and effects are estimated from the other
    /// experiments. Empty if there is only one experiment.
    pub left_out: Vec<Vec<f64>>,
    /// The shape of friction that BIC selected.
    pub shape: FrictionShape,
    /// Standard deviation s of the drift, relative to friction.
    pub drift_spread: f64,
    /// The estimated effects other than friction, which are the last unknowns.
    pub effects: Vec<EffectSize>,
    /// The misfit, computed with the measured noise. The misfit does not depend on the weights of the fit.
    pub misfit: Misfit,
    /// The effect that the model most likely lacks. `None` if the model lacks no effect, or if no single effect explains the
    /// misfit.
    pub cause: Option<Cause>,
}

impl HarmonicEstimate {
    /// The delay of the torques in addition to the delay of the band, s. `None` if the delay was not estimated.
    pub fn delay(&self) -> Option<f64> {
        let found = self.effects.iter().find(|e| e.effect == Effect::Delay)?;
        found.values.first().copied()
    }

    /// The values of the base parameters.
    pub fn values(&self) -> &[f64] {
        &self.solution.x[self.layout.parameters()]
    }

    /// Standard deviations of the base parameters for the noise that the weights contain.
    pub fn deviations(&self) -> Vec<f64> {
        self.layout.parameters().map(|i| self.solution.inverse[(i, i)].max(0.0).sqrt()).collect()
    }

    /// Standard deviation of parameter or friction coefficient i due to effects that the model lacks; zero if the model lacks
    /// no effect.
    ///
    /// The value is the root of the sum of two squares: the standard deviation with experiments as clusters, and the change of
    /// the parameter when the named cause is added to the model.
    pub fn lacked(&self, i: usize) -> f64 {
        let by_experiment = self.misfit.by_experiment.get(i).copied().unwrap_or(0.0);
        by_experiment.hypot(self.cause.as_ref().and_then(|cause| cause.shift.get(i).copied()).unwrap_or(0.0))
    }
}

impl<'a> HarmonicData<'a> {
    /// Computes the data from experiments. `gain`: N m per unit of the recorded currents; `noise`: noise of a single sample.
    pub fn new(
        experiments: &[SpectralExperiment],
        regressor: &'a dyn Regressor,
        gain: &[f64],
        noise: &NoiseLevels,
        band: &Band,
    ) -> HarmonicData<'a> {
        let motions: Vec<_> = experiments.iter().map(|e| mean_period(e, band)).collect();
        let of = |(i, (e, motion)): (usize, (&SpectralExperiment, &Option<_>))| {
            motion.as_ref().map_or(vec![], |motion| joint_spectra(i, e, motion, regressor, band))
        };
        let spectra = experiments.iter().zip(&motions).enumerate().flat_map(of).collect();
        let one = vec![1.0; gain.len()];
        let sweeps = || experiments.iter().filter(|e| e.period().is_none());
        // A gravity row is linear in the torque. A spring of 1 N m/rad has the torque q. So if the positions replace the
        // torques, the right-hand side of the row is the column of this spring.
        let springs = |e: &SpectralExperiment| SpectralExperiment { current: e.q.clone(), ..e.clone() };
        let rows = |e: &SpectralExperiment| paper_rows(e, regressor, &one, &noise.current);
        HarmonicData {
            p: regressor.parameters().len(),
            n: gain.len(),
            regressor,
            motions,
            effects: vec![],
            effect_rows: vec![],
            spectra,
            sweeps: sweeps().map(rows).collect(),
            swept_springs: sweeps().map(|e| rows(&springs(e)).right).collect(),
            noise: noise.clone(),
            noise_of_band: NoiseLevels::of_band(experiments, band.equations).unwrap_or_else(|| noise.clone()),
            gain: gain.to_vec(),
        }
    }

    /// The spectra of all experiments and joints.
    pub fn spectra(&self) -> &[JointSpectrum] {
        &self.spectra
    }

    /// The estimate with the best friction columns. `None` without equations.
    ///
    /// First the rest velocity is chosen, with asymmetric viscous and Coulomb friction. Then load and Stribeck terms are chosen.
    /// If there are such terms, the rest velocity is chosen again.
    ///
    /// Afterwards `self` has the columns of the effects, and the motion of links behind springs and gaps. With the first choice
    /// of friction, the sizes of springs and gaps are iterated to convergence. Then friction is chosen again, and the sizes are
    /// iterated again.
    pub fn estimate(&mut self, options: &HarmonicOptions) -> Option<HarmonicEstimate> {
        let best = self.fitted(options)?;
        let mut found = self.finished(&best, &[]);
        self.explain(&mut found, &best, options);
        Some(found)
    }

    /// Searches for the effect that the model lacks if the residual exceeds the noise. A cause is named only if it explains at
    /// least half of the misfit.
    pub(crate) fn explain(&self, found: &mut HarmonicEstimate, fit: &IterationState, options: &HarmonicOptions) {
        if found.misfit.is_beyond_noise() {
            found.cause = self.cause(fit, &found.misfit, options);
        }
    }

    pub(crate) fn fitted(&mut self, options: &HarmonicOptions) -> Option<IterationState> {
        self.lay(&options.effects);
        let mut best = self.best_fit(options)?;
        if self.has_yielding() {
            for again in [true, false] {
                self.settle(&mut best, options);
                if again {
                    best = self.best_fit(options)?;
                }
            }
        }
        Some(best)
    }

    /// Repeats the linearisation about the sizes of springs and gaps (between motor and link) until these sizes converge.
    fn settle(&mut self, fit: &mut IterationState, options: &HarmonicOptions) {
        let sizes = |fit: &IterationState| fit.x[fit.layout.effects()].to_vec();
        for _ in 0..MAX_YIELDING_ROUNDS {
            let before = sizes(fit);
            self.yield_by(fit);
            let deviation = if options.weights { fit.calibrated(self) } else { fit.deviation.clone() };
            *fit = IterationState::new(self, &fit.shape, options, deviation);
            let is_settled = |(a, b): (&f64, &f64)| (a - b).abs() <= SETTLED_SIZE_CHANGE * b.abs();
            if sizes(fit).iter().zip(&before).all(is_settled) {
                break;
            }
        }
    }

    /// The fit with the friction columns of the smallest BIC, with weights calibrated by the residuals. `None` if there is no
    /// candidate.
    pub(crate) fn best_fit(&self, options: &HarmonicOptions) -> Option<IterationState> {
        let shape = |rest_velocity, load, stribeck| FrictionShape { rest_velocity, load, stribeck };
        let first = options.rest_velocities.first().copied().unwrap_or(FrictionShape::ASYMMETRIC.rest_velocity);
        let start = IterationState::new(self, &shape(first, false, None), options, self.deviations(None));
        let mut deviation = start.deviation.clone();
        if options.weights {
            deviation = self.deviations(Some(&start.x[..self.p]));
            let fit = IterationState::new(self, &shape(first, false, None), options, deviation);
            deviation = fit.calibrated(self);
        }
        let mut tried: Vec<IterationState> = Vec::new();
        let mut try_all = |shapes: Vec<FrictionShape>, tried: &mut Vec<IterationState>| -> Option<FrictionShape> {
            for s in shapes {
                if tried.iter().all(|f| f.shape != s) {
                    tried.push(IterationState::new(self, &s, options, deviation.clone()));
                }
            }
            let best = tried.iter().reduce(|a, b| if b.criterion() < a.criterion() { b } else { a })?;
            if options.weights && tried.len() == options.rest_velocities.len() {
                // Load and Stribeck terms are compared at the weights that belong to the best rest velocity.
                let again = best.calibrated(self);
                let shape = best.shape;
                deviation = again;
                tried.clear();
                tried.push(IterationState::new(self, &shape, options, deviation.clone()));
                return Some(shape);
            }
            Some(best.shape)
        };
        let rests = |load, stribeck| options.rest_velocities.iter().map(|&w| shape(w, load, stribeck)).collect();
        let best = try_all(rests(false, None), &mut tried)?;
        let mut further = Vec::new();
        for load in [false, true].into_iter().take(1 + usize::from(options.load)) {
            let speeds = options.stribeck_velocities.iter().map(|&v| Some(v));
            further.extend(std::iter::once(None).chain(speeds).map(|s| shape(best.rest_velocity, load, s)));
        }
        let mut best = try_all(further, &mut tried)?;
        if best.load || best.stribeck.is_some() {
            best = try_all(rests(best.load, best.stribeck), &mut tried)?;
        }
        let at = tried.iter().position(|f| f.shape == best)?;
        let mut best = tried.swap_remove(at);
        if options.weights {
            best.deviation = best.calibrated(self);
            best.solve(self);
        }
        Some(best)
    }

    pub(crate) fn finished(&self, best: &IterationState, gains: &[Gain]) -> HarmonicEstimate {
        let solution = solve(&best.triangle(self));
        let at = best.layout_of(self);
        HarmonicEstimate {
            layout: at,
            shape: best.shape,
            drift_spread: best.drift_spread(),
            effects: self.sizes(&solution, at.effects().start),
            left_out: self.left_out(best, &solution.x),
            misfit: self.misfit(best, gains),
            cause: None,
            solution,
        }
    }

    /// The sizes of the effects of a fit.
    pub(crate) fn effect_sizes(&self, fit: &IterationState) -> Vec<EffectSize> {
        let solution = solve(&fit.triangle(self));
        self.sizes(&solution, fit.layout_of(self).effects().start)
    }

    fn sizes(&self, solution: &Solution, mut first: usize) -> Vec<EffectSize> {
        let mut sizes = Vec::new();
        for &effect in &self.effects {
            let at = first..first + effect.columns();
            first = at.end;
            let deviations = at.clone().map(|i| solution.inverse[(i, i)].max(0.0).sqrt()).collect();
            sizes.push(EffectSize { effect, values: solution.x[at].to_vec(), deviations });
        }
        sizes
    }

    pub(crate) fn deviations(&self, parameters: Option<&[f64]>) -> Vec<Vec<f64>> {
        self.deviations_by(&self.noise, parameters)
    }

    pub(crate) fn deviations_by(&self, noise: &NoiseLevels, parameters: Option<&[f64]>) -> Vec<Vec<f64>> {
        self.spectra.iter().map(|s| s.deviation(noise, self.gain[s.joint], parameters)).collect()
    }
}
