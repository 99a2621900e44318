//! RIST-MH: the paper's experiments, every harmonic, both quadratures, friction as nuisance.
//!
//! Weighted least squares on the rows of `harmonic_rows` and the gravity rows (13), unknowns X and,
//! for each joint, the coefficients f_j of its friction columns:
//!
//! tau_ej = D_ej X + (1 + u_ej) C_ej f_j + noise,   u_ej ~ N(0, s^2).
//!
//! u_ej is the drift of a joint's friction from experiment to experiment (temperature, grease). Its
//! spread s is estimated with the rest by s^2 <- sum u^2 / sum(1 - var u / s^2)
//! [MacKay 1992, the evidence iteration], so it costs nothing where there is no drift. Gauss-Newton
//! on the product u f. The weights hold the noise of torque and position, both measured from the
//! scatter between periods, and then what each joint's rows leave unexplained.
//!
//! A motion that does not quite repeat (a controller that chatters on its encoder) ends with another
//! position and velocity than it began with; each adds a column of known shape to each joint's
//! rows, and both are nuisance too.
//!
//! Which friction columns are used is chosen by BIC among equation (5) alone and with load and
//! Stribeck terms. The paper's orthogonality is no longer needed: friction is in the model, and all
//! of its harmonics tell it apart.

use crate::drive_gains::{JointEquations, without_nuisance};
use crate::friction_columns::FrictionShape;
use crate::harmonic_rows::{Band, JointSpectrum, joint_spectra};
use crate::least_squares::{Solution, solve};
use crate::paper_estimation::paper_rows;
use crate::regressor::Regressor;
use crate::spectral_experiment::{NoiseLevels, SpectralExperiment};
use crate::spectrum_rows::EquationBlock;
use crate::triangle::{Block, Triangle};

/// What is estimated beside the parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicOptions {
    pub band: Band,
    /// Velocities over which the sign of friction may turn, rad/s; the best by BIC is used.
    pub rest_velocities: Vec<f64>,
    /// Stribeck velocities tried, rad/s.
    pub stribeck_velocities: Vec<f64>,
    /// Coulomb friction that grows with the load is tried.
    pub load: bool,
    /// Friction may differ from experiment to experiment.
    pub drift: bool,
    /// Weights count the noise of the position, and what each joint's rows leave unexplained.
    pub weights: bool,
    /// The motion may end otherwise than it began.
    pub ends: bool,
    /// Estimate what is left of the delay between current and position.
    pub delay: bool,
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
            delay: false,
        }
    }
}

impl HarmonicOptions {
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

/// Parameters, friction and how well they explain the record.
#[derive(Clone, Debug)]
pub struct HarmonicEstimate {
    /// Unknowns in the order parameters, friction of joint 0, 1, ..., drifts, delay; `inverse` is the
    /// covariance for the noise of the weights.
    pub solution: Solution,
    /// Number of base parameters, the first of the unknowns.
    pub parameters: usize,
    pub shape: FrictionShape,
    /// (experiment, joint, u).
    pub drift: Vec<(usize, usize, f64)>,
    /// s.
    pub drift_spread: f64,
    /// s, beyond that of the band.
    pub delay: Option<f64>,
    /// Sum of squares of the weighted residuals.
    pub chi_square: f64,
    /// Rows less unknowns.
    pub freedom: usize,
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

/// The spectra of the experiments, computed once.
pub struct HarmonicData {
    p: usize,
    n: usize,
    spectra: Vec<JointSpectrum>,
    sweeps: Vec<EquationBlock>,
    noise: NoiseLevels,
    gain: Vec<f64>,
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
        let torque_noise = noise.torque(gain);
        let sweeps = experiments.iter().filter(|e| e.period().is_none());
        HarmonicData {
            p: regressor.parameters().len(),
            n: gain.len(),
            spectra,
            sweeps: sweeps.map(|e| paper_rows(e, regressor, gain, &torque_noise)).collect(),
            noise: noise.clone(),
            gain: gain.to_vec(),
        }
    }

    pub fn spectra(&self) -> &[JointSpectrum] {
        &self.spectra
    }

    pub fn sweeps(&self) -> &[EquationBlock] {
        &self.sweeps
    }

