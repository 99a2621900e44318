//! Gauss-Newton iteration of RIST-MH for one choice of friction columns (shape): rows, weights, drift.
//!
//! The model of experiment e and joint j is tau_ej = D_ej X + (1 + u_ej) C_ej f_j + ends + noise. D: rows of the regressor; X:
//! base parameters; C: friction columns; f: friction coefficients; u: drift of friction; ends: torque of the jumps from the end
//! of the record to its start. The model is linearised about the present u and f: tau_ej + u C f = D_ej X + (1 + u) C f' + (C
//! f) u' with the new f', u'. An additional row with weight 1/s regularises each u' towards zero. `search` explains the method.

use linear_model::friction::periodic::FrictionShape;
use numerics::triangle::{Triangle, TriangleBuilder};

use crate::estimators::drive_gains::likelihood::Gain;
use crate::spectrum::harmonics::JointSpectrum;
use crate::spectrum::rist_mh::data::{HarmonicData, HarmonicOptions};
use crate::spectrum::rist_mh::effects::Effect;
use crate::spectrum::rist_mh::layout::Layout;

/// Largest number of steps of the evidence iteration for s, the relative standard deviation of the friction drifts. The error of
/// s halves in each step.
const DRIFT_ITERATIONS: usize = 12;
/// Friction counts as not drifting if the relative standard deviation s of the drifts is below this value.
const SMALLEST_DRIFT_SIGMA: f64 = 2e-3;
/// Initial relative standard deviation s of the friction drifts.
const INITIAL_DRIFT_SIGMA: f64 = 0.1;
/// The evidence iteration for the standard deviation s of drifts ends if s changes by less than this share.
const SETTLED_DRIFT_CHANGE: f64 = 1e-3;
/// Least value for the number of drifts that the data determine, to prevent a division by zero.
const LEAST_DETERMINED_DRIFTS: f64 = 1e-3;
/// Least number of degrees of freedom, divided by the number of rows.
const LEAST_FREE_SHARE: f64 = 0.1;

/// The joint of an equation, and its cluster: the group of rows whose residuals may be correlated.
#[derive(Clone, Copy, Debug)]
pub struct Owner {
    /// Index of the joint.
    pub joint: usize,
    /// Number of the cluster: index of the spectrum of the row. For a gravity row of a sweep: number of spectra plus index of
    /// the sweep.
    pub cluster: usize,
}

/// A weighted, linearised equation. The unknowns of the equation are the unknowns of the fit, then the unknown drive gains.
pub struct GainEquation {
    /// The joint and cluster of the equation. `None` for the row of an expected gain, which belongs to no joint.
    pub owner: Option<Owner>,
    /// Index of the spectrum, and index of the row in it. `None` for a gravity row of a sweep, and for a row that regularises an
    /// unknown.
    pub place: Option<(usize, usize)>,
    /// The coefficient of each unknown.
    pub coefficients: Vec<f64>,
    /// The right-hand side of the equation.
    pub right: f64,
}

/// The state of the Gauss-Newton iteration for one choice of friction columns.
pub(crate) struct IterationState {
    pub shape: FrictionShape,
    /// Whether the motion may end with another position or velocity than it starts with.
    ends: bool,
    /// Friction columns of each spectrum: `friction[spectrum][row][column]`.
    friction: Vec<Vec<Vec<f64>>>,
    pub deviation: Vec<Vec<f64>>,
    pub x: Vec<f64>,
    /// Indices of the unknowns in `x`.
    pub layout: Layout,
    drift: Vec<f64>,
    spread: f64,
    /// For each spectrum, the sum of the weighted squares of its residuals.
    squares: Vec<f64>,
    pub chi_square: f64,
    pub rows: usize,
    /// Effective number of unknowns: a drift that the data determine only partly counts as less than 1.
    effective: f64,
}

