//! Estimators that use simulation: instrumental variables (IDIM-IV), and direct and inverse dynamic identification (DIDIM).
//!
//! Both estimators simulate the robot in each iteration, with the present parameters X, and with the controller and the
//! reference of the experiment. The simulated states have no measurement noise.
//! - IDIM-IV: X = (Z' W)^-1 Z' Y, Z: regressor at the simulated states, W: at the measured states, Y: torques. X is unbiased
//!   although W is noisy, if the filter does not remove parts of the motion [Janot, Vandanjon, Gautier 2014].
//! - DIDIM: X = argmin |Y - W_s X|, W_s: regressor at the simulated states. DIDIM needs only the measured torques
//!   [Gautier, Janot, Vandanjon 2013].
//!
//! For white noise, the covariance matrix is C = s^2 (Z'W)^-1 Z'Z (W'Z)^-1, s^2: variance of the residuals. For correlated noise,
//! the scores Z_r' e_r (Z_r, e_r: rows of sample r in Z and in the residuals) are summed over a span of samples
//! (`correlated_deviation`), because filtering makes neighbouring samples correlated.
//!
//! The rows have the joint weights of weighted least squares on the measured states. The caller provides the simulator, with its
//! integrator and its controller. The simulator must return states at the samples of the measured record.

use linear_model::linear_model::Model;
use linear_model::states::States;
use logs::Error;
use nalgebra::{DMatrix, DVector};

use crate::correlated_deviation::{OverlappingSums, correlation, span};
use identification::estimators::weighted::{Weights, fit};
use identification::rows::observation::Observation;

/// Simulates the experiment with the parameters `x` of the model, including friction.
pub trait Simulator {
    /// The simulated states at the samples of the measured record.
    fn simulate(&self, x: &[f64]) -> Result<States, Error>;
}

/// The two estimators that use simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClosedLoop {
    /// IDIM-IV: the simulated states are the instruments.
    InstrumentalVariables,
    /// DIDIM: the columns of W are computed from the simulated states.
    DirectAndInverse,
}

/// The solution, and statistics of the iterations.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// Estimated parameters, in the order of the model.
    pub x: Vec<f64>,
    /// Standard deviations of the parameters for white torque noise.
    pub sigma: Vec<f64>,
    /// Standard deviations of the parameters for residuals that are correlated over time.
    pub robust: Vec<f64>,
    /// Number of simulations of the robot.
    pub iterations: usize,
    /// Relative change of the parameter vector in the last iteration.
    pub change: f64,
    /// Whether the parameters converged within the largest number of iterations.
    pub converged: bool,
}

/// Largest number of iterations.
const MAX_ITERATIONS: usize = 20;
/// The parameters have converged if the relative change of the parameter vector is below this value.
const SETTLED_RELATIVE_CHANGE: f64 = 1e-6;

