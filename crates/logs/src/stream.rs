//! A long log, read block by block: from memory or, where it is too long for that, from its file at every pass.
//!
//! A block has its own rows and, before and behind them, rows of its neighbours: as many as the filter needs to forget
//! where the signal began. So the states made of a block's own rows are those of the whole log. Blocks, account and
//! states are the same whether the log comes from memory or from its file.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::Error;
use crate::abreast::abreast;
use crate::ahead::RowsAhead;
use crate::cleaning::account::LogReport;
use crate::cleaning::suspects::unwrap;
use crate::columns::mapping::Columns;
use crate::columns::names::ColumnNames;
use crate::columns::words::Quantity;
use crate::formats::delimited::TableReader;
use crate::log::{Effort, Log, Window};
use crate::packed::PackedLog;
use crate::part::{Part, read_block};
use crate::read::{self, Opened};
use crate::table::Table;

/// Rows of a block.
const ROWS_PER_BLOCK: usize = 1 << 17;

/// Most numbers of a log that is held in memory: 384 MiB, two million rows of seven joints.
const MAX_HELD_NUMBERS: usize = 3 << 24;

/// Most cells of a block, which bounds its rows where a file has very many columns.
const MAX_CELLS_PER_BLOCK: usize = 1 << 24;

/// A log of one block, or of several.
pub enum LogSource {
    /// One block, in memory.
    Held(Log),
    /// Block by block.
    Streamed(LogStream),
}

impl LogSource {
    /// Opens a file and finds the columns of the coordinates in it. A log of more than 131072 rows is read block by
    /// block. A text of more than 50 million numbers of the robot is read again at every pass.
    ///
    /// Fails as `Log::read` does.
    pub fn open(path: &Path, coordinates: &[String], names: &ColumnNames) -> Result<(LogSource, Columns), Error> {
        LogSource::open_within(path, coordinates, names, usize::MAX, ROWS_PER_BLOCK)
    }

    /// As `open`, with the most rows of a text that is held in memory, `held`, and the rows of a block, `block`.
    pub fn open_within(
        path: &Path,
        coordinates: &[String],
        names: &ColumnNames,
        held: usize,
        block: usize,
    ) -> Result<(LogSource, Columns), Error> {
        let (mut reader, again) = match read::open(path)? {
            Opened::Text { reader, again } => (reader, again),
            Opened::Whole(table) => return LogSource::of_table(path, table, coordinates, names, block),
        };
        let state = FileState::of(path);
        let block = block.min(MAX_CELLS_PER_BLOCK / reader.width()).max(1);
        let first = reader.rows(block)?;
        let columns = Columns::find(&first, coordinates, names)?;
        reader.keep(columns.sources().map(|source| source.column));
        let mut ahead = RowsAhead::new(reader, block);
        let mut next = ahead.next()?;
        if next.rows() == 0 {
            return Ok((LogSource::Held(Log::from_table(&first, &columns)?), columns));
        }
        let mut account = Account::default();
        let mut parts = vec![account.add(Log::usable(&first, &columns, 0..first.rows(), f64::NEG_INFINITY)?)];
        drop(first);
        let held = held.min(MAX_HELD_NUMBERS / columns.sources().count());
        let mut is_held = true;
        while next.rows() > 0 {
            let (part, rows, following) = read_block(&mut ahead, next, &columns, account.end, block)?;
            is_held &= rows.end <= held;
            if !is_held && !again {
                let message = format!(
                    "more than {held} rows from a pipe or device; so long a log is read again at each pass: write it to a \
                     file"
                );
                return Err(Error::at(&part.name, 0, message));
            }
            let part = account.add(part);
            match is_held {
                true => parts.push(part),
                false => parts.clear(),
            }
            next = following;
        }
        let parts = match is_held {
            true => Parts::Held(parts),
            false => Parts::File(path.into(), state?),
        };
        let stream = LogStream::new(path.into(), columns.clone(), account, parts, block)?;
        Ok((LogSource::Streamed(stream), columns))
    }

    /// From a table in memory, and the columns of the coordinates in it; its `file` is the name of the log.
    ///
    /// Fails as `Log::read` does.
    pub fn from_table(
        table: Table,
        coordinates: &[String],
        names: &ColumnNames,
    ) -> Result<(LogSource, Columns), Error> {
        LogSource::of_table(&PathBuf::from(&table.file), table, coordinates, names, ROWS_PER_BLOCK)
    }

