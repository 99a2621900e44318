//! A long log that is read block by block: from memory, or from its file in every pass if it is too long for the memory.
//!
//! A block has its own rows, and rows of its neighbours before and after them, in which the transients of the filter decay. So
//! the filtered states of its own rows equal the states of the whole log. Blocks, report and states are the same in both cases,
//! from memory or from the file.

use std::path::{Path, PathBuf};

use crate::Error;
use crate::ahead::RowsAhead;
use crate::cleaning::account::LogReport;
use crate::cleaning::suspects::Suspect;
use crate::cleaning::turns::unwrap;
use crate::columns::mapping::Columns;
use crate::columns::names::ColumnNames;
use crate::effort::Effort;
use crate::file_state::{FileState, changed, refuse_changed};
use crate::log::{Log, Window};
use crate::packed::PackedLog;
use crate::parallel_series::in_parallel_series;
use crate::part::{Account, BlockPart, read_block};
use crate::read::{self, Opened};
use crate::table::Table;
use crate::timeline::Timeline;

/// Number of rows of a block.
const ROWS_PER_BLOCK: usize = 1 << 17;

/// Largest memory for the samples of a log, bytes. It is enough for ten million rows of seven joints from a controller.
const MAX_HELD_BYTES: usize = 3 << 27;

/// Largest number of cells of a block. It limits the number of rows if a file has very many columns.
const MAX_CELLS_PER_BLOCK: usize = 1 << 24;

/// A log of one block or of several blocks.
pub enum LogSource {
    /// A log of one block, in memory.
    Held(Log),
    /// A log of several blocks.
    Streamed(LogStream),
}

impl LogSource {
    /// Opens a file, and finds the columns for these coordinates. A log of more than 131072 rows is read block by block. If its
    /// compressed samples need more than `MAX_HELD_BYTES`, it is read from the file in every pass.
    ///
    /// Fails like `Log::read`.
    pub fn open(path: &Path, coordinates: &[String], names: &ColumnNames) -> Result<(LogSource, Columns), Error> {
        LogSource::open_within(path, coordinates, names, usize::MAX, ROWS_PER_BLOCK)
    }

    /// Opens a file like [`LogSource::open`], with other limits. `held`: largest number of rows in memory. `block`: number of
    /// rows of a block.
    pub fn open_within(
        path: &Path,
        coordinates: &[String],
        names: &ColumnNames,
        held: usize,
        block: usize,
    ) -> Result<(LogSource, Columns), Error> {
        let before = FileState::of_file(path);
        let (mut reader, again) = match read::open(path)? {
            Opened::Rows { reader, again } => (reader, again),
            Opened::Whole(table) => {
                refuse_changed(path, before.as_ref())?;
                return LogSource::of_table(path, table, coordinates, names, block);
            }
        };
        let block = block.min(MAX_CELLS_PER_BLOCK / reader.width()).max(1);
        let first = reader.rows(block)?;
        let columns = Columns::find(&first, coordinates, names)?;
        reader.keep(&columns.places());
        // A second thread reads the next rows while blocks are compressed.
        let mut ahead = RowsAhead::new(reader, block);
        let mut next = ahead.next()?;
        if next.rows() == 0 {
            refuse_changed(path, before.as_ref())?;
            return Ok((LogSource::Held(Log::from_table(&first, &columns)?), columns));
        }
        // Each block is added to the report and compressed immediately, so the memory is bounded.
        let (mut account, mut clock) = (Account::default(), Timeline::default());
        let mut parts = vec![account.add(Log::usable(&first, &columns, 0..first.rows(), &mut clock)?)];
        drop(first);
        let (mut is_held, mut bytes) = (true, parts[0].bytes());
        while next.rows() > 0 {
            let (part, rows, following) = read_block(&mut ahead, next, &columns, &mut clock, block)?;
            let part = account.add(part);
            bytes += part.bytes();
            is_held &= rows.end <= held && bytes <= MAX_HELD_BYTES;
            // A log that is too long for the memory is read again in each pass, so it must be a file.
            if !is_held && !again {
                let message = format!(
                    "more than {} rows come from a pipe or device, and memory for them ends; so long a log is read again at \
                     each pass: write it to a file",
                    rows.start
                );
                return Err(Error::at(&path.display().to_string(), 0, message));
            }
            match is_held {
                true => parts.push(part),
                false => parts = Vec::new(),
            }
            next = following;
        }
        refuse_changed(path, before.as_ref())?;
        // The file must not change before the last pass.
        let parts = match (is_held, before) {
            (true, _) => RowSource::Held(parts),
            (false, Some(state)) => RowSource::File(path.into(), state),
            (false, None) => RowSource::File(path.into(), FileState::of(path)?),
        };
        let stream = LogStream::new(path.into(), columns.clone(), account, parts, block)?;
        Ok((LogSource::Streamed(stream), columns))
    }