/// Iterates from `start` until the parameters converge.
///
/// Fails if the simulator fails or gives states of another shape, or if the simulated motion does not determine X.
pub fn simulated(
    model: &Model,
    measured: &States,
    simulator: &dyn Simulator,
    start: &[f64],
    method: ClosedLoop,
) -> Result<Simulated, Error> {
    // The rows have the weights of weighted least squares on the measured states.
    let observation = Observation::of(model, measured, 1);
    let (_, weights) = fit(&observation.joints(|_| true), Weights::Joint);
    let mut x = start.to_vec();
    let (sigma, robust) = (Vec::new(), Vec::new());
    let mut out = Simulated { x: x.clone(), sigma, robust, iterations: 0, change: f64::INFINITY, converged: false };
    for iteration in 1..=MAX_ITERATIONS {
        let mut instruments = simulator.simulate(&x)?;
        if instruments.len() != measured.len() || instruments.n != measured.n {
            let message = format!(
                "the simulation has {} samples of {} joints, the record {} of {}",
                instruments.len(),
                instruments.n,
                measured.len(),
                measured.n
            );
            return Err(Error::new(message));
        }
        // Z comes from simulated states; W from measured states for IV, and from simulated states for DIDIM.
        let regressors = match method {
            ClosedLoop::InstrumentalVariables => measured,
            ClosedLoop::DirectAndInverse => {
                instruments.tau.clone_from(&measured.tau);
                instruments.used.clone_from(&measured.used);
                &instruments
            }
        };
        let round = Round { model, instruments: &instruments, regressors, measured, weights: &weights };
        let (normal, rhs, gram, rows, squares) = round.products();
        let inverse = scaled_inverse(&normal).ok_or_else(|| {
            Error::new("the simulated motion does not identify all parameters: excite more, or fix them")
        })?;
        // X = (Z' W)^-1 Z' Y, and C = s^2 (Z'W)^-1 Z'Z (W'Z)^-1.
        let next = &inverse * &rhs;
        let fitted = round.residual_variance(&next, rows, squares);
        let covariance = fitted * &inverse * &gram * inverse.transpose();
        out.sigma = covariance.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect();
        // The relative change |X_next - X| / |X_next|; the iteration ends if it is small.
        let step = next.iter().zip(&x).map(|(a, b)| a - b);
        let size: f64 = next.iter().map(|v| v * v).sum::<f64>().sqrt();
        out.change = step.map(|d| d * d).sum::<f64>().sqrt() / size.max(f64::MIN_POSITIVE);
        x = next.iter().copied().collect();
        (out.x, out.iterations) = (x.clone(), iteration);
        out.converged = out.change < SETTLED_RELATIVE_CHANGE;
        if out.converged || iteration == MAX_ITERATIONS {
            out.robust = round.robust_sigma(&x, &inverse);
            break;
        }
    }
    Ok(out)
}

type Products = (DMatrix<f64>, DVector<f64>, DMatrix<f64>, usize, f64);

/// The states and weights of one iteration.
struct Round<'a> {
    model: &'a Model<'a>,
    /// The states from which Z is computed.
    instruments: &'a States,
    /// The states from which W is computed.
    regressors: &'a States,
    measured: &'a States,
    /// Weights of the rows of Z and W, one per joint.
    weights: &'a [f64],
}

