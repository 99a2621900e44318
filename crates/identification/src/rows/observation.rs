//! The observation matrix W, block by block: the rows of many samples are reduced to one triangle (R of QR) per joint.
//!
//! tau_j = (Y(q, dq, ddq))_j X + friction_j + coupling_j. The parameters are the base parameters, then the friction of each
//! joint, then the couplings of the transmission. W is never stored: blocks of 128 rows, without zero columns, are computed
//! and folded into the triangle while they are in the cache. The triangle of a joint has only the columns on which its
//! torque can depend. Different joints have separate triangles, so weights by joint need no second pass over the data.
//! Blocks of the record have separate triangles too, so cross-validation needs no second pass either.

use std::cell::RefCell;
use std::ops::Range;

use linear_model::linear_model::Model;
use linear_model::states::States;
use logs::Error;
use numerics::triangle::{ColumnTriangle, Triangle, select};
use processor::{in_parallel, threads};

use crate::rows::column_sizes::{NEGLIGIBLE_COLUMN_SHARE, column_sizes};
use crate::signals::records::Records;

/// Row weights that depend on the residual: `weight(j, tau - W x)` is the factor of a row of joint j.
#[derive(Clone, Copy)]
pub struct RowWeight<'a> {
    /// Parameters x with which the residual is computed.
    pub x: &'a [f64],
    /// Function from joint number and residual to the factor of a row.
    pub weight: &'a (dyn Fn(usize, f64) -> f64 + Sync),
}

/// Least number of samples for which threads are started. With fewer samples, starting threads takes longer than the threads
/// save. A log of twenty thousand rows has about this number of samples after decimation.
const MIN_SAMPLES_FOR_THREADS: usize = 2_000;

/// Makes one triangle (R of QR) per joint from the samples in `range`. `weight`: factors of the rows; `None`: all factors are 1.
/// `least`: for each base column, the rms up to which the column is set to zero.
fn part_of_rows(
    model: &Model,
    states: &States,
    range: Range<usize>,
    weight: Option<RowWeight>,
    least: &[f64],
) -> Vec<Triangle> {
    let n = model.n();
    let mut triangles: Vec<ColumnTriangle> =
        model.layout.joints.iter().map(|joint| ColumnTriangle::new(&joint.columns, &joint.places)).collect();
    let mut taken_out = vec![0.0; n];
    model.blocks(states, range, |first, block| {
        let end = first + block.rows;
        for (j, triangle) in triangles.iter_mut().enumerate() {
            let mut used = 0;
            for (g, r) in (first..end).step_by(8).enumerate() {
                let group = block.group(g);
                let residual = weight.map(|by| model.residual(group, j, by.x));
                let factors: [f64; 8] = std::array::from_fn(|lane| {
                    let counts = r + lane < end && states.used[(r + lane) * n + j];
                    used += usize::from(counts);
                    match (weight, residual) {
                        (Some(by), Some(residual)) if counts => (by.weight)(j, residual[lane]),
                        _ => f64::from(u8::from(counts)),
                    }
                });
                if !model.springs.is_empty() {
                    for (lane, factor) in factors.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
                        let (tau, spring) = (states.tau[(r + lane) * n + j], model.spring(states, r + lane, j));
                        taken_out[j] += factor * factor * spring * (2.0 * tau + spring);
                    }
                }
                if factors == [1.0; 8] {
                    continue;
                }
                for &place in &model.layout.joints[j].places {
                    for (x, factor) in group[place].0.iter_mut().zip(factors) {
                        // An unused row may contain NaN, and 0 * NaN is NaN. So the entries of an unused row are set to zero.
                        *x = if factor == 0.0 { 0.0 } else { factor * *x };
                    }
                }
            }
            triangle.fold(block, used);
        }
    });
    let finished = triangles.into_iter().map(|triangle| triangle.finish(model.p(), least));
    finished.zip(taken_out).map(|(triangle, taken_out)| triangle.with_taken_out(taken_out)).collect()
}

/// For each base column, the rms up to which the column is set to zero. Reason: columns of joints at standstill contain only
/// rounding errors.
fn negligible(model: &Model, states: &States) -> Vec<f64> {
    let most = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let sizes = column_sizes(model.regressor, most(&states.dq), most(&states.ddq));
    sizes.into_iter().map(|size| NEGLIGIBLE_COLUMN_SHARE * size).collect()
}

