//! Products of a log's rows, sorted by joint and state (cells). From the cells, standard deviations by bands of speed and
//! position can be computed, as `replicate_deviation` does from rows.
//!
//! The limits of the bands in `replicate_deviation` depend on the range of motion in all logs, which is unknown while only some
//! logs are read. So the cells have fixed limits, and bands are formed from cells when the sums are solved. W_c, tau: rows of
//! cell c (regressor and torques); x: solution of all rows; A, s: normal matrix and score of a cell c or a band g.
//!
//! ```text
//! A_c = W_c' W_c,   s_c = W_c' tau - A_c x        A_g = sum of the cells of a band, s_g likewise
//! ```
//!
//! | kind of cell | range of a cell |
//! |---|---|
//! | speed | an octave of |dq|: floor(log2 |dq|); one cell for all speeds below `SLOWEST_OCTAVE` |
//! | position | a 32nd of a turn, with q reduced to one turn; 50 mm for a prismatic joint |
//!
//! If more logs are added, the cells become larger, like the blocks of a log (`accumulator`): first, four cells of position
//! become one; then all cells of position are removed, and two octaves of speed become one.
//!
//! A replicate is a set of rows that count as one independent unit for standard deviations.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use linear_model::linear_model::{Model, ResidualGroup};
use linear_model::states::States;

use identification::estimators::clusters::Cluster;
use identification::estimators::row_products::RowProducts;
use identification::estimators::state_bands::BandContent;
use identification::rows::residual_sums::{ResidualSum, add_record};

/// Number of cells of position in a turn.
const CELLS_PER_TURN: f64 = 32.0;
/// Length of a cell of position of a prismatic joint, m.
const CELL_LENGTH: f64 = 0.05;
/// Number of position cells on each side of zero for a prismatic joint. The last cell also contains all positions farther away.
const MAX_SLIDING_CELLS: i32 = 32;
/// Number of cells of position that are merged into one.
const CELLS_PER_FOLD: i32 = 4;
/// Exponents of the lowest and the highest octave of speed (2^k to 2^(k+1) rad/s or m/s). The lowest octave also contains all
/// lower speeds, and the highest octave all higher speeds.
const SLOWEST_OCTAVE: i32 = -8;
const FASTEST_OCTAVE: i32 = 10;
/// Number of bands of speed: the octave with the largest speed, and the next octaves below it. The last band also contains all
/// lower speeds.
const SPEED_BANDS: i32 = 5;
/// Greatest number of bands of position.
const POSITION_BANDS: usize = 8;

/// The key of a cell: its joint, its kind (a range of speed or of position), and the index of the range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Cell {
    pub joint: usize,
    pub shared: BandContent,
    pub index: i32,
}

/// The size of the cells. It grows if more logs are added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum CellSize {
    /// Octaves of speed, and all cells of position.
    Fine,
    /// Octaves of speed, and cells of position that are four times as large.
    Coarse,
    /// Pairs of octaves of speed, without cells of position.
    SpeedOnly,
}

/// For each cell, the sums of products of its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct StateCells {
    /// The current size of the cells.
    pub(crate) cell_size: CellSize,
    /// For each joint, the columns that may affect its torque.
    pub(crate) columns: Vec<Vec<usize>>,
    /// For each cell, the products (i, j), i <= j, of the m columns of the joint and of its torque (column m). The product (i, j)
    /// is at index j (m + 1) + i.
    pub(crate) products: BTreeMap<Cell, Vec<f64>>,
}

impl CellSize {
    /// All cell sizes, the smallest first.
    pub(crate) const ALL: [CellSize; 3] = [CellSize::Fine, CellSize::Coarse, CellSize::SpeedOnly];
}

impl StateCells {
    /// The range of valid indices of cells.
    pub(crate) const INDICES: std::ops::Range<i32> = -MAX_SLIDING_CELLS..MAX_SLIDING_CELLS;
    /// Largest number of cells per joint.
    pub(crate) const MOST_OF_JOINT: usize = (2 * MAX_SLIDING_CELLS + FASTEST_OCTAVE - SLOWEST_OCTAVE + 1) as usize;

    /// An empty set of cells of the smallest size.
    pub(crate) fn new(model: &Model) -> StateCells {
        let columns = model.layout.joints.iter().map(|joint| joint.columns.clone()).collect();
        StateCells { cell_size: CellSize::Fine, columns, products: BTreeMap::new() }
    }

    /// Adds the rows of a record.
    pub(crate) fn add(&mut self, model: &Model, states: &States) {
        // With all parameters zero, the residual is the torque itself, so the sums contain products with the torque.
        let none = vec![0.0; model.p()];
        let mut sums = CellSums::default();
        add_record(&mut sums, model, states, &none, &CellSums::default());
        self.take(sums.cells.into_iter().map(|(cell, products)| (cell, products.finish())));
    }

    /// Adds the rows of other cells, which have the same size.
    pub(crate) fn absorb(&mut self, other: StateCells) {
        self.take(other.products);
    }

