//! Represents one log by triangles (R of the QR decompositions of blocks of its rows), data on the log, and statistics of the
//! joints' motion.
//!
//! A log is stored in `MAX_BLOCKS_PER_LOG` blocks. If more logs are added, four consecutive blocks are merged into one
//! (`accumulator`). It makes no difference, bit for bit, at which time the blocks of a log are merged.
//!
//! A hypothesis is a possible fault of a log (for example a wrong sign), tested as one additional unknown. The digest of a log
//! is a hash of its samples, by which the log is recognised under another name.

use linear_model::linear_model::Model;
use logs::{Error, Log, LogSource};
use numerics::triangle::Triangle;
use serde::{Deserialize, Serialize};

use crate::state_cells::{CellSize, StateCells};
use identification::estimate::claims::hypotheses::{FitPoint, UndeterminedMechanics, hypotheses_of, triangles};
use identification::estimators::weighted::{Weights, fit};
use identification::rows::observation::{Observation, sum_by_joint};
use identification::signals::records::{Records, SourceRecords};

/// Largest number of blocks of one log.
pub(crate) const MAX_BLOCKS_PER_LOG: usize = 16;

/// Largest number of segments of one log that have separate triangles for the tests of hypotheses.
pub(super) const MAX_FAULT_PARTS_PER_LOG: usize = 8;

/// Number of consecutive blocks that are merged into one.
const BLOCKS_PER_FOLD: usize = 4;

/// Data on one log whose rows are in the sums.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LogAccount {
    /// Name of the file, as given by the user.
    pub name: String,
    /// Digest of the samples. It identifies the log even if the file has another name.
    pub digest: String,
    /// Number of rows of the file.
    pub rows: usize,
    /// Number of rows with finite values and increasing time.
    pub kept: usize,
    /// Number of samples after filtering, removal of the ends, and decimation.
    pub samples: usize,
    /// Time from the first row to the last, s.
    pub duration: f64,
    /// Time between rows, s.
    pub period: f64,
}

/// The rows that count as one independent unit for standard deviations: usually one log, or several logs whose residuals may be
/// correlated.
#[derive(Clone, Debug)]
pub struct Replicate {
    /// Data on the logs, in the order of their names.
    pub logs: Vec<LogAccount>,
    /// The triangles (R of QR decompositions) of each block and joint, and statistics of the joints' motion.
    pub observation: Observation,
    /// The rows, sorted by the state of their joint.
    pub cells: StateCells,
    /// Triangles (R of QR decompositions) of some rows with the columns of the hypotheses, one per segment of the log. The rows
    /// are weighted by a fit to this log alone. Empty if no hypothesis is tested.
    pub faults: Vec<Triangle>,
}

impl Replicate {
    /// Makes the replicate of the records of one log.
    ///
    /// `open`: unknowns of the robot that are not parameters of the model (the mount of the base, rotors). Fails if the records
    /// cannot be read.
    pub fn of(
        model: &Model,
        log: &LogSource,
        records: &SourceRecords,
        open: UndeterminedMechanics,
    ) -> Result<Replicate, Error> {
        let (mut all, mut samples): (Option<Observation>, usize) = (None, 0);
        let mut cells = StateCells::new(model);
        records.each(&mut |states| {
            // Each record adds blocks, which are merged below.
            let one = Observation::of(model, states, MAX_BLOCKS_PER_LOG);
            samples += states.len();
            cells.add(model, states);
            match &mut all {
                Some(all) => all.append(one),
                None => all = Some(one),
            }
        })?;
        let Some(mut observation) = all else {
            return Err(Error::at(&log.name(), 0, "no sample of it remains"));
        };
        while observation.parts.len() > MAX_BLOCKS_PER_LOG {
            fold(&mut observation, 2);
        }
        let report = log.report();
        let account = LogAccount {
            name: log.name(),
            digest: format!("{:016x}", digest(log)?),
            rows: report.rows,
            kept: report.kept,
            samples,
            duration: report.clock.duration,
            period: report.clock.period,
        };
        // The rows for tests of faults need weights. They come from a fit to this log alone, because the sums over logs have no
        // rows.
        let (solution, weights) = fit(&observation.joints(|_| true), Weights::Joint);
        let point = FitPoint { x: &solution.x, weights: &weights, robust: None };
        let faults = of_hypotheses(model, records, point, open, MAX_FAULT_PARTS_PER_LOG)?;
        Ok(Replicate { logs: vec![account], observation, cells, faults })
    }

    /// Name and digest of the first log, by which replicates are sorted. `None` if there is no log.
    pub fn key(&self) -> Option<(&str, &str)> {
        self.logs.first().map(|log| (log.name.as_str(), log.digest.as_str()))
    }