impl IterationState {
    /// Fits with one choice of friction columns until convergence. `deviation`: standard deviation of each row of each spectrum,
    /// N m.
    pub(crate) fn new(
        data: &HarmonicData,
        shape: &FrictionShape,
        options: &HarmonicOptions,
        deviation: Vec<Vec<f64>>,
    ) -> IterationState {
        let friction = data.spectra.iter().map(|s| s.friction_rows(shape, data.gain[s.joint])).collect();
        let mut fit = IterationState {
            shape: *shape,
            ends: options.ends,
            friction,
            deviation,
            x: vec![],
            layout: Layout::default(),
            drift: vec![0.0; data.spectra.len()],
            spread: 0.0,
            squares: vec![],
            chi_square: 0.0,
            rows: 0,
            effective: 0.0,
        };
        // The first fit is without drift. The friction f of this fit is the point about which the drift is linearised.
        fit.solve(data);
        if options.drift {
            // The standard deviation s of the drifts is iterated until s converges or is practically zero.
            fit.spread = INITIAL_DRIFT_SIGMA;
            for _ in 0..DRIFT_ITERATIONS {
                let before = fit.spread;
                fit.solve(data);
                if fit.spread < SMALLEST_DRIFT_SIGMA || (fit.spread - before).abs() < SETTLED_DRIFT_CHANGE * before {
                    break;
                }
            }
        }
        fit
    }

    pub(crate) fn has_drift(&self) -> bool {
        self.spread >= SMALLEST_DRIFT_SIGMA
    }

    /// The factor 1 + u by which the friction of a spectrum is multiplied. u: drift, relative.
    pub(crate) fn scale(&self, spectrum: usize) -> f64 {
        1.0 + self.drift[spectrum]
    }

    /// Relative standard deviation s of the drifts of friction; zero without drift.
    pub(crate) fn drift_spread(&self) -> f64 {
        if self.has_drift() { self.spread } else { 0.0 }
    }

    /// The Bayesian information criterion: chi^2 + (effective number of unknowns) ln(rows).
    pub(crate) fn criterion(&self) -> f64 {
        self.chi_square + self.effective * (self.rows.max(1) as f64).ln()
    }

    /// Degrees of freedom divided by the number of rows, at least `LEAST_FREE_SHARE`.
    pub(crate) fn free_share(&self) -> f64 {
        (1.0 - self.effective / self.rows.max(1) as f64).max(LEAST_FREE_SHARE)
    }

    /// The standard deviations of the rows, N m, multiplied by one factor per joint so that they agree with the residuals of the
    /// joint.
    pub(crate) fn calibrated(&self, data: &HarmonicData) -> Vec<Vec<f64>> {
        let share = self.free_share();
        let factor = |joint: usize| {
            let of_joint = || data.spectra.iter().zip(&self.squares).filter(|(s, _)| s.joint == joint);
            let count: usize = of_joint().map(|(s, _)| s.rows.len()).sum();
            let squares: f64 = of_joint().map(|(_, q)| q).sum();
            let mean = squares / (count.max(1) as f64 * share);
            if mean > 0.0 { mean.sqrt() } else { 1.0 }
        };
        let factors: Vec<f64> = (0..data.n).map(factor).collect();
        let scaled = |(s, d): (&JointSpectrum, &Vec<f64>)| d.iter().map(|d| d * factors[s.joint]).collect();
        data.spectra.iter().zip(&self.deviation).map(scaled).collect()
    }

    /// For each spectrum, the sum of the squares of residual / `deviation` over its rows.
    pub(crate) fn squares_by(&self, data: &HarmonicData, deviation: &[Vec<f64>]) -> Vec<f64> {
        let residuals = self.residuals(data, deviation);
        residuals.iter().map(|of| of.iter().map(|r| r * r).sum()).collect()
    }

