//! Partial leverage of rows on parameters, and correlation of parameters.
//!
//! ```text
//! C = (W'W)^-1,  W the rows weighted by joint          p x p
//! rho_ij = C_ij / sqrt(C_ii C_jj)                      correlation of two parameters
//! s_ik = (C w_i)_k^2 / C_kk                            partial leverage of row i on parameter k; the sum over rows is 1
//! ```
//! w_i: row i of W. (C w_i)_k is the entry of the pseudo-inverse by which row i enters x_k. s_ik can also be found from
//! column k after projection onto the complement of the other columns: it is the squared entry in row i over the sum of the
//! squares [Belsley, Kuh, Welsch 1980]. If column k of a row is a combination of its other columns, the row has no leverage
//! on parameter k.

use linear_model::linear_model::Model;
use linear_model::parameter::ParameterId;
use linear_model::states::States;
use numerics::least_squares::Solution;
use numerics::triangle::Triangle;

use crate::estimate::options::Options;
use crate::estimators::weighted::fit;

/// Number of intervals into which the time axis is divided.
pub const PARTS_OF_TIME: usize = 48;
/// Approximate largest number of examined samples. If a log is longer, every k-th sample is used.
const MAX_EXAMINED_SAMPLES: usize = 4000;

/// Correlations of the identifiable parameters, and partial leverage of the rows on these parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Information {
    /// The p parameters that the data determine.
    pub parameters: Vec<ParameterId>,
    /// Correlations rho_ij for i > j, row by row.
    pub correlation: Vec<f64>,
    /// Sums of the partial leverages s_ik: for each parameter, joint and interval of the time axis, p x n x [`PARTS_OF_TIME`].
    /// For each parameter, the sum over all joints and intervals is 1.
    pub shares: Vec<f64>,
    /// Length of the time axis, s.
    pub duration: f64,
    /// Step k: every k-th sample is examined.
    pub every: usize,
}

/// The sums from which [`Information`] is computed. Records are added one after the other.
pub(super) struct InformationSums {
    columns: Vec<usize>,
    /// The matrix C = (W'W)^-1 of all weighted rows, p x p, row by row.
    inverse: Vec<f64>,
    /// Weights of the rows, one per joint.
    weights: Vec<f64>,
    found: Information,
    instant: usize,
}

impl InformationSums {
    /// Makes empty sums. `joints`: for each joint, the triangle (R of QR) of the rows of all logs; C is computed from the
    /// triangles. `duration`: length of the common time axis, s.
    pub(super) fn new(model: &Model, joints: &[Triangle], options: &Options, duration: f64) -> InformationSums {
        let (Solution { determined, inverse, .. }, weights) = fit(joints, options.weights);
        let p = model.p();
        let columns: Vec<usize> = (0..p).filter(|&c| determined[c] && inverse[(c, c)] > 0.0).collect();
        let rho = |i: usize, j: usize| inverse[(i, j)] / (inverse[(i, i)] * inverse[(j, j)]).sqrt();
        let below = columns.iter().enumerate().flat_map(|(k, &i)| columns[..k].iter().map(move |&j| (i, j)));
        let instants = joints.iter().map(|t| t.rows).max().unwrap_or(0);
        let found = Information {
            parameters: columns.iter().map(|&c| model.parameters[c].id.clone()).collect(),
            correlation: below.map(|(i, j)| rho(i, j).clamp(-1.0, 1.0)).collect(),
            shares: vec![0.0; columns.len() * model.n() * PARTS_OF_TIME],
            duration,
            every: instants.div_ceil(MAX_EXAMINED_SAMPLES).max(1),
        };
        let inverse = (0..p * p).map(|i| inverse[(i / p, i % p)]).collect();
        InformationSums { columns, inverse, weights, found, instant: 0 }
    }