    /// From a file that was read whole.
    fn of_table(
        path: &Path,
        table: Table,
        coordinates: &[String],
        names: &ColumnNames,
        block: usize,
    ) -> Result<(LogSource, Columns), Error> {
        let columns = Columns::find(&table, coordinates, names)?;
        let block = block.min(MAX_CELLS_PER_BLOCK / table.header.len().max(1)).max(1);
        if table.rows() <= block {
            return Ok((LogSource::Held(Log::from_table(&table, &columns)?), columns));
        }
        let (mut account, mut parts) = (Account::default(), Vec::new());
        for first in (0..table.rows()).step_by(block) {
            let range = first..table.rows().min(first + block);
            let part = Log::usable(&table, &columns, range, account.end)?;
            parts.push(account.add(part));
        }
        let stream = LogStream::new(path.into(), columns.clone(), account, Parts::Held(parts), block)?;
        Ok((LogSource::Streamed(stream), columns))
    }

    /// What was found and left out when it was read.
    pub fn report(&self) -> &LogReport {
        match self {
            LogSource::Held(log) => &log.report,
            LogSource::Streamed(stream) => &stream.report,
        }
    }

    /// Bytes of the samples of a log of several blocks that wait in memory.
    pub fn held_bytes(&self) -> usize {
        match self {
            LogSource::Streamed(LogStream { parts: Parts::Held(parts), .. }) => {
                parts.iter().map(PackedLog::bytes).sum()
            }
            _ => 0,
        }
    }

    /// What the efforts are.
    pub fn effort_is(&self) -> Effort {
        match self {
            LogSource::Held(log) => log.effort_is,
            LogSource::Streamed(stream) if stream.columns.effort_is == Quantity::Current => Effort::Current,
            LogSource::Streamed(_) => Effort::Torque,
        }
    }

    /// The file as the user named it.
    pub fn name(&self) -> String {
        match self {
            LogSource::Held(log) => log.name.clone(),
            LogSource::Streamed(stream) => stream.path.display().to_string(),
        }
    }
}

/// A log of several blocks.
pub struct LogStream {
    path: PathBuf,
    columns: Columns,
    report: LogReport,
    parts: Parts,
    block: usize,
}

/// Where the rows are.
enum Parts {
    /// In memory, some rows of the file in each.
    Held(Vec<PackedLog>),
    /// In the file, which is not to change.
    File(PathBuf, FileState),
}

/// The account of the parts of a file, one after the other.
struct Account {
    report: Option<LogReport>,
    /// s, the last instant.
    end: f64,
}

impl Default for Account {
    fn default() -> Account {
        Account { report: None, end: f64::NEG_INFINITY }
    }
}