/// The triangles (R of QR) of the rows, one per block of the record and joint, and the range, speed and torque of each joint.
#[derive(Clone, Debug, Default)]
pub struct Observation {
    /// The triangles: `parts[k][j]` for block k of the record and joint j.
    pub parts: Vec<Vec<Triangle>>,
    /// For each block, the number of its log.
    pub log_of: Vec<usize>,
    /// Smallest and largest position of each coordinate, rad (m).
    pub range: Vec<(f64, f64)>,
    /// Largest magnitude of the velocity of each coordinate, rad/s (m/s).
    pub speed: Vec<f64>,
    /// Largest magnitude of the torque of each coordinate, N m (N).
    pub effort: Vec<f64>,
    /// Bandwidth of each coordinate, Hz: the frequency below which 95 % of the energy of the velocity lies. Of several records,
    /// the largest value is taken.
    pub f95: Vec<f64>,
    /// For each coordinate, the number of samples that are not used because the coordinate is at standstill.
    pub still: Vec<usize>,
    /// Cut-off of the low-pass filter in the first record, Hz.
    pub cutoff: f64,
}

/// Wraps records so that the first pass over them also computes the rows of the regressor. A separate pass would read and filter
/// the logs again.
pub struct SinglePass<'a, R: ?Sized> {
    model: &'a Model<'a>,
    records: &'a R,
    rows: RefCell<Option<Observation>>,
}

impl<R: Records + ?Sized> Records for SinglePass<'_, R> {
    fn each(&self, take: &mut dyn FnMut(&States)) -> Result<(), Error> {
        if self.rows.borrow().is_some() {
            return self.records.each(take);
        }
        let mut rows: Option<Observation> = None;
        self.records.each(&mut |states| {
            take(states);
            let one = Observation::of(self.model, states, self.parts());
            match &mut rows {
                Some(rows) => rows.append(one),
                None => rows = Some(one),
            }
        })?;
        *self.rows.borrow_mut() = rows;
        Ok(())
    }

    fn parts(&self) -> usize {
        self.records.parts()
    }
}

/// Largest number of blocks of an observation. If there are more, neighbours are merged in pairs.
const MAX_BLOCKS: usize = 64;

impl Observation {
    /// Computes the triangles of one record, in `parts` contiguous blocks of equal length.
    pub fn of(model: &Model, states: &States, parts: usize) -> Observation {
        Observation::of_rows(model, states, parts, None)
    }

    /// Computes the triangles of all records, with row weights if given.
    ///
    /// Fails if there is no record, or if a record cannot be read.
    pub fn of_records<R: Records + ?Sized>(
        model: &Model,
        records: &R,
        weight: Option<RowWeight>,
    ) -> Result<Observation, Error> {
        let mut all: Option<Observation> = None;
        records.each(&mut |states| {
            let one = Observation::of_rows(model, states, records.parts(), weight);
            match &mut all {
                Some(all) => all.append(one),
                None => all = Some(one),
            }
        })?;
        all.ok_or_else(|| Error::new("no log is given; at least one is needed"))
    }

    /// Runs `look` on the records. During the first pass of `look`, also computes the triangles of the records. Returns the
    /// result of `look` and the triangles. The triangles are `None` if `look` makes no pass.
    ///
    /// Fails if a record cannot be read, or if `look` fails.
    pub fn in_one_pass<R: Records + ?Sized, T, E: From<Error>>(
        model: &Model,
        records: &R,
        look: impl FnOnce(&SinglePass<R>) -> Result<T, E>,
    ) -> Result<(T, Option<Observation>), E> {
        let beside = SinglePass { model, records, rows: RefCell::default() };
        let found = look(&beside)?;
        Ok((found, beside.rows.into_inner()))
    }