    /// Adds the partial leverages of a record. A time of the record plus `shift`, s, is the time on the common axis of all
    /// logs.
    pub(super) fn add(&mut self, model: &Model, states: &States, shift: f64) {
        let (n, p) = (model.n(), model.p());
        for r in 0..states.len() {
            self.instant += 1;
            if !self.instant.is_multiple_of(self.found.every) {
                continue;
            }
            let part = ((states.t[r] + shift) / self.found.duration * PARTS_OF_TIME as f64) as usize;
            let part = part.min(PARTS_OF_TIME - 1);
            model.rows(states, r..r + 1, |_, w| {
                for j in (0..n).filter(|j| states.used[r * n + j]) {
                    self.add_row(j, n, part, &w[j * p..(j + 1) * p]);
                }
            });
        }
    }

    fn add_row(&mut self, j: usize, n: usize, part: usize, row: &[f64]) {
        let p = row.len();
        let entries: Vec<(usize, f64)> =
            row.iter().map(|x| x * self.weights[j]).enumerate().filter(|(_, x)| *x != 0.0).collect();
        for (k, &c) in self.columns.iter().enumerate() {
            let of = &self.inverse[c * p..(c + 1) * p];
            let entry: f64 = entries.iter().map(|(i, x)| of[*i] * x).sum();
            self.found.shares[(k * n + j) * PARTS_OF_TIME + part] += entry * entry / of[c];
        }
    }

    /// Returns the result, with the partial leverages of each parameter normalised to a sum of 1.
    pub(super) fn finish(self) -> Information {
        let mut found = self.found;
        let of_parameter = found.shares.len() / found.parameters.len().max(1);
        for shares in found.shares.chunks_mut(of_parameter.max(1)) {
            let sum: f64 = shares.iter().sum();
            shares.iter_mut().for_each(|share| *share = if sum > 0.0 { *share / sum } else { 0.0 });
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::observation::Observation;
    use crate::test_arm::Pendulum;

    /// If all rows are examined, the leverages sum to 1 even before normalisation. The leverages on a parameter equal the
    /// squared entries of its column after projection onto the complement of the other columns (divided by their sum).
    #[test]
    fn shares_are_those_of_the_column_without_the_others() {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &[], &[]);
        let states = arm.states(400);
        let joints = Observation::of(&model, &states, 1).joints(|_| true);
        let options = Options::default();
        let duration = states.t[states.len() - 1];
        let mut sums = InformationSums::new(&model, &joints, &options, duration);
        sums.add(&model, &states, 0.0);
        let p = model.p();
        for k in 0..p {
            let of = &sums.found.shares[k * PARTS_OF_TIME..(k + 1) * PARTS_OF_TIME];
            // Tolerance: rounding of four hundred terms after an inversion.
            assert!((of.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{of:?}");
        }
        let found = sums.finish();
        assert_eq!((found.every, found.correlation.len()), (1, p * (p - 1) / 2));

        // Column 0 orthogonalised against columns 1 and 2, by Gram and Schmidt.
        let mut columns = vec![vec![0.0; states.len()]; p];
        model.rows(&states, 0..states.len(), |r, w| (0..p).for_each(|c| columns[c][r] = w[c]));
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let without = |a: &[f64], b: &[f64]| -> Vec<f64> {
            let factor = dot(a, b) / dot(b, b);
            a.iter().zip(b).map(|(a, b)| a - factor * b).collect()
        };
        let second = without(&columns[2], &columns[1]);
        let rest = without(&without(&columns[0], &columns[1]), &second);
        let whole = dot(&rest, &rest);
        let mut expected = vec![0.0; PARTS_OF_TIME];
        for (r, x) in rest.iter().enumerate().filter(|(r, _)| states.used[*r]) {
            let part = (states.t[r] / duration * PARTS_OF_TIME as f64) as usize;
            expected[part.min(PARTS_OF_TIME - 1)] += x * x / whole;
        }
        for (a, b) in found.shares[..PARTS_OF_TIME].iter().zip(&expected) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
}
