//! Fits the unknowns of a calibration by damped Gauss-Newton steps with the exact Jacobian.
//!
//! The noise of lengths and the noise of angles are estimated separately. The variance of a kind is the sum of its squared
//! residuals, divided by the number of its rows minus the sum of their leverages. Postures with large residuals first get
//! small weights. Then postures whose residuals no normal distribution explains are left out and named.
//!
//! Errors of the geometry may have a weak prior. Each error x_k then has the expected value 0 and the same standard deviation
//! s. A base parameter is y_i = x_i + sum_k beta_ik x_k, so the prior of the base parameters has the covariance s^2 (1 + beta
//! beta').
//!
//! Unknowns are the frames of base and tool, and the parameters of the chain (zeros, errors of the geometry, scales of joints,
//! compliances). The leverage of a row is the share of the fit in its prediction. An outlier is a posture that is left out.

use nalgebra::{DMatrix, DVector};

use crate::base_geometry::GeometricBase;
use crate::measurement::{Linearised, Problem, ResidualKind, Unknowns};
use crate::parameter::ParameterGroup;

/// Largest number of steps with the same weights.
const MAX_STEPS: usize = 60;
/// The steps end if the sum of squares falls by less than this fraction.
const SETTLED: f64 = 1e-9;
/// The steps of a search end if the sum of squares falls by less than this fraction.
const ROUGH: f64 = 1e-4;
/// Largest number of steps of a fit that only compares priors.
const FEW_STEPS: usize = 6;
/// A parameter is tested if this share of its squared derivative is not explained by the fitted parameters.
const OWN_SHARE: f64 = 1e-8;
/// First damping, relative to the diagonal, and the factor by which it changes.
const FIRST_DAMPING: f64 = 1e-5;
const DAMPING_FACTOR: f64 = 10.0;
/// The search ends at this damping: no step reduces the sum of squares.
const LAST_DAMPING: f64 = 1e10;
/// Number of rounds. In each round, weights and noise are computed from the residuals, and the fit is repeated.
const ROUNDS: usize = 8;
/// Postures whose residual exceeds this multiple of the noise get less weight (Cauchy's weight).
const CAUCHY: f64 = 2.5;
/// Ratio of the standard deviation of a normal distribution to its median absolute value.
const NORMAL_MEDIAN: f64 = 1.4826;
/// A posture is an outlier if its residual has a smaller chance than a normal deviate of this size.
const OUTLIER_DEVIATE: f64 = 4.5;
/// The noise is never assumed to be smaller than this value, which is the rounding error of the numbers in a table, m and rad.
const LEAST_NOISE: f64 = 1e-12;
/// Largest fraction of postures that can be outliers.
const MOST_OUTLIERS: f64 = 0.2;

/// A prior of the errors of the geometry: its precision (inverse covariance) for the fitted parameters.
#[derive(Clone, Debug)]
pub(crate) struct Prior {
    precision: DMatrix<f64>,
}

impl Prior {
    /// The prior for the parameters `active`. Zeros, frames, gears and compliances have none.
    pub(crate) fn new(problem: &Problem, base: &GeometricBase, active: &[usize], deviation: f64) -> Prior {
        let is_geometry = |k: usize| problem.parameters[k].group() == ParameterGroup::Geometry;
        let held: Vec<usize> = active.iter().copied().filter(|&k| is_geometry(k)).collect();
        let grouped: Vec<_> = base.grouped.iter().filter(|(k, _)| is_geometry(*k)).collect();
        let beta = DMatrix::from_fn(held.len(), grouped.len(), |i, g| {
            grouped[g].1.iter().find(|(k, _)| *k == held[i]).map_or(0.0, |(_, x)| *x)
        });
        let covariance = DMatrix::identity(held.len(), held.len()) + &beta * beta.transpose();
        let inverse = covariance.cholesky().map_or_else(|| DMatrix::identity(held.len(), held.len()), |c| c.inverse());
        let place = |k: usize| held.iter().position(|h| *h == active[k]);
        let precision = DMatrix::from_fn(active.len(), active.len(), |i, j| match (place(i), place(j)) {
            (Some(i), Some(j)) => inverse[(i, j)] / (deviation * deviation),
            _ => 0.0,
        });
        Prior { precision }
    }

