//! Clusters of the rows of each joint by its state: bands of speed (octaves), and bands of position (eighths of its range).
//!
//! The octaves of speed cover less than 1/16 up to 1 of the largest speed of the joint. An error of the friction law is equal
//! at every pass of a speed band. Errors by ripple, load and a compliant base are equal at every pass of a position
//! (`replicate_deviation`). Each row is in one speed band and in one position band. A cell is the intersection of one speed
//! band and one position band. The products of a row are summed once, in the cell of its two bands. At the end the cells of
//! each band are summed.

use std::sync::Arc;

use linear_model::linear_model::{Model, ResidualGroup};

use crate::estimators::clusters::Cluster;
use crate::estimators::row_products::RowProducts;
use crate::rows::observation::Observation;
use crate::rows::residual_sums::ResidualSum;

/// Upper ends of the speed bands, relative to the largest speed of the joint. The last band has no upper end.
const SPEED_BAND_ENDS: [f64; 4] = [1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0, 1.0 / 2.0];

/// Number of speed bands of a joint.
const SPEED_BANDS: usize = SPEED_BAND_ENDS.len() + 1;
/// Number of position bands of a joint, of equal width over its range.
const POSITION_BANDS: usize = 8;
/// Number of cells of a joint. The cells of one speed band are adjacent.
const CELLS_PER_JOINT: usize = SPEED_BANDS * POSITION_BANDS;

/// The property that the rows of a band have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum BandContent {
    /// The speed of the joint is in one octave.
    Speed,
    /// The position of the joint is in one eighth of its range.
    Position,
}

/// A function that gives the weight of a row from its joint and its residual.
pub type CountOf<'a> = Arc<dyn Fn(usize, f64) -> f64 + Send + Sync + 'a>;

/// Sums of products of weighted rows for each joint and cell, with the residual as the last column.
#[derive(Clone)]
pub struct StateBands<'a> {
    /// Observation that gives the largest speed of each joint, rad/s (m/s), and its least and greatest position, rad (m).
    seen: &'a Observation,
    weight: CountOf<'a>,
    /// The sums of each cell, joint by joint; `None` for a cell without rows.
    cells: Vec<Option<RowProducts>>,
}

impl<'a> StateBands<'a> {
    /// Makes empty bands. `seen`: gives the largest speed and the range of position of each joint; `weight`: gives the weight of
    /// a row.
    pub fn new(model: &Model, seen: &'a Observation, weight: CountOf<'a>) -> StateBands<'a> {
        StateBands { seen, weight, cells: vec![None; model.n() * CELLS_PER_JOINT] }
    }

    /// Makes one cluster per band. Returns the speed bands of all joints, then the position bands of all joints.
    pub fn clusters(self, model: &Model) -> [Vec<Cluster>; 2] {
        let columns = |j: usize| model.layout.joints[j].columns.clone();
        let mut of = [Vec::new(), Vec::new()];
        for (j, shared, products) in self.products() {
            of[shared as usize].push(Cluster::of_products(columns(j), &products));
        }
        of
    }

    /// For each band with rows: the joint and the kind (speed or position) of the band, and the sums of products of the m
    /// columns of its rows, with the residual as the last column.
    ///
    /// The product of columns i <= j is at index j (m + 1) + i.
    pub(crate) fn products(self) -> impl Iterator<Item = (usize, BandContent, Vec<f64>)> {
        let cells: Vec<Option<Vec<f64>>> = self.cells.into_iter().map(|cell| cell.map(RowProducts::finish)).collect();
        let bands = |j: usize| {
            let cell = |speed: usize, position: usize| &cells[j * CELLS_PER_JOINT + speed * POSITION_BANDS + position];
            let by_speed = (0..SPEED_BANDS).map(|s| (BandContent::Speed, sum((0..POSITION_BANDS).map(|p| cell(s, p)))));
            let by_position =
                (0..POSITION_BANDS).map(|p| (BandContent::Position, sum((0..SPEED_BANDS).map(|s| cell(s, p)))));
            by_speed.chain(by_position).filter_map(|(shared, sum)| Some((j, shared, sum?))).collect::<Vec<_>>()
        };
        (0..cells.len() / CELLS_PER_JOINT).flat_map(bands).collect::<Vec<_>>().into_iter()
    }
}

/// The sum of the cells that have rows; `None` if no cell has rows.
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
    /// Successive samples are mostly in the same cell (one band of speed and one of position). So the sums of each cell that
    /// contains at least one of the eight samples are updated with all eight samples; samples that belong to other cells get
    /// weight zero.
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
    /// The index within joint j of the cell for position q, rad (m), and velocity dq, rad/s (m/s).
    fn cell(&self, j: usize, q: f64, dq: f64) -> usize {
        let speed = dq.abs();
        let by_speed = SPEED_BAND_ENDS.iter().take_while(|&&end| speed > end * self.seen.speed[j]).count();
        let (least, greatest) = self.seen.range[j];
        // The range of a joint at standstill is zero. The quotient is then NaN, which the cast maps to the first band.
        let by_position = ((POSITION_BANDS as f64 * (q - least) / (greatest - least)) as usize).min(POSITION_BANDS - 1);
        by_speed * POSITION_BANDS + by_position
    }
}
