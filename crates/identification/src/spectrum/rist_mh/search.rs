//! RIST-MH: the paper's experiments, every harmonic, both quadratures, friction as nuisance.
//!
//! Weighted least squares on the rows of `harmonics` and the gravity rows (13). The unknowns are X and,
//! for each joint, the coefficients f_j of its friction columns:
//!
//! tau_ej = D_ej X + (1 + u_ej) C_ej f_j + noise,   u_ej ~ N(0, s^2).
//!
//! u_ej is the drift of a joint's friction from experiment to experiment (temperature, grease). Its
//! spread s is estimated with the rest by s^2 <- sum u^2 / sum(1 - var u / s^2)
//! [MacKay 1992, the evidence iteration], so it costs nothing where there is no drift. Gauss-Newton
//! solves for the product u f. The weights first hold the noise of torque and position, both measured
//! from the scatter between periods, and then what each joint's rows leave unexplained.
//!
//! A motion that does not quite repeat (a controller that chatters on its encoder) ends with another
//! position and velocity than it began with; each adds a column of known shape to each joint's
//! rows, and both are nuisance too.
//!
//! BIC chooses the friction columns: equation (5) alone, or with load and Stribeck terms. The paper's
//! orthogonality is not needed here: friction is in the model, and its many harmonics tell it apart.

use crate::algebra::least_squares::{Solution, solve};
use crate::model::friction::periodic::FrictionShape;
use crate::model::regressor::Regressor;
use crate::spectrum::experiment::{NoiseLevels, SpectralExperiment};
use crate::spectrum::harmonics::{Band, JointSpectrum, joint_spectra};
use crate::spectrum::paper::paper_rows;
use crate::spectrum::rist_mh::data::{HarmonicData, HarmonicOptions};
use crate::spectrum::rist_mh::fit::Fit;
use crate::spectrum::rist_mh::misfit::Misfit;

/// Parameters, friction and how well they explain the record.
#[derive(Clone, Debug)]
pub struct HarmonicEstimate {
    /// Unknowns in the order parameters, friction of joint 0, 1, ..., drifts, ends, delay; `inverse` is the
    /// covariance for the noise of the weights.
    pub solution: Solution,
    /// Number of base parameters, the first of the unknowns.
    pub parameters: usize,
    /// The friction columns that fit best.
    pub shape: FrictionShape,
    /// (experiment, joint, u).
    pub drift: Vec<(usize, usize, f64)>,
    /// The spread s of the drift.
    pub drift_spread: f64,
    /// Delay beyond that of the band, s.
    pub delay: Option<f64>,
    /// Of each spectrum the two unknowns of a motion that ends otherwise than it began; empty where they are none.
    pub ends: Vec<[f64; 2]>,
    /// Sum of squares of the weighted residuals.
    pub chi_square: f64,
    /// Rows less unknowns.
    pub freedom: usize,
    /// Against the noise that was measured, whatever the weights are.
    pub misfit: Misfit,
    /// Each shape tried, with chi^2 + k ln(rows).
    pub criteria: Vec<(FrictionShape, f64)>,
}

impl HarmonicEstimate {
    /// The base parameters.
    pub fn values(&self) -> &[f64] {
        &self.solution.x[..self.parameters]
    }

    /// Standard deviations of the base parameters for the noise of the weights.
    pub fn deviations(&self) -> Vec<f64> {
        (0..self.parameters).map(|i| self.solution.inverse[(i, i)].max(0.0).sqrt()).collect()
    }

    /// Friction coefficients of a joint, in the order of the shape's columns.
    pub fn friction(&self, joint: usize) -> &[f64] {
        let m = self.shape.columns();
        &self.solution.x[self.parameters + joint * m..self.parameters + (joint + 1) * m]
    }
}

impl HarmonicData {
    /// `gain`: N m per unit of the record's currents; `noise`: a sample.
    pub fn new(
        experiments: &[SpectralExperiment],
        regressor: &dyn Regressor,
        gain: &[f64],
        noise: &NoiseLevels,
        band: &Band,
    ) -> HarmonicData {
        let spectra = experiments.iter().enumerate().flat_map(|(i, e)| joint_spectra(i, e, regressor, band)).collect();
        let one = vec![1.0; gain.len()];
        let sweeps = experiments.iter().filter(|e| e.period().is_none());
        HarmonicData {
            p: regressor.parameters().len(),
            n: gain.len(),
            spectra,
            sweeps: sweeps.map(|e| paper_rows(e, regressor, &one, &noise.current)).collect(),
            noise: noise.clone(),
            gain: gain.to_vec(),
        }
    }

