//! Writes and reads the numbers after the head of a `.tri` file: triangles (R of QR decompositions), statistics of the joints'
//! motion, cells of states. `tri_file` defines their order.
//!
//! All numbers have eight bytes. The memory for the numbers of a file is taken from a budget, so that a damaged file cannot
//! exhaust the memory.

use std::collections::BTreeMap;

use gate::budget::Budget;
use numerics::triangle::Triangle;

use crate::replicate::{MAX_BLOCKS_PER_LOG, MAX_FAULT_PARTS_PER_LOG};
use crate::state_cells::{Cell, CellSize, StateCells};
use identification::estimators::state_bands::BandContent;
use identification::rows::observation::Observation;

/// Collects the numbers that are written to a file, as bytes.
#[derive(Default)]
pub(super) struct NumberWriter(pub(super) Vec<u8>);

impl NumberWriter {
    fn word(&mut self, x: u64) {
        self.0.extend_from_slice(&x.to_le_bytes());
    }

    fn number(&mut self, x: f64) {
        self.word(x.to_bits());
    }

    pub(super) fn replicate(&mut self, observation: &Observation, has_springs: bool) {
        self.word(observation.parts.len() as u64);
        observation.parts.iter().flatten().for_each(|triangle| self.triangle(triangle));
        let of_springs = observation.parts.iter().flatten().filter(|_| has_springs);
        of_springs.for_each(|triangle| self.number(triangle.taken_out));
        for k in 0..observation.range.len() {
            let of = [observation.range[k].0, observation.range[k].1, observation.speed[k], observation.effort[k]];
            of.into_iter().chain([observation.f95.get(k).copied().unwrap_or(0.0)]).for_each(|x| self.number(x));
            self.word(observation.still[k] as u64);
        }
        self.number(observation.cutoff);
    }

    pub(super) fn cells(&mut self, cells: &StateCells) {
        self.word(cells.cell_size as u64);
        for columns in &cells.columns {
            self.word(columns.len() as u64);
            columns.iter().for_each(|&c| self.word(c as u64));
        }
        self.word(cells.products.len() as u64);
        for (cell, products) in &cells.products {
            self.word(cell.joint as u64);
            self.word(cell.shared as u64);
            self.word(i64::from(cell.index) as u64);
            let width = cells.columns[cell.joint].len() + 1;
            for (j, column) in products.chunks_exact(width).enumerate() {
                column[..=j].iter().for_each(|&x| self.number(x));
            }
        }
    }

    pub(super) fn faults(&mut self, faults: &[Triangle]) {
        self.word(faults.len() as u64);
        faults.iter().for_each(|triangle| self.triangle(triangle));
    }

    pub(super) fn triangle(&mut self, triangle: &Triangle) {
        let live = triangle.live();
        self.word(triangle.rows as u64);
        self.word(live.len() as u64);
        live.iter().for_each(|&c| self.word(c as u64));
        for (k, &j) in live.iter().enumerate() {
            live[..=k].iter().for_each(|&i| self.number(triangle.at(i, j)));
        }
    }
}

/// Reads the numbers of a file one after the other. Its functions return `None` if too few numbers are left.
pub(super) struct WordReader<'a> {
    pub(super) left: &'a [u8],
    /// Memory that triangles may still use.
    pub(super) budget: Budget,
    /// If the memory budget was exceeded, the message that says so; otherwise `None`.
    pub(super) excess: Option<String>,
}

impl WordReader<'_> {
    fn word(&mut self) -> Option<u64> {
        let (first, rest) = self.left.split_first_chunk::<8>()?;
        self.left = rest;
        Some(u64::from_le_bytes(*first))
    }

    fn number(&mut self) -> Option<f64> {
        self.word().map(f64::from_bits).filter(|x| x.is_finite())
    }

    fn count(&mut self, most: usize) -> Option<usize> {
        self.word().and_then(|x| usize::try_from(x).ok()).filter(|&x| x <= most)
    }

    pub(super) fn replicate(&mut self, n: usize, p: usize, has_springs: bool) -> Option<Observation> {
        let blocks = self.count(MAX_BLOCKS_PER_LOG).filter(|&blocks| blocks > 0)?;
        let part = |words: &mut Self| (0..n).map(|_| words.triangle(p)).collect::<Option<Vec<Triangle>>>();
        let mut parts = (0..blocks).map(|_| part(self)).collect::<Option<Vec<_>>>()?;
        for triangle in parts.iter_mut().flatten().filter(|_| has_springs) {
            triangle.taken_out = self.number()?;
        }
        let mut observation = Observation { parts, log_of: vec![0; blocks], ..Observation::default() };
        for _ in 0..n {
            observation.range.push((self.number()?, self.number()?));
            observation.speed.push(self.number()?);
            observation.effort.push(self.number()?);
            observation.f95.push(self.number()?);
            observation.still.push(self.count(usize::MAX)?);
        }
        observation.cutoff = self.number()?;
        Some(observation)
    }

    pub(super) fn cells(&mut self, n: usize, p: usize) -> Option<StateCells> {
        let grain = CellSize::ALL.get(self.count(CellSize::ALL.len() - 1)?).copied()?;
        let mut columns = Vec::new();
        for _ in 0..n {
            let count = self.count(p)?;
            let of_joint = (0..count).map(|_| self.count(p.checked_sub(1)?)).collect::<Option<Vec<usize>>>()?;
            // Indices must be ascending, so that no column occurs twice.
            columns.push(Some(of_joint).filter(|of| of.is_sorted_by(|a, b| a < b))?);
        }
        let count = self.count(n * StateCells::MOST_OF_JOINT)?;
        let mut products = BTreeMap::new();
        for _ in 0..count {
            let joint = self.count(n.checked_sub(1)?)?;
            let shared = [BandContent::Speed, BandContent::Position].get(self.count(1)?).copied()?;
            let index = i32::try_from(self.word()? as i64).ok().filter(|i| StateCells::INDICES.contains(i))?;
            let width = columns[joint].len() + 1;
            if let Err(excess) = self.budget.draw(16 * width * width) {
                self.excess = Some(excess);
                return None;
            }
            let mut of_cell = vec![0.0; width * width];
            for (j, column) in of_cell.chunks_exact_mut(width).enumerate() {
                column[..=j].iter_mut().try_for_each(|x| self.number().map(|number| *x = number))?;
            }
            products.insert(Cell { joint, shared, index }, of_cell);
        }
        Some(StateCells { cell_size: grain, columns, products })
    }

    /// Reads the triangles for tests of faults; each has `width` columns. If no hypothesis is tested, there must be none.
    pub(super) fn faults(&mut self, width: usize, is_tested: bool) -> Option<Vec<Triangle>> {
        let count = self.count(if is_tested { MAX_FAULT_PARTS_PER_LOG } else { 0 })?;
        (0..count).map(|_| self.triangle(width)).collect()
    }

    pub(super) fn triangle(&mut self, p: usize) -> Option<Triangle> {
        let rows = self.count(usize::MAX / 1024)?;
        let count = self.count(p + 1)?;
        // While a triangle is read, its entries are in memory twice, so twice its size is taken from the budget.
        if let Err(excess) = self.budget.draw(Triangle::bytes(p, count).saturating_mul(2)) {
            self.excess = Some(excess);
            return None;
        }
        let live = (0..count).map(|_| self.count(p)).collect::<Option<Vec<usize>>>()?;
        let numbers = (0..count * (count + 1) / 2).map(|_| self.number()).collect::<Option<Vec<f64>>>()?;
        Triangle::of_numbers(p, &live, rows, &numbers)
    }
}
