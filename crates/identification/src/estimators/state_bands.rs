//! The rows of each joint by its state: one cluster for each octave of its speed, and one for each eighth of its range.
//!
//! The octaves go from below 1/16 up to 1 of its largest speed. The friction that a model lacks is the same at every pass
//! of such a band; ripple, load and a base that yields are the same at every pass of a position (`replicate_deviation`).
//! Each row stands in one band of either kind. Its products are summed once, in the cell of both, and the cells of a band
//! at the end.

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
/// Cells of a joint, those of one band of speed together.
const CELLS_PER_JOINT: usize = SPEED_BANDS * POSITION_BANDS;

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

/// Rows by joint and cell, weighted, with their residuals as the right-hand side.
#[derive(Clone)]
pub struct StateBands<'a> {
    /// The largest speed of each joint, rad/s (m/s), and its least and greatest position, rad (m).
    seen: &'a Observation,
    weight: CountOf<'a>,
    /// `None` where no row is.
    cells: Vec<Option<RowProducts>>,
}

impl<'a> StateBands<'a> {
    /// Without rows; `seen` has the speeds and positions of all of them.
    pub fn new(model: &Model, seen: &'a Observation, weight: CountOf<'a>) -> StateBands<'a> {
        StateBands { seen, weight, cells: vec![None; model.n() * CELLS_PER_JOINT] }
    }

    /// One cluster per band, by speed and by position.
    pub fn clusters(self, model: &Model) -> [Vec<Cluster>; 2] {
        let columns = |j: usize| model.layout.joints[j].columns.clone();
        let mut of = [Vec::new(), Vec::new()];
        for (j, shared, products) in self.products() {
            of[shared as usize].push(Cluster::of_products(columns(j), &products));
        }
        of
    }

    /// The joint of each band that has rows, what these share, and the products of their columns and of the residual
    /// behind them.
    ///
    /// Product (i, j), i <= j, stands at j (m + 1) + i.
    pub(crate) fn products(self) -> impl Iterator<Item = (usize, Shared, Vec<f64>)> {
        let cells: Vec<Option<Vec<f64>>> = self.cells.into_iter().map(|cell| cell.map(RowProducts::finish)).collect();
        let bands = |j: usize| {
            let cell = |speed: usize, position: usize| &cells[j * CELLS_PER_JOINT + speed * POSITION_BANDS + position];
            let by_speed = (0..SPEED_BANDS).map(|s| (Shared::Speed, sum((0..POSITION_BANDS).map(|p| cell(s, p)))));
            let by_position =
                (0..POSITION_BANDS).map(|p| (Shared::Position, sum((0..SPEED_BANDS).map(|s| cell(s, p)))));
            by_speed.chain(by_position).filter_map(|(shared, sum)| Some((j, shared, sum?))).collect::<Vec<_>>()
        };
        (0..cells.len() / CELLS_PER_JOINT).flat_map(bands).collect::<Vec<_>>().into_iter()
    }
}

/// The sum of the cells that have rows; `None` where none has.
fn sum<'c>(cells: impl Iterator<Item = &'c Option<Vec<f64>>>) -> Option<Vec<f64>> {
    cells.flatten().fold(None, |sum, cell| match sum {
        None => Some(cell.clone()),
        Some(mut sum) => {
            sum.iter_mut().zip(cell).for_each(|(sum, x)| *sum += x);
            Some(sum)
        }
    })
}

impl ResidualSum for StateBands<'_> {
    /// Successive samples are mostly in one cell. So all eight go into each cell that one of them is in, with weight zero
    /// where they belong to another.
    fn add(&mut self, model: &Model, group: &ResidualGroup) {
        let n = model.n();
        for (j, joint) in model.layout.joints.iter().enumerate() {
            let residuals = &group.residuals[j];
            let columns = joint.columns.len();
            let mut roots = [0.0; 8];
            let mut cells = [usize::MAX; 8];
            for (lane, r) in group.samples.clone().enumerate().filter(|(_, r)| group.states.used[r * n + j]) {
                roots[lane] = (self.weight)(j, residuals[lane]).sqrt();
                if roots[lane] != 0.0 {
                    cells[lane] = self.cell(j, group.states.q[r * n + j], group.states.dq[r * n + j]);
                }
            }
            let is_first = |lane: usize| cells[lane] != usize::MAX && !cells[..lane].contains(&cells[lane]);
            for lane in (0..8).filter(|&lane| is_first(lane)) {
                let cell = cells[lane];
                let of_cell = std::array::from_fn(|i| if cells[i] == cell { roots[i] } else { 0.0 });
                let products = self.cells[j * CELLS_PER_JOINT + cell].get_or_insert_with(|| RowProducts::new(columns));
                products.push(&joint.places[..columns], group.entries, residuals, &of_cell);
            }
        }
    }

    fn append(&mut self, next: Self) {
        for (all, next) in self.cells.iter_mut().zip(next.cells) {
            match (all, next) {
                (_, None) => {}
                (Some(all), Some(next)) => all.append(next),
                (all, next) => *all = next,
            }
        }
    }
}

impl StateBands<'_> {
    /// The cell of a joint at a position and velocity.
    fn cell(&self, j: usize, q: f64, dq: f64) -> usize {
        let speed = dq.abs();
        let by_speed = SPEED_BAND_ENDS.iter().take_while(|&&end| speed > end * self.seen.speed[j]).count();
        let (least, greatest) = self.seen.range[j];
        // NaN of a joint that stands still is the first band.
        let by_position = ((POSITION_BANDS as f64 * (q - least) / (greatest - least)) as usize).min(POSITION_BANDS - 1);
        by_speed * POSITION_BANDS + by_position
    }
}