    /// For each spectrum, residual / `deviation` of each row.
    pub(crate) fn residuals(&self, data: &HarmonicData, deviation: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let at = self.layout;
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let of = |(e, s): (usize, &JointSpectrum)| {
            let friction = &self.x[at.friction(s.joint)];
            let ends = s.end_columns();
            let residual = |r: usize| {
                let mut model = s.known[r] + dot(&s.rows[r], &self.x[at.parameters()]);
                model += (1.0 + self.drift[e]) * dot(&self.friction[e][r], friction);
                if self.ends {
                    model += dot(&ends[r], &self.x[at.ends(e)]);
                }
                model += data.effect_rows.get(e).map_or(0.0, |rows| dot(&rows[r], &self.x[at.effects()]));
                (data.gain[s.joint] * s.current[r] - model) / deviation[e][r]
            };
            (0..s.rows.len()).map(residual).collect()
        };
        data.spectra.iter().enumerate().map(of).collect()
    }

    /// Indices of the unknowns of the present fit.
    pub(crate) fn layout_of(&self, data: &HarmonicData) -> Layout {
        Layout {
            base: data.p,
            joints: data.n,
            friction_of_joint: self.shape.columns(),
            drift_count: if self.has_drift() { self.drift.len() } else { 0 },
            ended_spectra: if self.ends { data.spectra.len() } else { 0 },
            effect_columns: data.effect_columns(),
        }
    }

    /// The triangle (R of QR) of the weighted rows, linearised about the present friction and drift.
    pub(crate) fn triangle(&self, data: &HarmonicData) -> Triangle {
        let mut block = TriangleBuilder::new(self.layout_of(data).unknowns());
        self.each_equation(data, |_, row, known, y| {
            block.push(row, y - known);
        });
        block.finish()
    }

    /// Calls `take` for each weighted row, linearised about the present friction and drift, with its owner, coefficients, known
    /// torque and right-hand side.
    pub(crate) fn each_equation(&self, data: &HarmonicData, mut take: impl FnMut(Owner, &[f64], f64, f64)) {
        let at = self.layout_of(data);
        let first_drift = at.drifts().start;
        let mut row = vec![0.0; at.unknowns()];
        let mut push = |owner: Owner, row: &mut Vec<f64>, known: f64, y: f64| {
            take(owner, row, known, y);
            row.fill(0.0);
        };
        // The rows of each harmonic of a spectrum: tau + u C f = D X + (1 + u) C f' + (C f) u' + ends + effects (symbols: see
        // the module). f', u': new friction and drift.
        for (e, s) in data.spectra.iter().enumerate() {
            let gain = data.gain[s.joint];
            let of_joint = at.friction(s.joint);
            let ends = s.end_columns();
            for r in 0..s.rows.len() {
                let w = 1.0 / self.deviation[e][r];
                let c = &self.friction[e][r];
                let mut y = gain * s.current[r];
                row[at.parameters()].iter_mut().zip(&s.rows[r]).for_each(|(x, d)| *x = w * d);
                let scale = 1.0 + self.drift[e];
                row[of_joint.clone()].iter_mut().zip(c).for_each(|(x, c)| *x = w * scale * c);
                if self.has_drift() && !self.x.is_empty() {
                    let now: f64 = c.iter().zip(&self.x[of_joint.clone()]).map(|(c, f)| c * f).sum();
                    row[first_drift + e] = w * now;
                    y += self.drift[e] * now;
                }
                if self.ends {
                    row[at.ends(e)].iter_mut().zip(&ends[r]).for_each(|(x, end)| *x = w * end);
                }
                if let Some(rows) = data.effect_rows.get(e) {
                    row[at.effects()].iter_mut().zip(&rows[r]).for_each(|(x, c)| *x = w * c);
                }
                push(Owner { joint: s.joint, cluster: e }, &mut row, w * s.known[r], w * y);
            }
        }
        // The gravity rows of the sweeps have no friction columns.
        for (k, sweep) in data.sweeps.iter().enumerate() {
            for (i, d) in sweep.rows.iter().enumerate() {
                let (joint, gain) = (sweep.joint[i], data.gain[sweep.joint[i]]);
                let w = 1.0 / (gain * sweep.deviation[i]);
                row[at.parameters()].iter_mut().zip(d).for_each(|(x, d)| *x = w * d);
                let of_joint = data.effects.iter().position(|e| *e == Effect::Spring { joint });
                if let Some(place) = of_joint {
                    let first: usize = data.effects[..place].iter().map(|e| e.columns()).sum();
                    row[at.effects().start + first] = w * data.swept_springs[k][i];
                }
                let owner = Owner { joint, cluster: data.spectra.len() + k };
                push(owner, &mut row, w * sweep.known[i], w * gain * sweep.right[i]);
            }
        }
        // Each drift has one row u' / s = 0, which regularises the drift (s: standard deviation of drifts).
        if self.has_drift() {
            for (e, s) in data.spectra.iter().enumerate() {
                row[first_drift + e] = 1.0 / self.spread;
                push(Owner { joint: s.joint, cluster: e }, &mut row, 0.0, 0.0);
            }
        }
    }