impl Round<'_> {
    /// Products of weighted rows: Z'W, Z'Y, Z'Z, the number of rows, and |Y|^2. Z, W: regressors at the two kinds of states, Y:
    /// measured torques.
    fn products(&self) -> Products {
        let Round { model, measured, weights, .. } = *self;
        let (n, p) = (model.n(), model.p());
        let (mut normal, mut gram, mut rhs) = (DMatrix::zeros(p, p), DMatrix::zeros(p, p), DVector::zeros(p));
        let (mut rows, mut squares) = (0, 0.0);
        self.paired(|r, zr, wr| {
            for j in (0..n).filter(|&j| measured.used[r * n + j]) {
                let v = weights[j] * weights[j];
                let tau = measured.tau[r * n + j];
                let zv = nalgebra::DVectorView::from_slice(&zr[j * p..(j + 1) * p], p);
                let wv = nalgebra::DVectorView::from_slice(&wr[j * p..(j + 1) * p], p);
                normal.ger(v, &zv, &wv, 1.0);
                gram.ger(v, &zv, &zv, 1.0);
                rhs.axpy(v * tau, &zv, 1.0);
                rows += 1;
                squares += v * tau * tau;
            }
        });
        (normal, rhs, gram, rows, squares)
    }

    /// Passes the n x p rows of Z and W at each sample to `take`.
    fn paired(&self, mut take: impl FnMut(usize, &[f64], &[f64])) {
        let Round { model, instruments: z, regressors: w, .. } = *self;
        let mut wr = vec![0.0; model.n() * model.p()];
        model.rows(z, 0..z.len(), |r, zr| {
            model.rows(w, r..r + 1, |_, rows| wr.copy_from_slice(rows));
            take(r, zr, &wr);
        });
    }

    /// Standard deviations from sums of the scores (Z'W)^-1 Z_r' e_r of the samples r. e_r: residuals. The sums are over as many
    /// neighbouring samples as the correlation of the residuals requires.
    fn robust_sigma(&self, x: &[f64], inverse: &DMatrix<f64>) -> Vec<f64> {
        let Round { model, regressors, measured, weights, .. } = *self;
        let (n, p) = (model.n(), model.p());
        let mut sums = OverlappingSums::new(p, span(correlation(model, regressors, x), measured.len()));
        self.paired(|r, zr, wr| {
            let mut g = DVector::zeros(p);
            for j in (0..n).filter(|&j| measured.used[r * n + j]) {
                let fit: f64 = wr[j * p..(j + 1) * p].iter().zip(x).map(|(a, b)| a * b).sum();
                let e = weights[j] * weights[j] * (measured.tau[r * n + j] - fit);
                g.axpy(e, &nalgebra::DVectorView::from_slice(&zr[j * p..(j + 1) * p], p), 1.0);
            }
            sums.add((inverse * g).as_slice());
        });
        sums.variance().into_iter().map(f64::sqrt).collect()
    }

    fn residual_variance(&self, x: &DVector<f64>, rows: usize, squares: f64) -> f64 {
        let mut states = self.regressors.clone();
        states.tau.clone_from(&self.measured.tau);
        states.used.clone_from(&self.measured.used);
        let mut sum = 0.0;
        self.model.residuals(&states, x.as_slice(), |_, j, e| sum += (self.weights[j] * e).powi(2));
        sum.min(squares) / rows.saturating_sub(self.model.p()).max(1) as f64
    }
}

