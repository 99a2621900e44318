//! The rows of one block of a long log. They are in compressed blocks in memory, or are read from a file.
//!
//! A block has a fixed number of rows of the file. A series is one signal of one coordinate. The report on the cleaning of the
//! whole log is collected block by block.

use std::ops::Range;

use crate::Error;
use crate::ahead::{ROWS_PER_READ, RowsAhead};
use crate::cleaning::account::LogReport;
use crate::columns::mapping::Columns;
use crate::log::Log;
use crate::packed::PackedLog;
use crate::table::Table;
use crate::timeline::Timeline;

/// The rows for a block.
pub(crate) enum BlockPart<'a> {
    Held(&'a [PackedLog]),
    Read(Box<Log>),
}

impl BlockPart<'_> {
    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        match self {
            BlockPart::Held(parts) => parts.iter().map(PackedLog::len).sum(),
            BlockPart::Read(log) => log.len(),
        }
    }

    /// Time of the first sample, s.
    pub(crate) fn start(&self) -> f64 {
        match self {
            BlockPart::Held(parts) => parts.iter().find(|part| part.len() > 0).map_or(0.0, PackedLog::start),
            BlockPart::Read(log) => log.t.first().copied().unwrap_or(0.0),
        }
    }

    /// A log with time and positions of all samples. If the rows are one compressed block, the log has no other series (to save
    /// time); otherwise it has all series.
    pub(crate) fn positions(&self) -> Log {
        match self {
            BlockPart::Held([part]) => part.positions(),
            _ => self.range(0..self.len()),
        }
    }

    /// A log of the samples in a range.
    pub(crate) fn range(&self, range: Range<usize>) -> Log {
        match self {
            BlockPart::Held(parts) => {
                let mut log = parts[0].head();
                log.reserve(range.len());
                self.append_to(&mut log, range);
                log
            }
            BlockPart::Read(log) => log.range(range),
        }
    }

    /// Appends the samples in a range to a log.
    pub(crate) fn append_to(&self, log: &mut Log, range: Range<usize>) {
        match self {
            BlockPart::Held(parts) => {
                let mut first = 0;
                for part in *parts {
                    let inside = |r: usize| r.saturating_sub(first).min(part.len());
                    part.append_to(log, inside(range.start)..inside(range.end));
                    first += part.len();
                }
            }
            BlockPart::Read(part) => log.append(part, range),
        }
    }
}

/// Reads the next block of a file. `next`: its first rows, which were read before. Returns the usable rows, the range of the rows
/// in the file, and the first rows of the following block.
pub(crate) fn read_block(
    ahead: &mut RowsAhead,
    mut next: Table,
    columns: &Columns,
    clock: &mut Timeline,
    block: usize,
) -> Result<(Log, Range<usize>, Table), Error> {
    let mut rows = next.skipped..next.skipped + next.rows();
    let mut all = Log::without_samples(&next, columns);
    if next.rows() == ROWS_PER_READ {
        all.reserve(block);
    }
    all.append_usable(&next, columns, 0..next.rows(), clock)?;
    loop {
        let is_full = rows.len() == block;
        next = ahead.next()?;
        if is_full || next.rows() == 0 {
            return Ok((all, rows, next));
        }
        rows.end += next.rows();
        all.append_usable(&next, columns, 0..next.rows(), clock)?;
    }
}

/// The common report on the blocks of a file, which are added in order.
pub(crate) struct Account {
    pub report: Option<LogReport>,
    /// Time of the last sample so far, s.
    pub end: f64,
}

impl Default for Account {
    fn default() -> Account {
        Account { report: None, end: f64::NEG_INFINITY }
    }
}

impl Account {
    /// Adds the report on the next block, and compresses the block.
    pub(crate) fn add(&mut self, mut part: Log) -> PackedLog {
        part.describe();
        let step = part.t.first().map_or(0.0, |t| t - self.end);
        self.end = part.t.last().copied().unwrap_or(self.end);
        match &mut self.report {
            None => self.report = Some(part.report.clone()),
            Some(report) => report.append(&part.report, step),
        }
        PackedLog::new(part)
    }
}