    /// The equations with the gains as additional unknowns, linearised about the present gains. The last rows contain the prior
    /// knowledge of gains that are only expected.
    ///
    /// The residual of a row in currents is w k0 (I - m / k), with the weight w, the gain k, its present value k0, the current
    /// I and the torque m of the model. The column of k is the derivative w m / k0 of this residual, in which m is replaced by
    /// k0 I; m and k0 I differ only by the residual.
    pub(crate) fn gain_equations(&self, data: &HarmonicData, gains: &[Gain]) -> Vec<GainEquation> {
        let unknowns = self.x.len();
        let free: Vec<usize> = (0..gains.len()).filter(|&j| gains[j].is_unknown()).collect();
        let mut count = vec![0; data.spectra.len()];
        let mut all = Vec::new();
        self.each_equation(data, |owner, row, known, y| {
            let mut coefficients = row.to_vec();
            coefficients.extend(free.iter().map(|&j| if j == owner.joint { -y / data.gain[j] } else { 0.0 }));
            let row = count.get_mut(owner.cluster);
            // Rows that regularise drifts come after all rows of the spectra.
            let row = row.filter(|row| **row < data.spectra[owner.cluster].rows.len());
            let place = row.map(|row| (owner.cluster, std::mem::replace(row, *row + 1)));
            all.push(GainEquation { owner: Some(owner), place, coefficients, right: y - known });
        });
        for (at, &j) in free.iter().enumerate() {
            if let Gain::Expected(_, deviation) = gains[j] {
                let mut coefficients = vec![0.0; unknowns + free.len()];
                coefficients[unknowns + at] = 1.0 / deviation;
                all.push(GainEquation { owner: None, place: None, coefficients, right: 0.0 });
            }
        }
        all
    }

    /// One step for all unknowns and for the standard deviation s of the drifts. If s vanishes, the drifts are removed from the
    /// unknowns.
    pub(crate) fn solve(&mut self, data: &HarmonicData) {
        self.step(data);
        if !self.has_drift() && self.drift.iter().any(|u| *u != 0.0) {
            self.drift.fill(0.0);
            self.step(data);
        }
    }

    fn step(&mut self, data: &HarmonicData) {
        let at = self.layout_of(data);
        let triangle = self.triangle(data);
        let unknowns = triangle.columns();
        let x = triangle.solution();
        self.chi_square = triangle.squares(&x).1;
        self.rows = triangle.rows;
        self.effective = unknowns as f64 + if self.shape.stribeck.is_some() { 1.0 } else { 0.0 };
        if self.has_drift() {
            let drifts = at.drifts();
            let variances = triangle.inverse_products(drifts.clone());
            let decided: f64 = variances.iter().map(|v| 1.0 - v / self.spread.powi(2)).sum();
            self.drift.copy_from_slice(&x[drifts]);
            self.rows -= self.drift.len();
            self.effective -= self.drift.len() as f64 - decided;
            let squares: f64 = self.drift.iter().map(|u| u * u).sum();
            self.spread = (squares / decided.max(LEAST_DETERMINED_DRIFTS)).sqrt();
        }
        self.x = x;
        self.layout = at;
        self.squares = self.squares_by(data, &self.deviation);
    }
}