    /// Whether a wider prior has a larger marginal likelihood at a fit with this prior. y: the n fitted parameters that have a
    /// prior; C: their covariance; P: precision of the prior; s: its standard deviation. The derivative of the logarithm of
    /// the marginal likelihood by log s is y' P y + tr(P C) - n.
    pub(crate) fn is_narrow(&self, problem: &Problem, fit: &Fit) -> bool {
        let frames = problem.frames();
        let value = |k: &usize| k.checked_sub(frames).map_or(0.0, |k| fit.unknowns.chain[k]);
        let values = DVector::from_iterator(fit.active.len(), fit.active.iter().map(value));
        let count = self.precision.diagonal().iter().filter(|d| **d > 0.0).count();
        let sum = values.dot(&(&self.precision * &values)) + (&self.precision * &fit.covariance).trace();
        sum > count as f64
    }
}

/// Standard deviation of the noise of lengths, m, and of angles, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of lengths, m.
    pub length: f64,
    /// Standard deviation of angles, rad.
    pub angle: f64,
}

impl Noise {
    fn of(&self, kind: ResidualKind) -> f64 {
        if kind == ResidualKind::Length { self.length } else { self.angle }
    }
}

/// The result of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The fitted unknowns.
    pub unknowns: Unknowns,
    /// The fitted parameters, as indices of [`Problem::parameters`].
    pub active: Vec<usize>,
    /// Covariance of the fitted parameters.
    pub covariance: DMatrix<f64>,
    /// Noise of the measurements.
    pub noise: Noise,
    /// Degrees of freedom.
    pub freedom: f64,
    /// For each posture, whether it is used; the others are outliers.
    pub used: Vec<bool>,
    /// Weighted sum of squares of the used rows and of the prior.
    pub squares: f64,
}

/// Weights of a fit: the noise, and a weight for each posture.
struct Weights {
    noise: Noise,
    posture: Vec<f64>,
}

impl Weights {
    fn of(&self, of: &Linearised, r: usize) -> f64 {
        self.posture[of.posture[r]].sqrt() / self.noise.of(of.kinds[r])
    }
}

/// A fit in progress.
pub(crate) struct Fitter<'a> {
    /// The postures.
    pub problem: &'a Problem,
    /// The parameters that are fitted.
    pub active: &'a [usize],
    /// The prior of the errors of the geometry.
    pub prior: Option<&'a Prior>,
    /// The postures that are used.
    pub rows: &'a [usize],
}