    /// The spectra of every experiment and joint.
    pub fn spectra(&self) -> &[JointSpectrum] {
        &self.spectra
    }

    /// The estimate with the best of the friction shapes; `None` without equations.
    ///
    /// The rest velocity is chosen for equation (5), then the further terms, then the rest velocity
    /// again if there are any.
    pub fn estimate(&self, options: &HarmonicOptions) -> Option<HarmonicEstimate> {
        let (best, criteria) = self.best_fit(options)?;
        Some(self.finished(&best, options, criteria))
    }

    /// The fit with the best of the shapes, its weights calibrated, and the worth of each shape that was tried.
    pub(crate) fn best_fit(&self, options: &HarmonicOptions) -> Option<(Fit, Vec<(FrictionShape, f64)>)> {
        let shape = |rest_velocity, load, stribeck| FrictionShape { rest_velocity, load, stribeck };
        let first = options.rest_velocities.first().copied().unwrap_or(FrictionShape::ASYMMETRIC.rest_velocity);
        let start = Fit::new(self, &shape(first, false, None), options, self.deviations(None));
        let mut deviation = start.deviation.clone();
        if options.weights {
            deviation = self.deviations(Some(&start.x[..self.p]));
            let fit = Fit::new(self, &shape(first, false, None), options, deviation);
            deviation = fit.calibrated(self);
        }
        let mut tried: Vec<Fit> = Vec::new();
        let mut try_all = |shapes: Vec<FrictionShape>, tried: &mut Vec<Fit>| -> Option<FrictionShape> {
            for s in shapes {
                if tried.iter().all(|f| f.shape != s) {
                    tried.push(Fit::new(self, &s, options, deviation.clone()));
                }
            }
            let best = tried.iter().reduce(|a, b| if b.criterion() < a.criterion() { b } else { a })?;
            if options.weights && tried.len() == options.rest_velocities.len() {
                // The spread about the best sign is what the further terms are judged by.
                let again = best.calibrated(self);
                let shape = best.shape;
                deviation = again;
                tried.clear();
                tried.push(Fit::new(self, &shape, options, deviation.clone()));
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
        let criteria = tried.iter().map(|f| (f.shape, f.criterion())).collect();
        let at = tried.iter().position(|f| f.shape == best)?;
        let mut best = tried.swap_remove(at);
        if options.weights {
            best.deviation = best.calibrated(self);
            best.solve(self, options);
        }
        Some((best, criteria))
    }

    pub(crate) fn finished(
        &self,
        best: &Fit,
        options: &HarmonicOptions,
        criteria: Vec<(FrictionShape, f64)>,
    ) -> HarmonicEstimate {
        let solution = solve(&best.triangle(self, options));
        let first_drift = self.p + self.n * best.shape.columns();
        let drift = |(i, s): (usize, &JointSpectrum)| (s.experiment, s.joint, solution.x[first_drift + i]);
        let with_drift = best.has_drift();
        let delay = options.delay.then(|| solution.x.last().copied().unwrap_or(0.0));
        let first_end = solution.x.len().saturating_sub(usize::from(options.delay) + 2 * self.spectra.len());
        let ends = |i: usize| [solution.x[first_end + 2 * i], solution.x[first_end + 2 * i + 1]];
        HarmonicEstimate {
            ends: if options.ends { (0..self.spectra.len()).map(ends).collect() } else { vec![] },
            parameters: self.p,
            shape: best.shape,
            drift: if with_drift { self.spectra.iter().enumerate().map(drift).collect() } else { vec![] },
            drift_spread: best.drift_spread(),
            delay,
            misfit: self.misfit(best, options),
            chi_square: best.chi_square,
            freedom: best.rows.saturating_sub(solution.rank),
            criteria,
            solution,
        }
    }

    pub(crate) fn deviations(&self, parameters: Option<&[f64]>) -> Vec<Vec<f64>> {
        self.spectra.iter().map(|s| s.deviation(&self.noise, self.gain[s.joint], parameters)).collect()
    }
}