    /// Makes a log from a table in memory. The log gets the name in `file`.
    ///
    /// Fails like `Log::read`.
    pub fn from_table(
        table: Table,
        coordinates: &[String],
        names: &ColumnNames,
    ) -> Result<(LogSource, Columns), Error> {
        LogSource::of_table(&PathBuf::from(&table.file), table, coordinates, names, ROWS_PER_BLOCK)
    }

    /// Makes a log from a table that was read as a whole.
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
        let (mut account, mut clock, mut parts) = (Account::default(), Timeline::default(), Vec::new());
        for first in (0..table.rows()).step_by(block) {
            let range = first..table.rows().min(first + block);
            let part = Log::usable(&table, &columns, range, &mut clock)?;
            parts.push(account.add(part));
        }
        let stream = LogStream::new(path.into(), columns.clone(), account, RowSource::Held(parts), block)?;
        Ok((LogSource::Streamed(stream), columns))
    }

    /// The report on the cleaning.
    pub fn report(&self) -> &LogReport {
        match self {
            LogSource::Held(log) => &log.report,
            LogSource::Streamed(stream) => &stream.report,
        }
    }

    /// Memory of the compressed samples, bytes; 0 for a log of one block or in a file.
    pub fn held_bytes(&self) -> usize {
        match self {
            LogSource::Streamed(LogStream { parts: RowSource::Held(parts), .. }) => {
                parts.iter().map(PackedLog::bytes).sum()
            }
            _ => 0,
        }
    }

    /// The quantity in the effort columns.
    pub fn effort_is(&self) -> Effort {
        match self {
            LogSource::Held(log) => log.effort_is,
            LogSource::Streamed(stream) => Effort::of(stream.columns.effort_is),
        }
    }

    /// The names that select the columns of this log.
    pub fn names(&self) -> ColumnNames {
        self.effort_is().names(self.report().columns.clone())
    }

    /// Whether the log has velocities, and whether it has accelerations.
    pub fn has_rates(&self) -> [bool; 2] {
        match self {
            LogSource::Held(log) => [log.dq.is_some(), log.ddq.is_some()],
            LogSource::Streamed(stream) => [stream.columns.velocity.is_some(), stream.columns.acceleration.is_some()],
        }
    }

    /// Name of the file, as given by the user.
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
    columns: Box<Columns>,
    report: LogReport,
    parts: RowSource,
    block: usize,
}

/// Where the rows are stored.
enum RowSource {
    /// In memory: one compressed log per block of the file.
    Held(Vec<PackedLog>),
    /// The rows stay in the file and are read again. So the file must not change.
    File(PathBuf, FileState),
}

impl LogStream {
    /// Makes a log of several blocks. Fails for the same reasons as `Log::from_table`.
    fn new(
        path: PathBuf,
        columns: Columns,
        account: Account,
        parts: RowSource,
        block: usize,
    ) -> Result<LogStream, Error> {
        let report = account.report.unwrap_or_default();
        report.check(&path.display().to_string(), &columns.time.header)?;
        Ok(LogStream { path, columns: Box::new(columns), report, parts, block })
    }

    /// Passes the log to `take` in blocks that have no rows of their neighbours.
    ///
    /// Fails if the file cannot be read again, or if it has changed.
    pub fn each(&self, take: &mut dyn FnMut(&Log) -> Result<(), Error>) -> Result<(), Error> {
        self.each_of(|part| part.range(0..part.len()), take)
    }

    /// Passes time and positions of the log to `take` in blocks. The other series may be missing.
    pub fn each_of_positions(&self, take: &mut dyn FnMut(&Log) -> Result<(), Error>) -> Result<(), Error> {
        self.each_of(|part| part.positions(), take)
    }

    fn each_of(
        &self,
        log: fn(&BlockPart) -> Log,
        take: &mut dyn FnMut(&Log) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.parts(1, &mut |part| {
            if part.len() == 0 { Ok(true) } else { take(&self.with_account(log(&part))).map(|()| true) }
        })
    }

    /// Adds the report of the whole log to a block.
    fn with_account(&self, mut log: Log) -> Log {
        let duration = log.t.last().zip(log.t.first()).map_or(0.0, |(end, start)| end - start);
        log.report = self.report.clone();
        log.report.clock.duration = duration;
        log
    }

    /// The report on the cleaning.
    pub fn report(&self) -> &LogReport {
        &self.report
    }

