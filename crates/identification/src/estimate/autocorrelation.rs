//! Autocorrelation of the residual of each joint. A long autocorrelation time shows that the residual is not only noise.
//!
//! For joint j with residuals e_r (row r) and lag l in samples, over all pairs of used rows: rho_j(l) = mean(e_r e_(r-l)) /
//! mean(e_r^2). The autocorrelation time (memory), s, is the area below rho_j up to its first zero.
//!
//! White noise after the zero-phase low-pass of order four with cut-off f_c, Hz, has the power density (1 + (f/f_c)^8)^-2,
//! and therefore a memory of 0.320/f_c. (For other orders of the filter the constant differs by a tenth.) A much longer
//! memory shows that the model lacks an effect.
//!
//! With robust weights w of the rows, e is sqrt(w) times the residual, N m (N); rows of weight zero are not used. Standard
//! deviations for correlated residuals are computed in `estimators::replicate_deviation`.

use linear_model::linear_model::{Model, ResidualGroup};
use linear_model::states::States;
use numerics::fourier::self_products;

use crate::estimate::identified::INTERVAL;
use crate::estimators::huber::{Robust, row_factor};
use crate::rows::residual_sums::ResidualSum;

/// Largest lag of the autocorrelation, samples.
const LARGEST_LAG_SAMPLES: usize = 200;

/// The autocorrelation at a lag is used if the lag has at least 1/4 of the row pairs that lag 0 has.
const LEAST_PAIRS_DIVISOR: usize = 4;

/// Autocorrelation time of white noise after a low-pass of order four, times the cut-off frequency of this low-pass.
pub const NOISE_MEMORY_PERIODS: f64 = 0.320;

/// Autocorrelation (-1 to 1) at lag `t`, s, of white noise after the zero-phase low-pass of order four with this cut-off, Hz.
pub fn filtered_noise(cutoff: f64, t: f64) -> f64 {
    const FREQUENCY_STEPS: usize = 200;
    let (mut whole, mut turned) = (0.0, 0.0);
    for i in 0..FREQUENCY_STEPS {
        // f: frequency divided by the cut-off. The power density is negligible beyond f = 2.
        let f = 2.0 * (i as f64 + 0.5) / FREQUENCY_STEPS as f64;
        let density = (1.0 + f.powi(8)).powi(-2);
        whole += density;
        turned += density * (std::f64::consts::TAU * f * cutoff * t).cos();
    }
    turned / whole
}

/// Sums of products e_r e_(r-lag) of the residuals e_r of one joint (r: row), one sum per lag.
#[derive(Clone, Debug)]
struct Products {
    /// The sum of products at each lag 0, 1, .. samples.
    sums: Vec<f64>,
    /// Number of row pairs in each sum.
    pairs: Vec<usize>,
}

/// The autocorrelation of the residuals, one per joint.
#[derive(Clone, Debug)]
pub struct Autocorrelation {
    joints: Vec<Products>,
    /// Time between successive rows of a record, s.
    period: f64,
    /// The residuals of the current record, one series per joint, N m (N); NaN if a row is not used.
    record: Vec<Vec<f64>>,
    robust: Option<Robust>,
}

impl Autocorrelation {
    /// Creates empty sums for this number of joints. `robust`: robust weights of the rows; `None` if all rows have equal
    /// weight.
    pub fn new(joints: usize, robust: Option<Robust>) -> Autocorrelation {
        let none = Products { sums: vec![0.0; LARGEST_LAG_SAMPLES + 1], pairs: vec![0; LARGEST_LAG_SAMPLES + 1] };
        Autocorrelation { joints: vec![none; joints], period: 0.0, record: vec![Vec::new(); joints], robust }
    }

    /// Adds the residuals of a record: one series per joint, N m (N), with a sample every `period` seconds. NaN marks a row
    /// that is not used.
    pub(crate) fn add_record(&mut self, residuals: &[Vec<f64>], period: f64) {
        self.period = period;
        for (products, e) in self.joints.iter_mut().zip(residuals) {
            let lags = LARGEST_LAG_SAMPLES.min(e.len().saturating_sub(1));
            if e.iter().all(|e| !e.is_nan()) {
                for (lag, sum) in self_products(e, lags).iter().enumerate() {
                    products.sums[lag] += sum;
                    products.pairs[lag] += e.len() - lag;
                }
                continue;
            }
            let counting: Vec<f64> = e.iter().map(|e| f64::from(u8::from(!e.is_nan()))).collect();
            let of_rows = self_products(&counting, lags);
            let of_residuals =
                self_products(&e.iter().map(|e| if e.is_nan() { 0.0 } else { *e }).collect::<Vec<_>>(), lags);
            for (lag, (sum, pairs)) in of_residuals.iter().zip(&of_rows).enumerate() {
                products.sums[lag] += sum;
                products.pairs[lag] += pairs.round() as usize;
            }
        }
    }

    /// The autocorrelation rho of the residual of joint j, as pairs (lag in s, rho) at lags of 0, 1, .. samples. Empty if the
    /// residual is zero or absent.
    pub fn of_joint(&self, j: usize) -> Vec<(f64, f64)> {
        let products = &self.joints[j];
        let mean = |lag: usize| products.sums[lag] / products.pairs[lag].max(1) as f64;
        // With too few row pairs, the mean is too uncertain.
        let enough = |lag: &usize| products.pairs[*lag] >= products.pairs[0] / LEAST_PAIRS_DIVISOR;
        if mean(0).is_nan() || mean(0) <= 0.0 {
            return Vec::new();
        }
        (0..=LARGEST_LAG_SAMPLES)
            .take_while(enough)
            .map(|lag| (lag as f64 * self.period, mean(lag) / mean(0)))
            .collect()
    }

