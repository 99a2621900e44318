//! Errors of one estimator over many simulated experiments.
//!
//! Bias and RMSE are in Cramer-Rao sigmas, sigma_i = sigma (W'W)^-1/2_ii at noise-free states; the coverage is the
//! share of the 95 % intervals x +- 1.96 sigma that hold the truth.

/// Errors parameter by parameter, in Cramer-Rao sigmas, and how many intervals held the truth.
#[derive(Default)]
pub struct Tally {
    errors: Vec<Vec<f64>>,
    covered: usize,
    intervals: usize,
}

impl Tally {
    /// One experiment; `sigma` are the standard deviations that the estimator claims.
    pub fn add(&mut self, x: &[f64], truth: &[f64], bound: &[f64], sigma: &[f64]) {
        self.errors.push((0..truth.len()).map(|c| (x[c] - truth[c]) / bound[c]).collect());
        self.intervals += sigma.len();
        self.covered += (0..sigma.len()).filter(|&c| (x[c] - truth[c]).abs() <= 1.96 * sigma[c]).count();
    }

    /// Largest |mean error| of a parameter.
    pub fn bias(&self) -> f64 {
        let runs = self.errors.len() as f64;
        let mean = |c: usize| self.errors.iter().map(|e| e[c]).sum::<f64>() / runs;
        (0..self.errors[0].len()).map(|c| mean(c).abs()).fold(0.0, f64::max)
    }

    /// Root mean square error over experiments and parameters.
    pub fn rmse(&self) -> f64 {
        let squares: f64 = self.errors.iter().flatten().map(|e| e * e).sum();
        (squares / (self.errors.len() * self.errors[0].len()) as f64).sqrt()
    }

    /// Share of the intervals that hold the truth; NaN where there are none.
    pub fn coverage(&self) -> f64 {
        self.covered as f64 / self.intervals as f64
    }
}
