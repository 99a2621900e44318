//! Standard deviations of gains and parameters if the noise of a joint depends on frequency.
//!
//! Encoder noise causes torques through the controller, and the joint follows low frequencies better than high frequencies. So
//! the noise depends on frequency, but the weights of `fit` have only one scale per joint. With these weights, the standard
//! deviations of the gains, which depend on the rows of low frequency, are up to 1.5 times as large as the true errors. Here
//!
//! ```text
//! E z^2 = (1 - h) exp(a + b u)                                   z: weighted residual of a row
//! cov = A^-1 (sum exp(a + b u) d d') A^-1,   A = sum d d'        d: weighted row, with columns of the gains
//! ```
//! h is the leverage of the row, and u = log2(1 + f / f_1) with f_1 the lowest frequency of a motion. The likelihood of
//! normal z gives a and b of each joint [Harvey 1976]. The estimate itself is unchanged.

use numerics::least_squares::{Solution, solve};
use numerics::triangle::TriangleBuilder;

use crate::estimators::drive_gains::likelihood::{DriveGains, Gain};
use crate::spectrum::rist_mh::data::HarmonicData;
use crate::spectrum::rist_mh::fit::{GainEquation, IterationState};

/// Largest number of steps of Fisher scoring, far more than needed.
const MAX_SCORING_STEPS: usize = 30;
/// The iteration ends if a step of Fisher scoring is smaller than this value.
const SETTLED_SCORING_STEP: f64 = 1e-6;
/// b is not identifiable if the determinant of the 2 x 2 information matrix, divided by the product of the diagonal entries, is
/// below this value.
const SMALLEST_RELATIVE_DETERMINANT: f64 = 1e-9;

/// A row for estimating how the noise of its joint depends on frequency: a and b of E z^2 = (1 - h) exp(a + b u).
struct NoiseRow {
    /// The frequency of the row in octaves, log2(1 + f / f_1).
    u: f64,
    /// z^2. z: residual divided by the standard deviation from which the weight of the row was computed.
    square: f64,
    /// 1 - h, h: leverage of the row.
    free: f64,
}

impl IterationState {
    /// Sets the standard deviations of `found` (gains and parameters) for noise that depends on frequency, by the equations of
    /// this module.
    pub(crate) fn deviations_by_frequency(&self, data: &HarmonicData, known: &[Gain], found: &mut DriveGains) {
        let rows = self.gain_equations(data, known);
        let width = rows.first().map_or(0, |row| row.coefficients.len());
        let mut plain = TriangleBuilder::new(width);
        rows.iter().for_each(|row| plain.push(&row.coefficients, 0.0));
        let solution = solve(&plain.finish());
        let scales = self.scales(data, &rows, &solution);
        let mut scaled = TriangleBuilder::new(width);
        for row in &rows {
            let scale = row.place.map_or(1.0, |(e, r)| scales[e][r]).sqrt();
            scaled.push(&row.coefficients.iter().map(|d| scale * d).collect::<Vec<f64>>(), 0.0);
        }
        let scaled = scaled.finish();
        let deviation = |c: usize| {
            let along = |i: usize| (i..width).map(|j| scaled.at(i, j) * solution.inverse[(j, c)]).sum::<f64>();
            (0..width).map(|i| along(i).powi(2)).sum::<f64>().sqrt()
        };
        found.deviation = (0..data.p).map(deviation).collect();
        let free = (0..known.len()).filter(|&j| known[j].is_unknown());
        free.zip(self.x.len()..).for_each(|(j, c)| found.gain_deviation[j] = deviation(c));
    }

    /// The variance factor exp(a + b u) of each row of each spectrum. u: frequency in octaves; a, b: estimated for each joint.
    fn scales(&self, data: &HarmonicData, rows: &[GainEquation], solution: &Solution) -> Vec<Vec<f64>> {
        let residuals = self.residuals(data, &self.deviation);
        let moving = data.spectra.iter().flat_map(|s| &s.frequency).filter(|f| **f > 0.0);
        let lowest = moving.fold(f64::MAX, |least, f| least.min(*f));
        let octaves = |f: f64| (1.0 + f / lowest).log2();
        let mut asked: Vec<Vec<NoiseRow>> = (0..data.n).map(|_| vec![]).collect();
        for row in rows {
            let Some((e, r)) = row.place else { continue };
            let free = (1.0 - leverage(&row.coefficients, solution)).clamp(0.0, 1.0);
            let u = octaves(data.spectra[e].frequency[r]);
            asked[data.spectra[e].joint].push(NoiseRow { u, square: residuals[e][r].powi(2), free });
        }
        let found: Vec<[f64; 2]> = asked.iter().map(|rows| log_linear(rows)).collect();
        let of = |joint: usize, f: &f64| (found[joint][0] + found[joint][1] * octaves(*f)).exp();
        data.spectra.iter().map(|s| s.frequency.iter().map(|f| of(s.joint, f)).collect()).collect()
    }
}