    /// Computes the triangles of one record in `parts` blocks, with row weights if given.
    fn of_rows(model: &Model, states: &States, parts: usize, weight: Option<RowWeight>) -> Observation {
        let (n, len) = (model.n(), states.len());
        let parts = parts.clamp(1, len.max(1));
        let least = negligible(model, states);
        let part = |k: usize| part_of_rows(model, states, k * len / parts..(k + 1) * len / parts, weight, &least);
        // Blocks are independent, so the result does not depend on the number of threads.
        let threads = if len < MIN_SAMPLES_FOR_THREADS { 1 } else { threads() };
        let triangles = in_parallel((0..parts).collect(), threads, part);
        let over = |x: &[f64], f: &dyn Fn(f64, f64) -> f64, start: f64| -> Vec<f64> {
            (0..n).map(|j| x.iter().skip(j).step_by(n).fold(start, |a, &b| f(a, b))).collect()
        };
        let (low, high) = (over(&states.q, &f64::min, f64::MAX), over(&states.q, &f64::max, f64::MIN));
        let largest = |x: &[f64]| over(x, &|a, b| a.max(b.abs()), 0.0);
        let (speed, effort) = (largest(&states.dq), largest(&states.tau));
        let range = low.into_iter().zip(high).collect();
        let still = (0..n).map(|j| states.used.iter().skip(j).step_by(n).filter(|used| !**used).count()).collect();
        let log_of = vec![states.log; parts];
        Observation {
            parts: triangles,
            log_of,
            range,
            speed,
            effort,
            f95: states.f95.clone(),
            still,
            cutoff: states.cutoff,
        }
    }

    /// Appends the blocks of another record.
    pub fn append(&mut self, other: Observation) {
        self.parts.extend(other.parts);
        self.log_of.extend(other.log_of);
        while self.parts.len() > MAX_BLOCKS {
            self.merge_pairs();
        }
        for (a, b) in self.range.iter_mut().zip(other.range) {
            *a = (a.0.min(b.0), a.1.max(b.1));
        }
        let largest = self.speed.iter_mut().chain(&mut self.effort).zip(other.speed.into_iter().chain(other.effort));
        largest.for_each(|(a, b)| *a = a.max(b));
        self.f95.iter_mut().zip(other.f95).for_each(|(a, b)| *a = a.max(b));
        self.still.iter_mut().zip(other.still).for_each(|(a, b)| *a += b);
    }

    /// Merges each block with the next block of the same log. If no log has two blocks, blocks of different logs are merged.
    fn merge_pairs(&mut self) {
        let has_pairs = self.log_of.windows(2).any(|pair| pair[0] == pair[1]);
        let all = std::mem::take(&mut self.parts).into_iter().zip(std::mem::take(&mut self.log_of));
        let mut is_single = false;
        for (part, log) in all {
            let is_of_last = is_single && (!has_pairs || self.log_of.last() == Some(&log));
            match self.parts.last_mut().filter(|_| is_of_last) {
                Some(last) => last.iter_mut().zip(&part).for_each(|(a, b)| a.merge(b, 1.0)),
                None => {
                    self.parts.push(part);
                    self.log_of.push(log);
                }
            }
            is_single = !is_of_last;
        }
    }

    /// If there are several logs: the number of each log and the triangles of its joints. Empty if there is only one log.
    pub fn logs(&self) -> Vec<(usize, Vec<Triangle>)> {
        let mut numbers = self.log_of.clone();
        numbers.dedup();
        if numbers.len() < 2 {
            return Vec::new();
        }
        numbers.into_iter().map(|log| (log, self.joints(|k| self.log_of[k] == log))).collect()
    }

    /// A copy of the observation with only these columns.
    pub fn select(&self, columns: &[usize]) -> Observation {
        let part = |part: &Vec<Triangle>| part.iter().map(|triangle| select(triangle, columns)).collect();
        Observation { parts: self.parts.iter().map(part).collect(), ..self.seen() }
    }

    /// A copy without the triangles: for each joint the range of positions, speed, effort, bandwidth and standstill, the cut-off,
    /// and for each part the index of its log.
    fn seen(&self) -> Observation {
        Observation {
            parts: Vec::new(),
            log_of: self.log_of.clone(),
            range: self.range.clone(),
            speed: self.speed.clone(),
            effort: self.effort.clone(),
            f95: self.f95.clone(),
            still: self.still.clone(),
            cutoff: self.cutoff,
        }
    }