impl Fitter<'_> {
    /// Fits from a start. Postures with large residuals get less weight, and outliers are left out.
    pub(crate) fn fit(&self, start: &Unknowns, noise: Noise) -> Fit {
        let count = self.problem.postures.len();
        let mut weights = Weights { noise, posture: vec![1.0; count] };
        let mut at = start.clone();
        for _ in 0..ROUNDS {
            at = self.settled(&at, &weights, MAX_STEPS, SETTLED).0;
            let rows = self.problem.linearised_of(&at, self.rows);
            let next = median_noise(&rows);
            let sizes = sizes(&rows, &next, count);
            let is_settled = (next.length / weights.noise.length - 1.0).abs() < 1e-2;
            weights = Weights { noise: next, posture: sizes.iter().map(|size| cauchy(*size)).collect() };
            if is_settled {
                break;
            }
        }
        self.without_outliers(at, weights)
    }

    /// Leaves outliers out and fits the others by least squares, until both agree.
    fn without_outliers(&self, mut at: Unknowns, mut weights: Weights) -> Fit {
        let count = self.problem.postures.len();
        let mut used = vec![true; count];
        for _ in 0..ROUNDS {
            let rows = self.problem.linearised_of(&at, self.rows);
            let next = self.outliers(&rows, &weights.noise, count);
            weights.posture = next.iter().map(|used| f64::from(u8::from(*used))).collect();
            at = self.settled(&at, &weights, MAX_STEPS, SETTLED).0;
            // The noise follows from the leverages at the solution; two rounds settle it.
            for _ in 0..2 {
                weights.noise = self.noise(&self.problem.linearised_of(&at, self.rows), &weights);
                at = self.settled(&at, &weights, MAX_STEPS, SETTLED).0;
            }
            let is_settled = next == used;
            used = next;
            if is_settled {
                break;
            }
        }
        self.problem.chain.within_half_a_turn(&mut at.chain);
        let rows = self.problem.linearised_of(&at, self.rows);
        let (_, normal, _) = self.normal(&rows, &at, &weights);
        let covariance = inverse(&normal);
        let live = rows.posture.iter().filter(|r| used[**r]).count();
        let freedom = (live as f64 - self.trace(&rows, &weights, &covariance)).max(1.0);
        let squares = self.squares(&at, &weights);
        Fit { unknowns: at, active: self.active.to_vec(), covariance, noise: weights.noise, freedom, used, squares }
    }

    /// For each posture, whether it is used: a normal distribution must explain its normalised residual.
    fn outliers(&self, rows: &Linearised, noise: &Noise, count: usize) -> Vec<bool> {
        let sizes = sizes(rows, noise, count);
        let mut each = vec![0usize; count];
        rows.posture.iter().for_each(|r| each[*r] += 1);
        let is_used = |r: usize| {
            // The quantile of chi squared by the cube root of Wilson and Hilferty.
            let m = each[r].max(1) as f64;
            let limit = (1.0 - 2.0 / (9.0 * m) + OUTLIER_DEVIATE * (2.0 / (9.0 * m)).sqrt()).powi(3);
            sizes[r] * sizes[r] <= limit
        };
        let used: Vec<bool> = (0..count).map(is_used).collect();
        let left_out = self.rows.iter().filter(|r| !used[**r]).count();
        if left_out as f64 > MOST_OUTLIERS * self.rows.len() as f64 { vec![true; count] } else { used }
    }

    /// Damped Gauss-Newton steps until the sum of squares settles; also returns this sum.
    fn settled(&self, start: &Unknowns, weights: &Weights, steps: usize, least: f64) -> (Unknowns, f64) {
        let (mut at, mut damping) = (start.clone(), FIRST_DAMPING);
        let mut squares = self.squares(&at, weights);
        for _ in 0..steps {
            let rows = self.problem.linearised_of(&at, self.rows);
            let (gradient, normal, diagonal) = self.normal(&rows, &at, weights);
            let before = squares;
            let mut is_lower = false;
            while damping < LAST_DAMPING {
                let mut damped = normal.clone();
                diagonal.iter().enumerate().for_each(|(k, d)| damped[(k, k)] += damping * d);
                let step = damped.cholesky().map(|c| c.solve(&gradient));
                let moved = step.map(|step| self.moved(&at, step.as_slice()));
                let next = moved.map(|moved| (self.squares(&moved, weights), moved)).filter(|next| next.0 < squares);
                if let Some((less, moved)) = next {
                    (squares, at, is_lower) = (less, moved, true);
                    damping /= DAMPING_FACTOR;
                    break;
                }
                damping *= DAMPING_FACTOR;
            }
            if !is_lower || before - squares <= least * before {
                break;
            }
        }
        (at, squares)
    }

    /// A short search with equal weights, for the choice of a start. Also returns the weighted sum of squares.
    pub(crate) fn search(&self, start: &Unknowns, noise: Noise, steps: usize) -> (Unknowns, f64) {
        let mut weights = Weights { noise, posture: vec![1.0; self.problem.postures.len()] };
        let (at, _) = self.settled(start, &weights, steps, ROUGH);
        // Different starts are compared by a sum in which an outlier has little weight.
        let rows = self.problem.linearised_of(&at, self.rows);
        let sizes = sizes(&rows, &noise, weights.posture.len());
        weights.posture = sizes.iter().map(|size| cauchy(*size)).collect();
        let robust = self.rows.iter().map(|r| (sizes[*r] / CAUCHY).powi(2).ln_1p()).sum();
        (at, robust)
    }

    /// A short fit for the comparison of priors. The noise is given, and the weights of the postures are computed only once.
    pub(crate) fn quick(&self, start: &Unknowns, noise: Noise) -> Unknowns {
        let rows = self.problem.linearised_of(start, self.rows);
        let sizes = sizes(&rows, &noise, self.problem.postures.len());
        let weights = Weights { noise, posture: sizes.iter().map(|size| cauchy(*size)).collect() };
        self.settled(start, &weights, FEW_STEPS, ROUGH).0
    }

    /// Estimate and standard deviation of one more parameter, at the end of a fit; `None` if the fitted parameters explain its
    /// derivative.
    pub(crate) fn one_more(&self, fit: &Fit, parameter: usize) -> Option<(f64, f64)> {
        let rows = self.problem.linearised_of(&fit.unknowns, self.rows);
        let posture = fit.used.iter().map(|used| f64::from(u8::from(*used))).collect();
        let weights = Weights { noise: fit.noise, posture };
        let (jacobian, residual) = self.weighted(&rows, &weights);
        let column = DVector::from_fn(residual.len(), |r, _| rows.jacobian[(r, parameter)] * weights.of(&rows, r));
        let apart = &column - &jacobian * (&fit.covariance * jacobian.tr_mul(&column));
        let information = column.dot(&apart);
        let is_apart = information > OWN_SHARE * column.norm_squared();
        is_apart.then(|| (apart.dot(&residual) / information, 1.0 / information.sqrt()))
    }

    fn moved(&self, at: &Unknowns, step: &[f64]) -> Unknowns {
        let mut full = vec![0.0; self.problem.parameters.len()];
        self.active.iter().zip(step).for_each(|(k, x)| full[*k] = *x);
        self.problem.moved(at, &full)
    }

    /// Values of the fitted parameters, for the prior. Parameters of frames count as zero, because frames have no prior.
    fn values(&self, at: &Unknowns) -> DVector<f64> {
        let frames = self.problem.frames();
        let value = |k: &usize| k.checked_sub(frames).map_or(0.0, |k| at.chain[k]);
        DVector::from_iterator(self.active.len(), self.active.iter().map(value))
    }

    /// Right side, matrix and diagonal of the normal equations.
    fn normal(&self, rows: &Linearised, at: &Unknowns, weights: &Weights) -> (DVector<f64>, DMatrix<f64>, Vec<f64>) {
        let (jacobian, residual) = self.weighted(rows, weights);
        let (mut normal, mut gradient) = (jacobian.tr_mul(&jacobian), jacobian.tr_mul(&residual));
        if let Some(prior) = self.prior {
            gradient -= &prior.precision * self.values(at);
            normal += &prior.precision;
        }
        let diagonal = normal.diagonal().iter().map(|d| d.max(f64::MIN_POSITIVE)).collect();
        (gradient, normal, diagonal)
    }

    fn weighted(&self, rows: &Linearised, weights: &Weights) -> (DMatrix<f64>, DVector<f64>) {
        let mut jacobian = rows.jacobian.select_columns(self.active);
        let mut residual = rows.residual.clone();
        for (r, mut row) in jacobian.row_iter_mut().enumerate() {
            let weight = weights.of(rows, r);
            row *= weight;
            residual[r] *= weight;
        }
        (jacobian, residual)
    }

    fn squares(&self, at: &Unknowns, weights: &Weights) -> f64 {
        let rows = self.problem.residuals_of(at, self.rows);
        let of_rows: f64 =
            rows.iter().map(|(x, kind, r)| weights.posture[*r] * (x / weights.noise.of(*kind)).powi(2)).sum();
        let of_prior = self.prior.map_or(0.0, |prior| {
            let values = self.values(at);
            values.dot(&(&prior.precision * &values))
        });
        of_rows + of_prior
    }

    /// Number of parameters that the used rows determine: the sum of their leverages.
    fn trace(&self, rows: &Linearised, weights: &Weights, covariance: &DMatrix<f64>) -> f64 {
        let (jacobian, _) = self.weighted(rows, weights);
        jacobian.row_iter().map(|row| (row * covariance * row.transpose())[(0, 0)]).sum()
    }

    /// Noise of each kind: squares of the residuals over the number of rows minus their leverages.
    fn noise(&self, rows: &Linearised, weights: &Weights) -> Noise {
        let at_zero = DMatrix::zeros(self.active.len(), self.active.len());
        let (jacobian, _) = self.weighted(rows, weights);
        let precision = self.prior.map_or(at_zero, |prior| prior.precision.clone());
        let covariance = inverse(&(jacobian.tr_mul(&jacobian) + precision));
        let of = |kind: ResidualKind| {
            let (mut squares, mut freedom) = (0.0, 0.0);
            for (r, row) in jacobian.row_iter().enumerate() {
                if rows.kinds[r] == kind && weights.posture[rows.posture[r]] > 0.0 {
                    squares += rows.residual[r].powi(2);
                    freedom += 1.0 - (row * &covariance * row.transpose())[(0, 0)];
                }
            }
            if freedom > 0.5 { (squares / freedom).sqrt().max(LEAST_NOISE) } else { weights.noise.of(kind) }
        };
        Noise { length: of(ResidualKind::Length), angle: of(ResidualKind::Angle) }
    }
}