    fn take(&mut self, cells: impl IntoIterator<Item = (Cell, Vec<f64>)>) {
        for (cell, products) in cells {
            match self.products.get_mut(&cell) {
                Some(sum) => sum.iter_mut().zip(&products).for_each(|(sum, product)| *sum += product),
                None => {
                    self.products.insert(cell, products);
                }
            }
        }
    }

    /// Merges cells until they have the size `grain`. If the cells are already as large or larger, nothing changes.
    pub(crate) fn fold_to(&mut self, grain: CellSize) {
        if grain <= self.cell_size {
            return;
        }
        self.cell_size = grain;
        let coarser = |cell: Cell| match (grain, cell.shared) {
            (CellSize::SpeedOnly, BandContent::Position) => None,
            (CellSize::SpeedOnly, BandContent::Speed) => Some(Cell { index: cell.index.div_euclid(2), ..cell }),
            (_, BandContent::Position) => Some(Cell { index: cell.index.div_euclid(CELLS_PER_FOLD), ..cell }),
            (_, BandContent::Speed) => Some(cell),
        };
        let cells = std::mem::take(&mut self.products).into_iter();
        self.take(cells.filter_map(|(cell, products)| Some((coarser(cell)?, products))));
    }

    /// Clusters of rows, by speed and by position, at the solution x. The rows of joint j are multiplied by `weights[j]`.
    pub(crate) fn clusters(&self, x: &[f64], weights: &[f64]) -> [Vec<Cluster>; 2] {
        let mut of = [Vec::new(), Vec::new()];
        for shared in [BandContent::Speed, BandContent::Position] {
            for (joint, columns) in self.columns.iter().enumerate() {
                let x: Vec<f64> = columns.iter().map(|&c| x[c]).collect();
                let square = weights[joint] * weights[joint];
                for products in self.bands(joint, shared) {
                    of[shared as usize].push(Cluster::of_products(columns.clone(), &residual(products, &x, square)));
                }
            }
        }
        of
    }

    /// The products of each band of a joint: sums over its cells.
    fn bands(&self, joint: usize, shared: BandContent) -> Vec<Vec<f64>> {
        let cells: Vec<(i32, &Vec<f64>)> = self
            .products
            .iter()
            .filter(|(cell, _)| cell.joint == joint && cell.shared == shared)
            .map(|(cell, products)| (cell.index, products))
            .collect();
        let last = cells.last().map_or(0, |(index, _)| *index);
        let mut bands: BTreeMap<i32, Vec<f64>> = BTreeMap::new();
        for (k, (index, products)) in cells.iter().enumerate() {
            let band = match shared {
                BandContent::Speed => (last - index).min(SPEED_BANDS - 1),
                BandContent::Position => (k * POSITION_BANDS.min(cells.len()) / cells.len()) as i32,
            };
            match bands.get_mut(&band) {
                Some(sum) => sum.iter_mut().zip(*products).for_each(|(sum, product)| *sum += product),
                None => {
                    bands.insert(band, (*products).clone());
                }
            }
        }
        bands.into_values().collect()
    }
}

/// Replaces the torque tau by the residual tau - W x in the products: W'(tau - W x) = W' tau - W'W x. All products are multiplied
/// by `square`. The last entry stays the square of the torque, because the square of the residual is not needed.
fn residual(mut products: Vec<f64>, x: &[f64], square: f64) -> Vec<f64> {
    let m = x.len();
    for i in 0..m {
        let fitted: f64 = (0..m).map(|k| products[i.max(k) * (m + 1) + i.min(k)] * x[k]).sum();
        products[m * (m + 1) + i] -= fitted;
    }
    products.iter_mut().for_each(|product| *product *= square);
    products
}

/// The sums of products of each cell, while a record is read.
#[derive(Clone, Default)]
struct CellSums {
    cells: BTreeMap<Cell, RowProducts>,
}

impl ResidualSum for CellSums {
    fn add(&mut self, model: &Model, group: &ResidualGroup) {
        let n = model.n();
        for (j, joint) in model.layout.joints.iter().enumerate() {
            // Eight successive samples are a group, and they are usually in the same cell. The group is added to every cell that
            // occurs in it; for each cell, the samples of other cells get the weight zero.
            let mut seen: Vec<(Cell, [f64; 8])> = Vec::new();
            for (lane, r) in group.samples.clone().enumerate().filter(|(_, r)| group.states.used[r * n + j]) {
                let position = position_cell(group.states, r * n + j, model.regressor.is_prismatic(j));
                for (shared, index) in
                    [(BandContent::Speed, octave(group.states.dq[r * n + j])), (BandContent::Position, position)]
                {
                    let cell = Cell { joint: j, shared, index };
                    let place = seen.iter().position(|(of, _)| *of == cell).unwrap_or_else(|| {
                        seen.push((cell, [0.0; 8]));
                        seen.len() - 1
                    });
                    seen[place].1[lane] = 1.0;
                }
            }
            let columns = joint.columns.len();
            for (cell, weights) in seen {
                let products = self.cells.entry(cell).or_insert_with(|| RowProducts::new(columns));
                products.push(&joint.places[..columns], group.entries, &group.residuals[j], &weights);
            }
        }
    }