    /// Merges consecutive blocks until at most `blocks` remain.
    pub(crate) fn fold_to(&mut self, blocks: usize) {
        while self.observation.parts.len() > blocks.max(1) {
            fold(&mut self.observation, BLOCKS_PER_FOLD);
        }
        let parts = blocks * MAX_FAULT_PARTS_PER_LOG / MAX_BLOCKS_PER_LOG;
        while self.faults.len() > parts.max(1) {
            fold_faults(&mut self.faults);
        }
        self.cells.fold_to(match blocks {
            0..=1 => CellSize::SpeedOnly,
            MAX_BLOCKS_PER_LOG.. => CellSize::Fine,
            _ => CellSize::Coarse,
        });
    }

    /// Adds the rows of another replicate. This replicate must have a single block.
    pub fn absorb(&mut self, mut other: Replicate) {
        self.logs.append(&mut other.logs);
        self.logs.sort_by(|a, b| (&a.name, &a.digest).cmp(&(&b.name, &b.digest)));
        self.observation.append(other.observation);
        self.cells.absorb(other.cells);
        self.faults.append(&mut other.faults);
        fold_faults(&mut self.faults);
        let blocks = self.observation.parts.len();
        fold(&mut self.observation, blocks);
    }
}

/// Merges every four consecutive triangles (R of QR decompositions) into one.
fn fold_faults(parts: &mut Vec<Triangle>) {
    *parts = parts.chunks(BLOCKS_PER_FOLD).map(|some| Triangle::sum(some[0].columns(), some)).collect();
}

/// Merges every `together` consecutive blocks into one.
fn fold(observation: &mut Observation, together: usize) {
    observation.parts = observation.parts.chunks(together.max(2)).map(sum_by_joint).collect();
    observation.log_of.truncate(observation.parts.len());
}

/// A hash similar to FNV-1a, but it processes one word of 8 bytes at a time and rotates the result.
#[derive(Clone, Copy)]
pub struct Digest(pub u64);

impl Digest {
    /// The digest before any words.
    pub const EMPTY: Digest = Digest(0xcbf2_9ce4_8422_2325);

    /// The digest after one more word.
    pub fn word(self, word: u64) -> Digest {
        Digest((self.0 ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29))
    }

    /// The digest after these bytes, followed by the number of bytes.
    pub fn bytes(self, bytes: &[u8]) -> Digest {
        let word = |chunk: &[u8]| chunk.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte));
        bytes.chunks(8).fold(self, |digest, chunk| digest.word(word(chunk))).word(bytes.len() as u64)
    }
}

/// Digest of all samples of a log: times, positions, velocities, efforts.
fn digest(log: &LogSource) -> Result<u64, Error> {
    let mut digest = Digest::EMPTY;
    let mut add = |part: &Log| {
        let series = std::iter::once(&part.t).chain(&part.q).chain(part.dq.iter().flatten()).chain(&part.effort);
        digest = series.flatten().fold(digest, |digest, x| digest.word(x.to_bits()));
    };
    match log {
        LogSource::Held(log) => add(log),
        LogSource::Streamed(stream) => stream.each(&mut |part| {
            add(part);
            Ok(())
        })?,
    }
    Ok(digest.0)
}

/// The triangles (R of QR decompositions) for tests of hypotheses: one per segment of a record, with the weights of a fit to this
/// log alone. Empty if there are no hypotheses.
///
/// Fails if a record cannot be read.
pub(crate) fn of_hypotheses<R: Records + ?Sized>(
    model: &Model,
    records: &R,
    fit: FitPoint,
    open: UndeterminedMechanics,
    parts: usize,
) -> Result<Vec<Triangle>, Error> {
    let all = hypotheses_of(model, open);
    if all.is_empty() { Ok(Vec::new()) } else { Ok(triangles(model, records, fit, open, &all, parts)?.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;

    #[test]
    fn folding_forgets_its_steps() {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &[], &[]);
        let observation = Observation::of(&model, &arm.states(1000), MAX_BLOCKS_PER_LOG);
        let mut cells = StateCells::new(&model);
        cells.add(&model, &arm.states(1000));
        let faults = observation.parts[..MAX_FAULT_PARTS_PER_LOG].iter().map(|part| part[0].clone()).collect();
        let whole = Replicate { logs: Vec::new(), observation, cells, faults };
        let (mut at_once, mut slowly) = (whole.clone(), whole);
        at_once.fold_to(1);
        slowly.fold_to(4);
        assert_eq!(slowly.observation.parts.len(), 4);
        slowly.fold_to(1);
        assert_eq!(at_once.observation.parts, slowly.observation.parts);
        assert_eq!(at_once.observation.parts.len(), 1);
        assert_eq!(at_once.cells, slowly.cells);
        assert!(at_once.faults == slowly.faults && at_once.faults.len() == 1);
    }
}