    /// Autocorrelation time of the residual of joint j, s: the area below the autocorrelation up to its first zero or the last
    /// lag, by the trapezoidal rule. `None` without a residual.
    pub fn memory(&self, j: usize) -> Option<f64> {
        let rho = self.of_joint(j);
        if rho.len() < 2 {
            return None;
        }
        let mut area = 0.0;
        for pair in rho.windows(2) {
            let ((t0, a), (t1, b)) = (pair[0], pair[1]);
            if b <= 0.0 {
                return Some(area + 0.5 * a * (t1 - t0) * a / (a - b));
            }
            area += 0.5 * (a + b) * (t1 - t0);
        }
        Some(area)
    }

    /// Half width of the 95 % band around zero for the autocorrelation of joint j: if the residual is white noise, 95 % of
    /// the values are inside.
    pub fn band(&self, j: usize) -> f64 {
        INTERVAL / (self.joints[j].pairs[0].max(1) as f64).sqrt()
    }
}

impl ResidualSum for Autocorrelation {
    fn add(&mut self, model: &Model, group: &ResidualGroup) {
        let n = model.n();
        for (j, (record, residuals)) in self.record.iter_mut().zip(group.residuals).enumerate() {
            let factor = |e: f64| row_factor(self.robust.as_ref(), j, e);
            // A row of weight zero is treated as not used.
            let counting = |e: f64| Some(factor(e) * e).filter(|_| factor(e) > 0.0).unwrap_or(f64::NAN);
            let of = |(r, e): (usize, &f64)| if group.states.used[r * n + j] { counting(*e) } else { f64::NAN };
            record.extend(group.samples.clone().zip(residuals).map(of));
        }
    }

    fn append(&mut self, next: Self) {
        self.record.iter_mut().zip(next.record).for_each(|(all, next)| all.extend(next));
    }

    fn end_record(&mut self, states: &States) {
        let mut record = std::mem::take(&mut self.record);
        self.add_record(&record, states.period);
        record.iter_mut().for_each(Vec::clear);
        self.record = record;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::butterworth::Butterworth;
    use random::Random;

    fn memory(e: Vec<f64>, period: f64) -> f64 {
        let mut found = Autocorrelation::new(1, None);
        found.add_record(&[e], period);
        found.memory(0).unwrap()
    }

    /// The memory of filtered white noise equals `NOISE_MEMORY_PERIODS` divided by the cut-off. The memory of an
    /// autoregressive process with the autocorrelation a^l at lag l is -1/ln a samples.
    #[test]
    fn noise_and_slow_processes_have_the_memory_they_should() {
        let mut random = Random::new(3);
        let white: Vec<f64> = (0..40_000).map(|_| random.normal()).collect();
        let (rate, cutoff) = (1000.0, 20.0);
        let filter = Butterworth::low_pass(4, cutoff, rate).unwrap();
        let filtered = filter.zero_phase(vec![white.clone()]).remove(0);
        // The tolerance allows for the correlation of the rows: after the filter, 40000 rows contain only about 1600
        // independent rows.
        let found = memory(filtered, 1.0 / rate) * cutoff;
        assert!((found / NOISE_MEMORY_PERIODS - 1.0).abs() < 0.08, "{found}");
        // `NOISE_MEMORY_PERIODS` equals the area below the theoretical curve up to its first zero, up to one integration
        // step.
        let strips = (0..).map(|i| filtered_noise(cutoff, 1e-5 * f64::from(i))).take_while(|rho| *rho > 0.0);
        let area: f64 = strips.map(|rho| 1e-5 * rho).sum();
        assert!((area * cutoff / NOISE_MEMORY_PERIODS - 1.0).abs() < 2e-3, "{area}");
        let a = 0.95f64;
        let mut slow = vec![0.0];
        white.iter().for_each(|e| slow.push(a * slow[slow.len() - 1] + e));
        // The tolerance allows for the correlation of the rows: 40000 rows contain only about a thousand independent rows.
        assert!((memory(slow, 1.0) * -a.ln() - 1.0).abs() < 0.2);
        assert!(memory(white, 1.0) < 1.0);
    }

    #[test]
    fn rows_that_do_not_count_are_no_zeros() {
        let e: Vec<f64> = (0..400).map(|i| if i % 10 == 9 { f64::NAN } else { 1.0 }).collect();
        let mut found = Autocorrelation::new(2, None);
        found.add_record(&[e, vec![f64::NAN; 400]], 0.1);
        let (t, rho) = found.of_joint(0)[2];
        // Tolerance: rounding of a Fourier transform of a thousand samples.
        assert!(t == 0.2 && (rho - 1.0).abs() < 1e-12, "{t} {rho}");
        // A constant has rho = 1 up to the last lag, at 20 s.
        assert!((found.memory(0).unwrap() - 20.0).abs() < 1e-10);
        assert_eq!(found.memory(1), None);
        assert!(found.of_joint(1).is_empty());
    }
}
