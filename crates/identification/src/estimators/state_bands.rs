//! The rows of each joint by its state: one cluster for each octave of its speed, and one for each eighth of its range.
//!
//! The octaves go from below 1/16 up to 1 of its largest speed. The friction that a model lacks is the same at every pass
//! of such a band; ripple, load and a base that yields are the same at every pass of a position (`replicate_deviation`).
//! Each row stands in one band of either kind.

use std::sync::Arc;

use linear_model::linear_model::{Model, ResidualGroup};

use crate::estimators::clusters::Cluster;
use crate::estimators::row_products::RowProducts;
use crate::rows::observation::Observation;
use crate::rows::residual_sums::ResidualSum;

/// Upper ends of the bands of speed, as shares of the joint's largest speed. The last band has none.
const SPEED_BAND_ENDS: [f64; 4] = [1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0, 1.0 / 2.0];

/// Bands of a joint by its speed.
const SPEED_BANDS: usize = SPEED_BAND_ENDS.len() + 1;
/// Bands of a joint by its position: equal parts of the range of the record.
const POSITION_BANDS: usize = 8;
/// Bands of a joint, those by speed first.
const BANDS_PER_JOINT: usize = SPEED_BANDS + POSITION_BANDS;

/// What the rows of a band share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Shared {
    /// The octave of their joint's speed.
    Speed,
    /// The part of their joint's range.
    Position,
}

/// How much a row counts, from its joint and its residual.
pub type CountOf<'a> = Arc<dyn Fn(usize, f64) -> f64 + Send + Sync + 'a>;

/// Rows by joint and band, weighted, with their residuals as the right-hand side.
#[derive(Clone)]
pub struct StateBands<'a> {
    /// The largest speed of each joint, rad/s (m/s), and its least and greatest position, rad (m).
    seen: &'a Observation,
    weight: CountOf<'a>,
    bands: Vec<RowProducts>,
}

impl<'a> StateBands<'a> {
    /// Without rows; `seen` has the speeds and positions of all of them.
    pub fn new(model: &Model, seen: &'a Observation, weight: CountOf<'a>) -> StateBands<'a> {
        let of_joint = |j: usize| vec![RowProducts::new(model.layout.joints[j].columns.len()); BANDS_PER_JOINT];
        StateBands { seen, weight, bands: (0..model.n()).flat_map(of_joint).collect() }
    }

    /// One cluster per band, by speed and by position.
    pub(crate) fn clusters(self, model: &Model) -> [Vec<Cluster>; 2] {
        let columns = |j: usize| model.layout.joints[j].columns.clone();
        let mut of = [Vec::new(), Vec::new()];
        for (j, shared, products) in self.products() {
            of[shared as usize].push(Cluster::of_products(columns(j), &products));
        }
        of
    }

    /// The joint of each band, what its rows share, and the products of its columns and of the residual behind them.
    ///
    /// Product (i, j), i <= j, stands at j (m + 1) + i.
    pub(crate) fn products(self) -> impl Iterator<Item = (usize, Shared, Vec<f64>)> {
        self.bands.into_iter().enumerate().map(|(k, band)| {
            let shared = if k % BANDS_PER_JOINT < SPEED_BANDS { Shared::Speed } else { Shared::Position };
            (k / BANDS_PER_JOINT, shared, band.finish())
        })
    }
}

impl ResidualSum for StateBands<'_> {
    /// Successive samples are mostly in one band. So all eight go into each band that one of them is in, with weight
    /// zero where they belong to another.
    fn add(&mut self, model: &Model, group: &ResidualGroup) {
        let n = model.n();
        for (j, joint) in model.layout.joints.iter().enumerate() {
            let residuals = &group.residuals[j];
            let mut roots = [[0.0; 8]; BANDS_PER_JOINT];
            for (lane, r) in group.samples.clone().enumerate().filter(|(_, r)| group.states.used[r * n + j]) {
                let speed = group.states.dq[r * n + j].abs();
                let by_speed = SPEED_BAND_ENDS.iter().take_while(|&&end| speed > end * self.seen.speed[j]).count();
                let (least, greatest) = self.seen.range[j];
                let share = (group.states.q[r * n + j] - least) / (greatest - least);
                // NaN of a joint that stands still is the first band.
                let by_position = ((POSITION_BANDS as f64 * share) as usize).min(POSITION_BANDS - 1);
                let root = (self.weight)(j, residuals[lane]).sqrt();
                roots[by_speed][lane] = root;
                roots[SPEED_BANDS + by_position][lane] = root;
            }
            for (band, roots) in self.bands[j * BANDS_PER_JOINT..].iter_mut().zip(&roots) {
                if roots.iter().any(|root| *root != 0.0) {
                    band.push(&joint.places[..joint.columns.len()], group.entries, residuals, roots);
                }
            }
        }
    }

    fn append(&mut self, next: Self) {
        self.bands.iter_mut().zip(next.bands).for_each(|(all, next)| all.append(next));
    }
}
