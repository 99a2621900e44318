//! Cluster-robust standard deviations of drive gains and parameters, estimated together from logs of currents.
//!
//! The method is described in `replicate_deviation`. The equation of joint j in `likelihood` is linearised at the solution. D_j:
//! rows of the regressor, X: parameters, k_j: gain, I_j: currents, s_j: their noise. With g_j = 1/k_j and the weight w_j = 1 /
//! (k_j s_j) it is
//!
//! w_j (k_j I_j - D_j X) = w_j D_j dX + w_j (D_j X) d ln g_j + noise.
//!
//! The logarithm of an unknown gain is an additional parameter. The column of this parameter is the torque of the joint. All
//! products of these columns follow from the products P of [D_j, I_j] over the rows of a cluster, as T' P T with T = [1, X, -X;
//! 0, 0, k_j].
//!
//! An expected gain adds one row, whose error is one standard deviation.

use linear_model::linear_model::Model;
use nalgebra::DMatrix;
use numerics::triangle::Triangle;

use crate::estimators::clusters::{Cluster, FullNormalMatrix};
use crate::estimators::drive_gains::likelihood::{DriveGains, Gain};
use crate::estimators::replicate_deviation::{ReplicateDeviation, of_clusters};
use crate::estimators::state_bands::StateBands;
use crate::rows::observation::Observation;

/// A cluster of rows of one joint, which have a common error.
struct ReplicateRows {
    joint: usize,
    /// The columns that have non-zero entries in these rows.
    columns: Vec<usize>,
    /// Sums of products of the m columns in `columns` with one another, with the current as the last column, (m + 1) x (m + 1).
    products: DMatrix<f64>,
}

/// The clusters of rows of all logs of currents.
pub struct Replicates {
    /// For each block of the record, the rows of each joint.
    parts: Vec<Vec<ReplicateRows>>,
    /// The rows of each joint in each speed band, and in each position band.
    bands: [Vec<ReplicateRows>; 2],
}

impl Replicates {
    /// Makes the clusters. `observation`: triangles (R of QR) of the rows, with the current as the right-hand side. `bands`:
    /// sums of products of the rows in each band of speed and position, with the current as the last column; all rows have
    /// weight 1.
    pub fn of(model: &Model, observation: &Observation, bands: StateBands) -> Replicates {
        let of_triangle = |(joint, triangle): (usize, &Triangle)| {
            let columns = triangle.live().into_iter().filter(|&c| c < triangle.columns());
            let all: Vec<usize> = columns.clone().chain([triangle.columns()]).collect();
            let entry = |i: usize, c: usize| if i <= all[c] { triangle.at(i, all[c]) } else { 0.0 };
            let rows = DMatrix::from_fn(triangle.columns() + 1, all.len(), entry);
            ReplicateRows { joint, columns: columns.collect(), products: rows.tr_mul(&rows) }
        };
        let of_band = |(joint, products): (usize, Vec<f64>)| {
            let columns = model.layout.joints[joint].columns.clone();
            let m = columns.len() + 1;
            let products = DMatrix::from_fn(m, m, |i, j| products[i.max(j) * m + i.min(j)]);
            ReplicateRows { joint, columns, products }
        };
        let parts = observation.parts.iter().filter(|part| part.iter().any(|triangle| triangle.rows > 0));
        let mut of = [Vec::new(), Vec::new()];
        bands.products().for_each(|(joint, shared, products)| of[shared as usize].push(of_band((joint, products))));
        Replicates { parts: parts.map(|part| part.iter().enumerate().map(of_triangle).collect()).collect(), bands: of }
    }

    /// Standard deviations at the solution `found`: first of the parameters, then of the logarithms of the unknown gains.
    ///
    /// `discounts`: for each joint, the number of correlated equations that count as one independent equation. The row of an
    /// expected gain is independent of other rows, so this row is multiplied by the discount of its joint.
    pub fn deviation(&self, found: &DriveGains, known: &[Gain], discounts: &[f64]) -> ReplicateDeviation {
        let unknown: Vec<usize> = (0..known.len()).filter(|&j| known[j].is_unknown()).collect();
        let p = found.parameters.len();
        let width = p + unknown.len();
        let relative = |j: usize| found.gain_deviation[j] / found.gain[j].abs();
        let white: Vec<f64> = found.deviation.iter().copied().chain(unknown.iter().map(|&j| relative(j))).collect();
        let cluster = |rows: &ReplicateRows| rows.linearised(found, unknown.iter().position(|&j| j == rows.joint));
        let of_part =
            |part: &Vec<ReplicateRows>| Cluster::sum(width, &part.iter().map(cluster).collect::<Vec<Cluster>>());
        let parts: Vec<Cluster> = self.parts.iter().map(of_part).collect();
        let bands = self.bands.each_ref().map(|rows| rows.iter().map(cluster).collect());
        let expected: Vec<Cluster> = unknown
            .iter()
            .enumerate()
            .filter_map(|(at, &j)| match known[j] {
                Gain::Expected(_, deviation) => Some((p + at, found.gain[j] / deviation, discounts[j])),
                Gain::Known(_) | Gain::Free => None,
            })
            .map(|(column, row, s)| Cluster::of_products(vec![column], &[s * row * row, 0.0, s * row, 0.0]))
            .collect();
        let whole = FullNormalMatrix::of_clusters(width, parts.iter().chain(&expected));
        let mut deviation = of_clusters(&whole, &parts, bands, 1.0, white);
        let of_expected = whole.variance(&expected, 0.0, 0.0);
        for by_cluster in [&mut deviation.by_part, &mut deviation.by_speed, &mut deviation.by_position] {
            by_cluster.iter_mut().zip(&of_expected).for_each(|(deviation, v)| *deviation = deviation.hypot(v.sqrt()));
        }
        deviation
    }
}

impl ReplicateRows {
    /// A_g and W_g' e_g of the cluster, linearised at the solution. The columns are `columns`, then the logarithm of the gain.
    /// `gain`: number of the gain among the unknown gains; `None` if the gain is known.
    fn linearised(&self, found: &DriveGains, gain: Option<usize>) -> Cluster {
        let (m, p) = (self.columns.len(), found.parameters.len());
        let k = found.gain[self.joint];
        let weight = 1.0 / (k * found.noise[self.joint]);
        let of_gain = usize::from(gain.is_some());
        let map = DMatrix::from_fn(m + 1, m + of_gain + 1, |i, j| {
            let (is_current, is_residual) = (i == m, j == m + of_gain);
            match (is_current, j < m) {
                (false, true) => f64::from(u8::from(i == j)),
                (true, true) => 0.0,
                (true, false) => {
                    if is_residual {
                        k
                    } else {
                        0.0
                    }
                }
                (false, false) => found.parameters[self.columns[i]] * if is_residual { -1.0 } else { 1.0 },
            }
        });
        let products = map.tr_mul(&(&self.products * &map)) * (weight * weight);
        let columns = self.columns.iter().copied().chain(gain.map(|at| p + at)).collect();
        Cluster::of_products(columns, products.as_slice())
    }
}