    fn append(&mut self, next: Self) {
        for (cell, products) in next.cells {
            match self.cells.get_mut(&cell) {
                Some(sum) => sum.append(products),
                None => {
                    self.cells.insert(cell, products);
                }
            }
        }
    }
}

/// floor(log2 |dq|), taken from the exponent bits of the number.
fn octave(dq: f64) -> i32 {
    let exponent = ((dq.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    exponent.clamp(SLOWEST_OCTAVE, FASTEST_OCTAVE)
}

fn position_cell(states: &States, at: usize, slides: bool) -> i32 {
    match slides {
        // A value that is too large for an index gets the largest index.
        true => ((states.q[at] / CELL_LENGTH).floor() as i32).clamp(-MAX_SLIDING_CELLS, MAX_SLIDING_CELLS - 1),
        false => ((states.q[at].rem_euclid(TAU) / TAU * CELLS_PER_TURN) as i32).min(CELLS_PER_TURN as i32 - 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;
    use identification::estimators::clusters::FullNormalMatrix;
    use identification::estimators::replicate_deviation::{by_band, state_bands, white_deviation};
    use identification::estimators::weighted::{Weights, fit};
    use identification::rows::observation::{Observation, weighted};
    use identification::rows::residual_sums::residual_sums;
    use random::Random;

    #[test]
    fn each_row_is_in_one_cell_of_either_kind() {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &[], &[]);
        let (mut states, mut random) = (arm.states(20_000), Random::new(3));
        states.tau.iter_mut().for_each(|tau| *tau += 0.1 * random.normal());
        // An unused row may contain any values, also NaN.
        (states.used[7], states.tau[7], states.ddq[7]) = (false, f64::NAN, f64::NAN);
        let joints = Observation::of(&model, &states, 1).joints(|_| true);
        let (solution, _) = fit(&joints, Weights::Joint);
        let whole = Cluster::of(&joints[0], &solution.x);
        let mut cells = StateCells::new(&model);
        cells.add(&model, &states);
        let mut counts = Vec::new();
        for grain in CellSize::ALL {
            cells.fold_to(grain);
            let clusters = cells.clusters(&solution.x, &[1.0]);
            counts.push(clusters.each_ref().map(Vec::len));
            for of_kind in clusters.iter().filter(|of_kind| !of_kind.is_empty()) {
                let sum = Cluster::sum(3, of_kind);
                let (sum, score) = sum.parts();
                let (expected, none) = whole.parts();
                let scale = expected.norm();
                // Tolerance for twenty thousand rows, each with a rounding error of 1e-16 of the norm.
                assert!((sum - expected).norm() < 1e-11 * scale, "{grain:?}");
                assert!((score - none).norm() < 1e-11 * scale, "{grain:?}");
            }
        }
        assert!(counts[0] == [5, 8] && counts[1][1] < 8 && counts[2][1] == 0, "{counts:?}");
    }

    #[test]
    fn what_the_model_lacks_is_in_the_deviation() {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &[], &[]);
        let mut states = arm.states(700);
        for (tau, dq) in states.tau.iter_mut().zip(&states.dq) {
            *tau += 0.5 * dq.signum() * (-(dq / 0.5).abs()).exp();
        }
        let observation = Observation::of(&model, &states, 20);
        let joints = observation.joints(|_| true);
        let (solution, weights) = fit(&joints, Weights::Joint);
        let mut cells = StateCells::new(&model);
        cells.add(&model, &states);
        let whole = FullNormalMatrix::of(&weighted(&joints, &weights));
        let found = cells.clusters(&solution.x, &weights).map(|bands| by_band(&whole, &bands, 1.0));
        let records = [states];
        let bands = state_bands(&model, &observation, &weights, None);
        let bands = residual_sums(&model, &records[..], &solution.x, bands).unwrap();
        let expected = bands.clusters(&model).map(|bands| by_band(&whole, &bands, 1.0));
        for (found, expected) in found.iter().zip(&expected) {
            // With five draws, a standard deviation has a relative uncertainty of a third. The two results use bands with
            // different limits, so their draws differ.
            assert!(found.iter().zip(expected).all(|(a, b)| (0.4..2.5).contains(&(a / b))), "{found:?} {expected:?}");
        }
        assert!(found[0].iter().zip(white_deviation(&solution)).any(|(speed, white)| *speed > 2.0 * white));
    }

    #[test]
    fn every_state_has_a_cell() {
        let of = |q: f64| position_cell(&States { q: vec![q], ..States::default() }, 0, false);
        assert_eq!((of(0.1), of(0.1 + 100.0 * TAU), of(-0.01)), (0, 0, 31));
        for q in [0.0, -0.0, 1e300, -1e300, f64::MIN_POSITIVE, -1e-300] {
            let states = States { q: vec![q], ..States::default() };
            let cells = [true, false].map(|slides| position_cell(&states, 0, slides));
            assert!(cells.iter().all(|cell| StateCells::INDICES.contains(cell)), "{cells:?}");
        }
        assert_eq!([0.0, 1e-300, 0.26, -0.5, 0.999, 1e300].map(octave), [-8, -8, -2, -1, -1, 10]);
    }
}