/// The inverse of a symmetric matrix, computed with a unit diagonal. A matrix that is not positive definite gets its
/// pseudo-inverse.
pub(crate) fn inverse(normal: &DMatrix<f64>) -> DMatrix<f64> {
    let scale: Vec<f64> = normal.diagonal().iter().map(|d| 1.0 / d.max(f64::MIN_POSITIVE).sqrt()).collect();
    let scaled = DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, k| normal[(i, k)] * scale[i] * scale[k]);
    let inverse = match scaled.clone().cholesky() {
        Some(c) => c.inverse(),
        None => scaled.pseudo_inverse(f64::EPSILON).unwrap_or_else(|_| DMatrix::zeros(normal.nrows(), normal.ncols())),
    };
    DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, k| inverse[(i, k)] * scale[i] * scale[k])
}

/// Noise of each kind from the median of the absolute residuals, which outliers hardly change.
fn median_noise(rows: &Linearised) -> Noise {
    let of = |kind: ResidualKind| {
        let all = rows.residual.iter().zip(&rows.kinds).filter(|(_, k)| **k == kind);
        let mut all: Vec<f64> = all.map(|(x, _)| x.abs()).collect();
        let middle = all.len() / 2;
        if all.is_empty() {
            1.0
        } else {
            (NORMAL_MEDIAN * *all.select_nth_unstable_by(middle, f64::total_cmp).1).max(LEAST_NOISE)
        }
    };
    Noise { length: of(ResidualKind::Length), angle: of(ResidualKind::Angle) }
}

/// For each posture, the root mean square of its residuals relative to the noise.
fn sizes(rows: &Linearised, noise: &Noise, count: usize) -> Vec<f64> {
    let (mut squares, mut each) = (vec![0.0; count], vec![0.0; count]);
    for (r, x) in rows.residual.iter().enumerate() {
        squares[rows.posture[r]] += (x / noise.of(rows.kinds[r])).powi(2);
        each[rows.posture[r]] += 1.0;
    }
    squares.iter().zip(&each).map(|(s, n): (&f64, &f64)| (s / n.max(1.0)).sqrt()).collect()
}

fn cauchy(size: f64) -> f64 {
    1.0 / (1.0 + (size / CAUCHY).powi(2))
}
