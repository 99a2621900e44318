//! Collects the errors of one estimator over many simulated experiments.
//!
//! Bias and RMSE are divided by the Cramer-Rao bound sigma_i: square root of the i-th diagonal entry of sigma^2 (W'W)^-1. W:
//! observation matrix at the noise-free states, sigma: torque noise. The coverage is the share of the 95 % intervals x +- 1.96
//! sigma that contain the true value.

/// Errors of each parameter, divided by its Cramer-Rao bound, and the number of intervals that contain the true value.
#[derive(Default)]
pub struct Tally {
    errors: Vec<Vec<f64>>,
    covered: usize,
    intervals: usize,
}

impl Tally {
    /// Adds one experiment. `bound`: Cramer-Rao bounds. `sigma`: standard deviations that the estimator states.
    pub fn add(&mut self, x: &[f64], truth: &[f64], bound: &[f64], sigma: &[f64]) {
        self.errors.push((0..truth.len()).map(|c| (x[c] - truth[c]) / bound[c]).collect());
        self.intervals += sigma.len();
        self.covered += (0..sigma.len()).filter(|&c| (x[c] - truth[c]).abs() <= 1.96 * sigma[c]).count();
    }

    /// The largest |mean error| of a parameter, divided by its Cramer-Rao bound.
    pub fn bias(&self) -> f64 {
        let runs = self.errors.len() as f64;
        let mean = |c: usize| self.errors.iter().map(|e| e[c]).sum::<f64>() / runs;
        (0..self.errors[0].len()).map(|c| mean(c).abs()).fold(0.0, f64::max)
    }

    /// Rms error over experiments and parameters, divided by the Cramer-Rao bounds.
    pub fn rmse(&self) -> f64 {
        let squares: f64 = self.errors.iter().flatten().map(|e| e * e).sum();
        (squares / (self.errors.len() * self.errors[0].len()) as f64).sqrt()
    }

    /// Share of the intervals that contain the true value; NaN if there are none.
    pub fn coverage(&self) -> f64 {
        self.covered as f64 / self.intervals as f64
    }
}