impl Account {
    /// Describes the next part and holds it.
    fn add(&mut self, mut part: Log) -> PackedLog {
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

/// Length and time of modification, which change when a file is written or replaced.
#[derive(PartialEq)]
struct FileState(u64, Option<SystemTime>);

impl FileState {
    fn of(path: &Path) -> Result<FileState, Error> {
        let metadata = std::fs::metadata(path);
        let metadata =
            metadata.map_err(|e| Error::at(&path.display().to_string(), 0, format!("cannot be read: {e}")))?;
        Ok(FileState(metadata.len(), metadata.modified().ok()))
    }
}

impl LogStream {
    /// Refuses a log as `Log::from_table` does.
    fn new(path: PathBuf, columns: Columns, account: Account, parts: Parts, block: usize) -> Result<LogStream, Error> {
        let report = account.report.unwrap_or_default();
        report.check(&path.display().to_string(), &columns.time.header)?;
        Ok(LogStream { path, columns, report, parts, block })
    }

    /// Hands over the log in blocks without rows of their neighbours.
    ///
    /// Fails when the file cannot be read again, or has changed.
    pub fn each(&self, take: &mut dyn FnMut(&Log) -> Result<(), Error>) -> Result<(), Error> {
        self.parts(1, &mut |part| match part.len() {
            0 => Ok(()),
            len => take(&self.described(part.range(0..len))),
        })
    }

    /// Some of the samples, with the account of all.
    fn described(&self, mut log: Log) -> Log {
        let duration = log.t.last().zip(log.t.first()).map_or(0.0, |(end, start)| end - start);
        log.report = LogReport { duration, ..self.report.clone() };
        log
    }

    /// What was found and left out when it was read.
    pub fn report(&self) -> &LogReport {
        &self.report
    }

    /// Hands over the usable rows, `blocks` blocks of the file at a time.
    ///
    /// Fails when the file cannot be read again, or has changed.
    fn parts<'a>(&'a self, blocks: usize, take: &mut dyn FnMut(Part<'a>) -> Result<(), Error>) -> Result<(), Error> {
        match &self.parts {
            Parts::Held(parts) => parts.chunks(blocks).try_for_each(|parts| take(Part::Held(parts))),
            Parts::File(path, state) => {
                let mut reader = TableReader::open(path)?;
                let (mut after, mut count) = (f64::NEG_INFINITY, 0);
                // The names are settled with the first rows of units, which belong to the header.
                reader.keep(self.columns.sources().map(|source| source.column));
                let block = blocks * self.block;
                let mut ahead = RowsAhead::new(reader, block);
                let mut next = ahead.next()?;
                while next.rows() > 0 {
                    let (part, rows, following) = read_block(&mut ahead, next, &self.columns, after, block)?;
                    (count, next) = (rows.end, following);
                    after = part.t.last().copied().unwrap_or(after);
                    take(Part::Read(Box::new(part)))?;
                }
                if count != self.report.rows || FileState::of(path)? != *state {
                    let message = "the file changes while it is read, or was replaced since; begin again";
                    return Err(Error::at(&path.display().to_string(), 0, message));
                }
                Ok(())
            }
        }
    }

    /// Hands over the log in blocks that reach `overlap` s into their neighbours. The window of a block covers its own
    /// rows.
    ///
    /// Fails when the file cannot be read again, or has changed.
    pub fn blocks(&self, overlap: f64, take: &mut dyn FnMut(Log) -> Result<(), Error>) -> Result<(), Error> {
        let reach = (overlap / self.report.period).ceil() as usize;
        let mut before: Option<Log> = None;
        let mut current: Option<Part> = None;
        let mut block = |before: Option<Log>, current: &Part, next: Option<&Part>| {
            let after = next.map_or(0, |next| reach.min(next.len()));
            let mut block = before.unwrap_or_else(|| current.range(0..0));
            block.reserve(block.len() + current.len() + after);
            let end = next.map_or(f64::INFINITY, |next| next.start().next_down());
            block.window = Some(Window::Seconds(current.start(), end));
            current.append_to(&mut block, 0..current.len());
            if let Some(next) = next {
                next.append_to(&mut block, 0..after);
            }
            // Each part was unwrapped by itself, so that parts may differ by turns where they meet.
            abreast(block.len(), block.q.iter_mut().collect(), |q| unwrap(q));
            take(self.described(block))
        };
        self.parts((4 * reach).div_ceil(self.block).max(1), &mut |next| {
            if next.len() == 0 {
                return Ok(());
            }
            if let Some(current) = current.take() {
                block(before.take(), &current, Some(&next))?;
                before = Some(current.range(current.len().saturating_sub(reach)..current.len()));
            }
            current = Some(next);
            Ok(())
        })?;
        current.map_or(Ok(()), |current| block(before.take(), &current, None))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write as _;

    /// A table (Parquet, MCAP, .npz), a text that is held and a text that is read again give the same account and the
    /// same blocks, bit for bit.
    #[test]
    fn blocks_of_a_table_are_those_of_a_text() {
        let mut text = "t,note,q1,tau1\n".to_string();
        for r in 0..5000 {
            let t = 0.01 * f64::from(r);
            let q = if r % 700 == 3 { "nan".into() } else { format!("{}", (0.3 * t).sin() * 4.0) };
            let _ = writeln!(text, "{t},{r},{q},{}", t.cos());
        }
        let path = std::env::temp_dir().join(format!("rist-blocks-{}.csv", std::process::id()));
        std::fs::write(&path, &text).unwrap();
        let (coordinates, names) = (["q1".to_string()], ColumnNames::default());
        let table = Table::from_bytes(&path.display().to_string(), text.as_bytes()).unwrap();
        let sources = [
            LogSource::of_table(&path, Table { lines: Default::default(), ..table }, &coordinates, &names, 600),
            LogSource::open_within(&path, &coordinates, &names, usize::MAX, 600),
            LogSource::open_within(&path, &coordinates, &names, 1000, 600),
        ];
        let found = sources.map(|source| {
            let LogSource::Streamed(stream) = source.unwrap().0 else { panic!("it is of one block") };
            let mut blocks = Vec::new();
            // A reach of 200 rows asks for blocks of two parts.
            for overlap in [0.5, 2.0] {
                let take = &mut |block: Log| {
                    let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
                    blocks.push((bits(&block.t), bits(&block.q[0]), bits(&block.effort[0]), block.rows, block.window));
                    Ok(())
                };
                stream.blocks(overlap, take).unwrap();
            }
            (LogReport { first_not_finite: None, ..stream.report().clone() }, blocks)
        });
        assert_eq!(found[0].0.not_finite, 8);
        assert_eq!(found[0].1.len(), 9 + 5);
        assert!(found[1..].iter().all(|other| *other == found[0]));
        std::fs::remove_file(&path).unwrap();
    }
}