/// The leverage h = d' A^-1 d of a weighted row d. A: normal matrix of all rows.
fn leverage(row: &[f64], solution: &Solution) -> f64 {
    let live: Vec<usize> = (0..row.len()).filter(|&c| row[c] != 0.0).collect();
    let along = |a: usize| live.iter().map(|&b| solution.inverse[(a, b)] * row[b]).sum::<f64>();
    live.iter().map(|&a| row[a] * along(a)).sum()
}

/// Estimates (a, b) of E z^2 = (1 - h) exp(a + b u) (symbols: see the module) by Fisher scoring. a and b solve
///
/// sum (z^2 / exp(a + b u) - (1 - h)) [1, u] = 0.
///
/// b is 0 if all rows have the same frequency. a and b are 0 without noise.
fn log_linear(rows: &[NoiseRow]) -> [f64; 2] {
    let free: f64 = rows.iter().map(|row| row.free).sum();
    let squares: f64 = rows.iter().map(|row| row.square).sum();
    if squares <= 0.0 || free <= 0.0 {
        return [0.0, 0.0];
    }
    let mut found = [(squares / free).ln(), 0.0];
    for _ in 0..MAX_SCORING_STEPS {
        let (mut score, mut information) = ([0.0; 2], [0.0; 3]);
        for NoiseRow { u, square, free } in rows {
            let left = square / (found[0] + found[1] * u).exp() - free;
            score = [score[0] + left, score[1] + left * u];
            information = [information[0] + free, information[1] + free * u, information[2] + free * u * u];
        }
        let [n, su, suu] = information;
        let determinant = n * suu - su * su;
        if determinant <= SMALLEST_RELATIVE_DETERMINANT * n * suu {
            break;
        }
        let step = [(suu * score[0] - su * score[1]) / determinant, (n * score[1] - su * score[0]) / determinant];
        // The step is limited to 1, so that exp(a) changes at most by the factor e.
        let length = 1.0 / step.iter().fold(1.0_f64, |most, s| most.max(s.abs()));
        found = [found[0] + length * step[0], found[1] + length * step[1]];
        if step.iter().all(|s| s.abs() < SETTLED_SCORING_STEP) {
            break;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    #[test]
    fn the_law_of_the_noise_comes_back() {
        let mut random = Random::new(5);
        let (draws, count) = (200, 150);
        for law in [[-1.2, 0.5], [0.7, 0.0]] {
            let (mut sum, mut squares) = ([0.0; 2], [0.0; 2]);
            for _ in 0..draws {
                let row = |i: usize, z: f64| {
                    let (u, free) = (4.0 * i as f64 / count as f64, if i.is_multiple_of(5) { 0.3 } else { 0.95 });
                    let variance: f64 = free * f64::exp(law[0] + law[1] * u);
                    NoiseRow { u, square: variance * z * z, free }
                };
                let rows: Vec<NoiseRow> = (0..count).map(|i| row(i, random.normal())).collect();
                let found = log_linear(&rows);
                for k in 0..2 {
                    sum[k] += found[k] / f64::from(draws);
                    squares[k] += (found[k] - law[k]).powi(2) / f64::from(draws);
                }
            }
            for k in 0..2 {
                // Allowed error: three standard errors of the mean, plus the bias of the logarithm of 150 squares, about 2 / 150.
                let error = squares[k].sqrt();
                let allowed = 3.0 * error / f64::from(draws).sqrt() + 1.0 / 75.0;
                assert!((sum[k] - law[k]).abs() < allowed, "{sum:?} {law:?}");
                assert!(error < 0.3, "{error}");
            }
        }
    }

    #[test]
    fn without_noise_or_motion_there_is_no_law() {
        let row = |u: f64, square: f64| NoiseRow { u, square, free: 0.5 };
        assert_eq!(log_linear(&[]), [0.0, 0.0]);
        assert_eq!(log_linear(&[row(0.0, 0.0), row(1.0, 0.0)]), [0.0, 0.0]);
        let of_one_frequency = log_linear(&[row(2.0, 1.0), row(2.0, 3.0)]);
        assert!(of_one_frequency[1] == 0.0 && (of_one_frequency[0] - 4.0_f64.ln()).abs() < 1e-12);
    }
}