    /// Passes the usable rows to `take`, `blocks` blocks of the file at a time, until `take` returns `false`.
    ///
    /// Fails if the file cannot be read again, or if it has changed.
    fn parts<'a>(
        &'a self,
        blocks: usize,
        take: &mut dyn FnMut(BlockPart<'a>) -> Result<bool, Error>,
    ) -> Result<(), Error> {
        match &self.parts {
            RowSource::Held(parts) => {
                for parts in parts.chunks(blocks) {
                    if !take(BlockPart::Held(parts))? {
                        break;
                    }
                }
                Ok(())
            }
            // In each pass, the clock and the number of rows start again.
            RowSource::File(path, state) => {
                let Opened::Rows { mut reader, .. } = read::open(path)? else { return Err(changed(path)) };
                let (mut clock, mut count) = (Timeline::default(), 0);
                reader.keep(&self.columns.places());
                let block = blocks * self.block;
                let mut ahead = RowsAhead::new(reader, block);
                let mut next = ahead.next()?;
                while next.rows() > 0 {
                    let (part, rows, following) = read_block(&mut ahead, next, &self.columns, &mut clock, block)?;
                    (count, next) = (rows.end, following);
                    if !take(BlockPart::Read(Box::new(part)))? {
                        return Ok(());
                    }
                }
                // If the number of rows differs, the file has changed.
                if count != self.report.rows || FileState::of(path)? != *state {
                    return Err(changed(path));
                }
                Ok(())
            }
        }
    }

    /// Passes the log to `take` in blocks that overlap their neighbours by `overlap` s, from block `first` on, until `take`
    /// returns `false`. `Log::window` of a block is the range of its own rows.
    ///
    /// Fails if the file cannot be read again, or if it has changed.
    pub fn blocks(
        &self,
        overlap: f64,
        first: usize,
        take: &mut dyn FnMut(Log) -> Result<bool, Error>,
    ) -> Result<(), Error> {
        let reach = (overlap / self.report.clock.period).ceil() as usize;
        let mut before: Option<Log> = None;
        let mut current: Option<BlockPart> = None;
        let mut index = 0;
        let mut block = |before: Option<Log>, current: &BlockPart, next: Option<&BlockPart>| {
            index += 1;
            if index <= first {
                return Ok(true);
            }
            let after = next.map_or(0, |next| reach.min(next.len()));
            let mut block = before.unwrap_or_else(|| current.range(0..0));
            block.reserve(block.len() + current.len() + after);
            let end = next.map_or(f64::INFINITY, |next| next.start().next_down());
            block.window = Some(Window::Seconds(current.start(), end));
            current.append_to(&mut block, 0..current.len());
            if let Some(next) = next {
                next.append_to(&mut block, 0..after);
            }
            // The angles of each block were unwrapped separately, so they may differ by full turns between blocks. They are
            // unwrapped again.
            let samples = block.len();
            let angles =
                block.q.iter_mut().zip(&self.report.suspect).filter(|(_, s)| Suspect::may_be_wrapped(s)).collect();
            in_parallel_series(samples, angles, |(q, _): (&mut Vec<f64>, &Suspect)| unwrap(q));
            take(self.with_account(block))
        };
        let mut goes_on = true;
        self.parts((4 * reach).div_ceil(self.block).max(1), &mut |next| {
            if next.len() == 0 {
                return Ok(true);
            }
            if let Some(current) = current.take() {
                goes_on = block(before.take(), &current, Some(&next))?;
                before = Some(current.range(current.len().saturating_sub(reach)..current.len()));
            }
            current = Some(next);
            Ok(goes_on)
        })?;
        match current.filter(|_| goes_on) {
            Some(current) => block(before.take(), &current, None).map(drop),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write as _;

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
            // An overlap of 200 rows needs two blocks on each side.
            for overlap in [0.5, 2.0] {
                let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
                let take = &mut |block: Log| {
                    blocks.push((bits(&block.t), bits(&block.q[0]), bits(&block.effort[0]), block.rows, block.window));
                    Ok(true)
                };
                stream.blocks(overlap, 0, take).unwrap();
                // If a reader has already read some blocks, it continues with the next one.
                let all = blocks.clone();
                let (mut index, of_this) = (0, all.len() - if overlap == 0.5 { 9 } else { 5 });
                let take = &mut |block: Log| {
                    assert_eq!(bits(&block.t), all[of_this + 2 + index].0);
                    index += 1;
                    Ok(index < 2)
                };
                stream.blocks(overlap, 2, take).unwrap();
                assert_eq!(index, 2);
            }
            let mut report = stream.report().clone();
            report.left_out.first_not_finite = None;
            (report, blocks)
        });
        assert_eq!(found[0].0.left_out.not_finite, 8);
        assert_eq!(found[0].1.len(), 9 + 5);
        assert!(found[1..].iter().all(|other| *other == found[0]));
        std::fs::remove_file(&path).unwrap();
    }
}