    /// One triangle per joint, merged from the blocks that `take` selects.
    pub fn joints(&self, take: impl Fn(usize) -> bool) -> Vec<Triangle> {
        let chosen = self.parts.iter().enumerate().filter(|(k, _)| take(*k)).map(|(_, part)| part);
        let sum = sum_by_joint(chosen);
        match self.parts.first() {
            Some(part) if sum.is_empty() => part.iter().map(|t| Triangle::new(t.columns())).collect(),
            _ => sum,
        }
    }
}

/// Merges several blocks to one triangle per joint; empty if there is no block.
pub fn sum_by_joint<'a>(parts: impl IntoIterator<Item = &'a Vec<Triangle>>) -> Vec<Triangle> {
    let mut parts = parts.into_iter();
    let mut joints = parts.next().cloned().unwrap_or_default();
    for part in parts {
        joints.iter_mut().zip(part).for_each(|(joint, triangle)| joint.merge(triangle, 1.0));
    }
    joints
}

/// Merges the triangles of all joints to one, with the rows of joint j multiplied by `weights[j]`.
pub fn weighted(joints: &[Triangle], weights: &[f64]) -> Triangle {
    let mut total = Triangle::new(joints.first().map_or(0, Triangle::columns));
    for (joint, &weight) in joints.iter().zip(weights) {
        total.merge(joint, weight);
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::{Made, Pendulum, pendulum};
    use linear_model::friction::terms::FrictionTerm;

    #[test]
    fn threads_change_no_bit() {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &FrictionTerm::STANDARD, &[]);
        let states = arm.states(MIN_SAMPLES_FOR_THREADS + 1);
        let threaded = Observation::of(&model, &states, 7);
        for (k, part) in threaded.parts.iter().enumerate() {
            let range = k * states.len() / 7..(k + 1) * states.len() / 7;
            assert_eq!(*part, part_of_rows(&model, &states, range, None, &negligible(&model, &states)));
        }
        assert_eq!(threaded.joints(|_| true)[0].rows, states.len());
    }

    #[test]
    fn parts_are_merged_within_their_log() {
        let (arm, model) = pendulum();
        // Each pair: (number of logs, number of blocks per log). With more than 64 logs, blocks of different logs are merged.
        for (logs, parts) in [(3, 20), (7, 20), (15, 6), (60, 1), (100, 1)] {
            let one = |log: usize| Observation::of(&model, &States { log, ..arm.states(40 + log) }, parts);
            let mut all = one(0);
            (1..logs).for_each(|log| all.append(one(log)));
            assert!(all.parts.len() <= MAX_BLOCKS && all.parts.len() == all.log_of.len(), "{logs} {}", all.parts.len());
            let rows: usize = all.logs().iter().map(|(_, joints)| joints[0].rows).sum();
            assert_eq!(rows, (0..logs).map(|log| 40 + log).sum::<usize>());
            assert!(one(0).logs().is_empty());
            if logs <= MAX_BLOCKS {
                let of = all.logs().iter().map(|(log, joints)| (*log, joints[0].rows)).collect::<Vec<_>>();
                assert_eq!(of, (0..logs).map(|log| (log, 40 + log)).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn a_prismatic_joint_has_units_and_distances_of_its_own() {
        let (arm, slide) = (Pendulum::new(), Made::new(&[true], 3, |_, y| y.fill(0.0)));
        let friction = [FrictionTerm::Viscous, FrictionTerm::Coulomb, FrictionTerm::Rotor];
        let model = Model::new(&slide, &friction, &[]);
        let units: Vec<String> = model.parameters[3..].iter().map(|p| p.unit().to_string()).collect();
        assert_eq!(units, ["N s/m", "N", "kg"]);
        // A range of 0.2 m is a full stroke of a prismatic joint, but 0.2 rad is little motion for a revolute one.
        let observation = Observation { range: vec![(0.0, 0.2)], speed: vec![0.0], ..Observation::default() };
        assert_eq!(crate::estimate::remarks::little_motion(&model, &observation), [false]);
        assert_eq!(crate::estimate::remarks::little_motion(&Model::new(&arm, &[], &[]), &observation), [true]);
    }
}