    /// Each joint's equations in currents with its friction and ends projected out; the data must have
    /// been built with unit gains. What a joint's own best parameters leave sets its noise.
    pub fn current_equations(&self, shape: &FrictionShape) -> Vec<JointEquations> {
        let (p, m, deviations) = (self.p, shape.columns(), self.deviations(None));
        let of_joint = |j: usize| {
            let spectra: Vec<usize> = (0..self.spectra.len()).filter(|&e| self.spectra[e].joint == j).collect();
            let nuisance = m + 2 * spectra.len();
            let (mut rows, mut current) = (vec![], vec![]);
            for (at, &e) in spectra.iter().enumerate() {
                let s = &self.spectra[e];
                let (friction, ends) = (s.friction_rows(shape, 1.0), s.end_columns());
                for r in 0..s.rows.len() {
                    let w = 1.0 / deviations[e][r];
                    let mut row = vec![0.0; nuisance + p];
                    row[..m].iter_mut().zip(&friction[r]).for_each(|(x, c)| *x = w * c);
                    row[m + 2 * at..m + 2 * at + 2].iter_mut().zip(ends[r]).for_each(|(x, c)| *x = w * c);
                    row[nuisance..].iter_mut().zip(&s.rows[r]).for_each(|(x, d)| *x = w * d);
                    rows.push(row);
                    current.push(w * s.current[r]);
                }
            }
            for sweep in &self.sweeps {
                for (i, d) in sweep.rows.iter().enumerate().filter(|(i, _)| sweep.joint[*i] == j) {
                    let w = 1.0 / sweep.deviation[i];
                    let mut row = vec![0.0; nuisance + p];
                    row[nuisance..].iter_mut().zip(d).for_each(|(x, d)| *x = w * d);
                    rows.push(row);
                    current.push(w * sweep.right[i]);
                }
            }
            without_nuisance(&rows, &current, nuisance, true)
        };
        (0..self.n).map(of_joint).collect()
    }