/// The inverse, computed with scaled rows and columns. `None` if the matrix is singular.
fn scaled_inverse(m: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let d = m.diagonal().map(|x| if x != 0.0 { 1.0 / x.abs().sqrt() } else { 1.0 });
    let n = m.nrows();
    let scaled = DMatrix::from_fn(n, n, |i, j| m[(i, j)] * d[i] * d[j]);
    let inverse = scaled.try_inverse()?;
    let inverse = DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] * d[i] * d[j]);
    inverse.iter().all(|x| x.is_finite()).then_some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::{Loop, Pendulum};
    use identification::signals::differences::Differences;
    use random::Random;

    /// A pendulum, its control loop, and the states simulated with the true parameters. The positions have noise and are
    /// differentiated without a filter.
    fn experiment(noise: f64, seed: u64) -> (Pendulum, Loop, States) {
        let arm = Pendulum::new();
        let control = Loop { samples: 1500 };
        let mut states = control.simulate(&arm.truth).unwrap();
        let mut random = Random::new(seed);
        states.q.iter_mut().for_each(|q| *q += noise * random.normal());
        states.dq = Differences::new(&states.t).of(&states.q);
        states.ddq = Differences::new(&states.t).of(&states.dq);
        states.tau.iter_mut().for_each(|t| *t += 0.05 * random.normal());
        (arm, control, states)
    }

    #[test]
    fn both_find_the_truth_where_least_squares_does_not() {
        let (arm, control, states) = experiment(3e-3, 31);
        let model = Model::new(&arm, &[], &[]);
        let (ls, _) = fit(&Observation::of(&model, &states, 1).joints(|_| true), Weights::Joint);
        // Accelerations from noisy positions make the least squares estimate of the inertia far too small.
        assert!((ls.x[0] - arm.truth[0]).abs() > 0.2 * arm.truth[0], "{:?}", ls.x);
        for method in [ClosedLoop::InstrumentalVariables, ClosedLoop::DirectAndInverse] {
            let start = [0.36, 0.7, -0.05];
            let found = simulated(&model, &states, &control, &start, method).unwrap();
            assert!(found.converged, "{method:?}: {found:?}");
            for c in 0..3 {
                let error = (found.x[c] - arm.truth[c]) / found.sigma[c];
                assert!(error.abs() < 4.0, "{method:?} {c}: {found:?}");
            }
        }
    }

    /// Without noise, and with initial parameters that are 20 % too large, DIDIM converges within a few iterations, as the
    /// literature reports.
    #[test]
    fn didim_converges_fast() {
        let (arm, control, states) = experiment(0.0, 32);
        let model = Model::new(&arm, &[], &[]);
        let start: Vec<f64> = arm.truth.iter().map(|x| 1.2 * x).collect();
        let found = simulated(&model, &states, &control, &start, ClosedLoop::DirectAndInverse).unwrap();
        assert!(found.iterations <= 6, "{found:?}");
        assert!((found.x[0] - arm.truth[0]).abs() < 0.02 * arm.truth[0], "{found:?}");
    }

    /// Errors of the estimates from 40 simulated records with random noise, in units of the Cramer-Rao standard deviation.
    /// Noisy positions are differentiated without a filter.
    #[test]
    fn bad_filters_are_forgiven() {
        const NOISE: f64 = 0.1;
        let arm = Pendulum::new();
        let model = Model::new(&arm, &[], &[]);
        let control = Loop { samples: 400 };
        let clean = control.simulate(&arm.truth).unwrap();
        let solved = |states: &States, weights| fit(&Observation::of(&model, states, 1).joints(|_| true), weights).0;
        let bound = solved(&clean, Weights::None).inverse.diagonal().map(|v| NOISE * v.sqrt());
        let mut random = Random::new(73);
        let mut errors: [Vec<[f64; 3]>; 3] = Default::default();
        for _ in 0..40 {
            let mut states = clean.clone();
            states.q.iter_mut().for_each(|q| *q += 1e-3 * random.normal());
            states.dq = Differences::new(&states.t).of(&states.q);
            states.ddq = Differences::new(&states.t).of(&states.dq);
            states.tau.iter_mut().for_each(|t| *t += NOISE * random.normal());
            let start = arm.truth.map(|x| 1.2 * x);
            let by = |method| simulated(&model, &states, &control, &start, method).unwrap().x;
            let found = [
                solved(&states, Weights::Joint).x,
                by(ClosedLoop::InstrumentalVariables),
                by(ClosedLoop::DirectAndInverse),
            ];
            for (errors, x) in errors.iter_mut().zip(found) {
                errors.push([0, 1, 2].map(|c| (x[c] - arm.truth[c]) / bound[c]));
            }
        }
        let mean = |e: &[[f64; 3]], c: usize| e.iter().map(|e| e[c]).sum::<f64>() / e.len() as f64;
        let bias = |e: &[[f64; 3]]| (0..3).map(|c| mean(e, c).abs()).fold(0.0, f64::max);
        let rmse = |e: &[[f64; 3]]| (e.iter().flatten().map(|e| e * e).sum::<f64>() / (3 * e.len()) as f64).sqrt();
        let [ls, iv, didim] = &errors;
        assert!(bias(ls) > 5.0, "least squares is biased: {}", bias(ls));
        assert!(bias(iv) < 0.2 * bias(ls) && bias(didim) < 0.2 * bias(ls), "{} {}", bias(iv), bias(didim));
        assert!(rmse(didim) < 2.0, "DIDIM is near the bound: {}", rmse(didim));
    }

    #[test]
    fn a_simulation_of_another_length_is_refused() {
        let (arm, _, states) = experiment(0.0, 33);
        let model = Model::new(&arm, &[], &[]);
        let short = Loop { samples: 10 };
        let message = simulated(&model, &states, &short, &arm.truth, ClosedLoop::DirectAndInverse).unwrap_err();
        assert!(message.to_string().contains("10 samples of 1 joints"), "{message}");
    }
}
