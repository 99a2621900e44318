//! The rows of each joint by its speed: one cluster for each joint and octave of its speed.
//!
//! The octaves go from below 1/16 up to 1 of its largest speed. The friction that a model lacks is the same at every
//! pass of such a band (`replicate_deviation`).

use std::sync::Arc;

use generated::Eight;
use linear_model::linear_model::{Model, ResidualGroup};
use numerics::reflection::add_products;
use numerics::row_block::RowBlock;

use crate::estimators::clusters::Cluster;
use crate::rows::residual_sums::ResidualSum;

/// Upper ends of the bands of speed, as shares of the joint's largest speed. The last band has none.
const SPEED_BAND_ENDS: [f64; 4] = [1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0, 1.0 / 2.0];

/// Bands of a joint.
const BANDS_PER_JOINT: usize = SPEED_BAND_ENDS.len() + 1;

/// How much a row counts, from its joint and its residual.
pub type CountOf<'a> = Arc<dyn Fn(usize, f64) -> f64 + Send + Sync + 'a>;

/// Rows by joint and band of speed, weighted, with their residuals as the right-hand side.
#[derive(Clone)]
pub struct SpeedBands<'a> {
    /// The largest speed of each joint, rad/s (m/s).
    largest: &'a [f64],
    weight: CountOf<'a>,
    bands: Vec<Band>,
}

/// Rows of one joint: the columns that its torque can depend on, then the residual.
#[derive(Clone)]
struct Band {
    places: Vec<usize>,
    /// Products (i, j), i <= j, column by column.
    products: Vec<f64>,
    /// Rows that are in no product yet.
    block: RowBlock,
}

impl Band {
    /// A band of `columns` columns, without rows.
    fn new(columns: usize) -> Band {
        let entries = columns + 1;
        let places = (0..entries).collect();
        Band { places, products: vec![0.0; entries * entries], block: RowBlock::new(entries) }
    }

    /// Takes in eight rows: their entries at `places`, then their residuals, each multiplied by its weight.
    fn push(&mut self, places: &[usize], entries: &[Eight], residuals: &[f64; 8], weights: &[f64; 8]) {
        let weighted = |x: &[f64; 8]| Eight(std::array::from_fn(|lane| weights[lane] * x[lane]));
        let rows = self.block.push_eight();
        for (row, &place) in rows.iter_mut().zip(places) {
            *row = weighted(&entries[place].0);
        }
        rows[places.len()] = weighted(residuals);
        if self.block.is_full() {
            self.complete();
        }
    }

    fn complete(&mut self) {
        add_products(&mut self.products, &self.places, &mut self.block);
        self.block.rows = 0;
    }
}

impl<'a> SpeedBands<'a> {
    /// Without rows.
    pub fn new(model: &Model, largest: &'a [f64], weight: CountOf<'a>) -> SpeedBands<'a> {
        let of_joint = |j: usize| vec![Band::new(model.layout.joints[j].columns.len()); BANDS_PER_JOINT];
        SpeedBands { largest, weight, bands: (0..model.n()).flat_map(of_joint).collect() }
    }

    /// One cluster per band.
    pub(crate) fn clusters(self, model: &Model) -> Vec<Cluster> {
        let columns = |j: usize| model.layout.joints[j].columns.clone();
        self.products().map(|(j, products)| Cluster::of_products(columns(j), &products)).collect()
    }

    /// The joint of each band, and the products of its columns and of the residual behind them.
    ///
    /// Product (i, j), i <= j, stands at j (m + 1) + i.
    pub(crate) fn products(self) -> impl Iterator<Item = (usize, Vec<f64>)> {
        self.bands.into_iter().enumerate().map(|(k, mut band)| {
            band.complete();
            (k / BANDS_PER_JOINT, band.products)
        })
    }
}

impl ResidualSum for SpeedBands<'_> {
    /// Successive samples are mostly in one band. So all eight go into each band that one of them is in, with weight
    /// zero where they belong to another.
    fn add(&mut self, model: &Model, group: &ResidualGroup) {
        let n = model.n();
        for (j, joint) in model.layout.joints.iter().enumerate() {
            let residuals = &group.residuals[j];
            let mut roots = [[0.0; 8]; BANDS_PER_JOINT];
            for (lane, r) in group.samples.clone().enumerate().filter(|(_, r)| group.states.used[r * n + j]) {
                let speed = group.states.dq[r * n + j].abs();
                let band = SPEED_BAND_ENDS.iter().take_while(|&&end| speed > end * self.largest[j]).count();
                roots[band][lane] = (self.weight)(j, residuals[lane]).sqrt();
            }
            for (band, roots) in self.bands[j * BANDS_PER_JOINT..].iter_mut().zip(&roots) {
                if roots.iter().any(|root| *root != 0.0) {
                    band.push(&joint.places[..joint.columns.len()], group.entries, residuals, roots);
                }
            }
        }
    }

    fn append(&mut self, next: Self) {
        for (all, mut next) in self.bands.iter_mut().zip(next.bands) {
            next.complete();
            all.products.iter_mut().zip(&next.products).for_each(|(sum, product)| *sum += product);
        }
    }
}