    /// The estimate with the best of the friction shapes; `None` without equations.
    ///
    /// The rest velocity is chosen for equation (5), then the further terms, then the rest velocity
    /// again if there are any.
    pub fn estimate(&self, options: &HarmonicOptions) -> Option<HarmonicEstimate> {
        let shape = |rest_velocity, load, stribeck| FrictionShape { rest_velocity, load, stribeck };
        let first = options.rest_velocities.first().copied().unwrap_or(FrictionShape::ASYMMETRIC.rest_velocity);
        let start = self.fit(&shape(first, false, None), options, self.deviations(None));
        let mut deviation = start.deviation.clone();
        if options.weights {
            deviation = self.deviations(Some(&start.x[..self.p]));
            let fit = self.fit(&shape(first, false, None), options, deviation);
            deviation = fit.calibrated(self);
        }
        let mut tried: Vec<Fit> = Vec::new();
        let mut try_all = |shapes: Vec<FrictionShape>, tried: &mut Vec<Fit>| -> Option<FrictionShape> {
            for s in shapes {
                if tried.iter().all(|f| f.shape != s) {
                    tried.push(self.fit(&s, options, deviation.clone()));
                }
            }
            let best = tried.iter().reduce(|a, b| if b.criterion() < a.criterion() { b } else { a })?;
            if options.weights && tried.len() == options.rest_velocities.len() {
                // The spread about the best sign is what the further terms are judged by.
                let again = best.calibrated(self);
                let shape = best.shape;
                deviation = again;
                tried.clear();
                tried.push(self.fit(&shape, options, deviation.clone()));
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
        Some(self.finished(tried.swap_remove(at), options, criteria))
    }

    fn finished(
        &self,
        mut best: Fit,
        options: &HarmonicOptions,
        criteria: Vec<(FrictionShape, f64)>,
    ) -> HarmonicEstimate {
        if options.weights {
            best.deviation = best.calibrated(self);
            best.solve(self, options);
        }
        let solution = solve(&best.triangle(self, options));
        let first_drift = self.p + self.n * best.shape.columns();
        let drift = |(i, s): (usize, &JointSpectrum)| (s.experiment, s.joint, solution.x[first_drift + i]);
        let with_drift = best.has_drift();
        let delay = options.delay.then(|| solution.x.last().copied().unwrap_or(0.0));
        HarmonicEstimate {
            parameters: self.p,
            shape: best.shape,
            drift: if with_drift { self.spectra.iter().enumerate().map(drift).collect() } else { vec![] },
            drift_spread: if with_drift { best.spread } else { 0.0 },
            delay,
            chi_square: best.chi_square,
            freedom: best.rows.saturating_sub(solution.rank),
            criteria,
            solution,
        }
    }

    fn fit(&self, shape: &FrictionShape, options: &HarmonicOptions, deviation: Vec<Vec<f64>>) -> Fit {
        let friction = self.spectra.iter().map(|s| s.friction_rows(shape, self.gain[s.joint])).collect();
        let mut fit = Fit {
            shape: *shape,
            friction,
            deviation,
            x: vec![],
            drift: vec![0.0; self.spectra.len()],
            spread: 0.0,
            squares: vec![],
            chi_square: 0.0,
            rows: 0,
            effective: 0.0,
        };
        fit.solve(self, options);
        if options.drift {
            fit.spread = 0.1;
            for _ in 0..DRIFT_ITERATIONS {
                let before = fit.spread;
                fit.solve(self, options);
                if fit.spread < LEAST_SPREAD || (fit.spread - before).abs() < 1e-3 * before {
                    break;
                }
            }
            if !fit.has_drift() {
                fit.drift.fill(0.0);
                fit.solve(self, options);
            }
        }
        fit
    }

    fn deviations(&self, parameters: Option<&[f64]>) -> Vec<Vec<f64>> {
        self.spectra.iter().map(|s| s.deviation(&self.noise, self.gain[s.joint], parameters)).collect()
    }
}

/// The evidence iteration contracts by about half each time; its last steps change nothing.
const DRIFT_ITERATIONS: usize = 12;
/// A relative spread below this is no drift.
const LEAST_SPREAD: f64 = 2e-3;

/// The state of the iteration for one shape.
struct Fit {
    shape: FrictionShape,
    /// Rows of the friction columns of each spectrum.
    friction: Vec<Vec<Vec<f64>>>,
    deviation: Vec<Vec<f64>>,
    x: Vec<f64>,
    drift: Vec<f64>,
    spread: f64,
    /// Weighted squares each spectrum leaves.
    squares: Vec<f64>,
    chi_square: f64,
    rows: usize,
    /// Unknowns that count: drifts by the share the data decide.
    effective: f64,
}

impl Fit {
    fn has_drift(&self) -> bool {
        self.spread >= LEAST_SPREAD
    }

    fn criterion(&self) -> f64 {
        self.chi_square + self.effective * (self.rows.max(1) as f64).ln()
    }

    /// Deviations scaled, joint by joint, to what the rows leave unexplained.
    fn calibrated(&self, data: &HarmonicData) -> Vec<Vec<f64>> {
        let share = 1.0 - self.effective / self.rows.max(1) as f64;
        let factor = |joint: usize| {
            let of_joint = || data.spectra.iter().zip(&self.squares).filter(|(s, _)| s.joint == joint);
            let count: usize = of_joint().map(|(s, _)| s.rows.len()).sum();
            let squares: f64 = of_joint().map(|(_, q)| q).sum();
            let mean = squares / (count.max(1) as f64 * share.max(0.1));
            if mean > 0.0 { mean.sqrt() } else { 1.0 }
        };
        let factors: Vec<f64> = (0..data.n).map(factor).collect();
        let scaled = |(s, d): (&JointSpectrum, &Vec<f64>)| d.iter().map(|d| d * factors[s.joint]).collect();
        data.spectra.iter().zip(&self.deviation).map(scaled).collect()
    }

    /// Weighted squares of the residuals, spectrum by spectrum.
    fn residuals(&self, data: &HarmonicData, options: &HarmonicOptions) -> Vec<f64> {
        let (p, m) = (data.p, self.shape.columns());
        let unknowns = self.unknowns(data, options);
        let first_end = unknowns.saturating_sub(usize::from(options.delay) + 2 * data.spectra.len());
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let of = |(e, s): (usize, &JointSpectrum)| {
            let friction = &self.x[p + s.joint * m..p + (s.joint + 1) * m];
            let ends = s.end_columns();
            let delays = if options.delay { s.delay_column() } else { vec![] };
            let square = |r: usize| {
                let mut model = dot(&s.rows[r], &self.x[..p]);
                model += (1.0 + self.drift[e]) * dot(&self.friction[e][r], friction);
                if options.ends {
                    model += dot(&ends[r], &self.x[first_end + 2 * e..first_end + 2 * e + 2]);
                }
                if options.delay {
                    model -= data.gain[s.joint] * delays[r] * self.x[unknowns - 1];
                }
                ((data.gain[s.joint] * s.current[r] - model) / self.deviation[e][r]).powi(2)
            };
            (0..s.rows.len()).map(square).sum()
        };
        data.spectra.iter().enumerate().map(of).collect()
    }

    fn unknowns(&self, data: &HarmonicData, options: &HarmonicOptions) -> usize {
        let drifts = if self.has_drift() { self.drift.len() } else { 0 };
        let ends = if options.ends { 2 * data.spectra.len() } else { 0 };
        data.p + data.n * self.shape.columns() + drifts + ends + usize::from(options.delay)
    }

    /// The linearised, weighted rows about the present friction and drift.
    fn triangle(&self, data: &HarmonicData, options: &HarmonicOptions) -> Triangle {
        let (p, m) = (data.p, self.shape.columns());
        let unknowns = self.unknowns(data, options);
        let first_drift = p + data.n * m;
        let mut triangle = Triangle::new(unknowns);
        let mut block = Block::new(unknowns);
        let mut row = vec![0.0; unknowns];
        let mut push = |row: &mut Vec<f64>, y: f64| {
            if block.is_full() {
                triangle.fold(&mut block);
            }
            block.push(row, y);
            row.fill(0.0);
        };
        for (e, s) in data.spectra.iter().enumerate() {
            let gain = data.gain[s.joint];
            let first = p + s.joint * m;
            let ends = s.end_columns();
            let delay = if options.delay { s.delay_column() } else { vec![] };
            for r in 0..s.rows.len() {
                let w = 1.0 / self.deviation[e][r];
                let c = &self.friction[e][r];
                let mut y = gain * s.current[r];
                row[..p].iter_mut().zip(&s.rows[r]).for_each(|(x, d)| *x = w * d);
                let scale = 1.0 + self.drift[e];
                row[first..first + m].iter_mut().zip(c).for_each(|(x, c)| *x = w * scale * c);
                if self.has_drift() && !self.x.is_empty() {
                    let now: f64 = c.iter().zip(&self.x[first..first + m]).map(|(c, f)| c * f).sum();
                    row[first_drift + e] = w * now;
                    y += self.drift[e] * now;
                }
                if options.ends {
                    let first = unknowns - usize::from(options.delay) - 2 * data.spectra.len() + 2 * e;
                    row[first] = w * ends[r][0];
                    row[first + 1] = w * ends[r][1];
                }
                if options.delay {
                    row[unknowns - 1] = -w * gain * delay[r];
                }
                push(&mut row, w * y);
            }
        }
        for sweep in &data.sweeps {
            for (i, d) in sweep.rows.iter().enumerate() {
                let w = 1.0 / sweep.deviation[i];
                row[..p].iter_mut().zip(d).for_each(|(x, d)| *x = w * d);
                push(&mut row, w * sweep.right[i]);
            }
        }
        if self.has_drift() {
            for e in 0..self.drift.len() {
                row[first_drift + e] = 1.0 / self.spread;
                push(&mut row, 0.0);
            }
        }
        triangle.fold(&mut block);
        triangle
    }

    /// One Gauss-Newton step and one step of the spread.
    fn solve(&mut self, data: &HarmonicData, options: &HarmonicOptions) {
        let triangle = self.triangle(data, options);
        let unknowns = triangle.columns();
        let (x, variances) = back_substitute(&triangle);
        self.chi_square = triangle.squares(&x).1;
        self.rows = triangle.rows;
        self.effective = unknowns as f64 + if self.shape.stribeck.is_some() { 1.0 } else { 0.0 };
        if self.has_drift() {
            let first = data.p + data.n * self.shape.columns();
            let drifts = first..first + self.drift.len();
            let decided: f64 = drifts.clone().map(|i| 1.0 - variances[i] / self.spread.powi(2)).sum();
            self.drift.copy_from_slice(&x[drifts]);
            self.rows -= self.drift.len();
            self.effective -= self.drift.len() as f64 - decided;
            let squares: f64 = self.drift.iter().map(|u| u * u).sum();
            self.spread = (squares / decided.max(1e-3)).sqrt();
        }
        self.x = x;
        self.squares = self.residuals(data, options);
    }
}

/// R x = z and the diagonal of (R'R)^-1; a column without information gets zero.
fn back_substitute(triangle: &Triangle) -> (Vec<f64>, Vec<f64>) {
    let p = triangle.columns();
    // Relative to the column: what is left of it after those before.
    let void: Vec<bool> = (0..p).map(|c| triangle.at(c, c).abs() <= 1e-10 * triangle.column_norm(c)).collect();
    let solve = |right: &dyn Fn(usize) -> f64| {
        let mut x = vec![0.0; p];
        for i in (0..p).rev() {
            if !void[i] {
                let tail: f64 = (i + 1..p).map(|j| triangle.at(i, j) * x[j]).sum();
                x[i] = (right(i) - tail) / triangle.at(i, i);
            }
        }
        x
    };
    let x = solve(&|i| triangle.at(i, p));
    let mut variances = vec![0.0; p];
    for k in 0..p {
        // Column k of R^-1.
        let column = solve(&|i| if i == k { 1.0 } else { 0.0 });
        variances.iter_mut().zip(column).for_each(|(v, c)| *v += c * c);
    }
    (x, variances)
}
