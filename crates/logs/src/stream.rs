//! A log too long to be held: read block by block, and again at every pass over it.
//!
//! A block is the rows of its own and, before and behind them, rows of its neighbours, as many as the
//! filter takes to forget where the signal began: the states made of a block's own rows are those of
//! the whole log.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::Error;
use crate::cleaning::account::LogReport;
use crate::cleaning::suspects::unwrap;
use crate::columns::mapping::{ColumnNames, Columns};
use crate::columns::words::Quantity;
use crate::formats::delimited::TableReader;
use crate::log::{Effort, Log, Window};
use crate::read::{self, Opened};
use crate::table::MAX_CELLS;

/// Rows up to which a log is held.
const HELD: usize = 1 << 18;

/// Rows of a block.
const BLOCK: usize = 1 << 16;

/// Cells of a block of very many columns.
const WIDE: usize = 1 << 24;

/// A log in memory, or one too long for that.
pub enum LogSource {
    /// In memory.
    Held(Log),
    /// Read again at each pass.
    Streamed(LogStream),
}

impl LogSource {
    /// Opens a file and finds the columns of the coordinates in it. Delimited text of more than 262144 rows is
    /// streamed.
    ///
    /// Fails as `Log::read` does.
    pub fn open(path: &Path, coordinates: &[String], names: &ColumnNames) -> Result<(LogSource, Columns), Error> {
        LogSource::open_within(path, coordinates, names, HELD, BLOCK)
    }

    /// As `open`, with the number of rows up to which a log is held and that of a block of a streamed one.
    pub fn open_within(
        path: &Path,
        coordinates: &[String],
        names: &ColumnNames,
        mut held: usize,
        mut block: usize,
    ) -> Result<(LogSource, Columns), Error> {
        let (table, again) = match read::open(path)? {
            Opened::Text { mut reader, again } => {
                held = held.min(MAX_CELLS / reader.width());
                block = block.min(WIDE / reader.width()).max(1);
                (reader.rows(held + 1)?, again)
            }
            Opened::Whole(table) => (table, false),
        };
        let columns = Columns::find(&table, coordinates, names)?;
        // What is no text has no lines and is held.
        if table.lines.len() <= held {
            return Ok((LogSource::Held(Log::from_table(&table, &columns)?), columns));
        }
        if !again {
            let message = format!(
                "more than {held} rows from a pipe or device; so long a log is read again at each pass: write it to a file"
            );
            return Err(Error::at(&table.file, 0, message));
        }
        let state = FileState::of(path)?;
        let (path, report) = (path.into(), LogReport::default());
        let mut stream = LogStream { path, state, columns: columns.clone(), report, block };
        stream.describe()?;
        Ok((LogSource::Streamed(stream), columns))
    }

    /// What was found and left out when it was read.
    pub fn report(&self) -> &LogReport {
        match self {
            LogSource::Held(log) => &log.report,
            LogSource::Streamed(stream) => &stream.report,
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

/// A file whose rows are read again at every pass.
pub struct LogStream {
    path: PathBuf,
    state: FileState,
    columns: Columns,
    report: LogReport,
    block: usize,
}

/// What changes when a file is written or replaced.
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
    /// What was found and left out when it was read.
    pub fn report(&self) -> &LogReport {
        &self.report
    }

    /// The account of the whole file; refuses it as `Log::from_table` does.
    fn describe(&mut self) -> Result<(), Error> {
        let mut report: Option<LogReport> = None;
        let mut end = f64::NAN;
        self.parts(self.block, &mut |part| {
            let step = part.t.first().map_or(0.0, |t| t - end);
            end = part.t.last().copied().unwrap_or(end);
            match &mut report {
                None => report = Some(part.report),
                Some(report) => report.append(&part.report, step),
            }
            Ok(())
        })?;
        self.report = report.unwrap_or_default();
        self.report.check(&self.path.display().to_string(), &self.columns.time.header)
    }

    /// The usable rows of the file, so many rows of it at a time; returns how many rows it has.
    fn parts(&self, rows: usize, take: &mut dyn FnMut(Log) -> Result<(), Error>) -> Result<usize, Error> {
        let mut reader = TableReader::open(&self.path)?;
        let (mut after, mut count) = (f64::NEG_INFINITY, 0);
        loop {
            let table = reader.rows(rows)?;
            if table.rows() == 0 {
                return Ok(count);
            }
            count += table.rows();
            let part = Log::part(&table, &self.columns, after)?;
            after = part.t.last().copied().unwrap_or(after);
            take(part)?;
        }
    }

    /// Hands over the log in blocks that reach `overlap` s into their neighbours; the window of a block is
    /// what is its own.
    ///
    /// Fails when the file cannot be read again, or has changed.
    pub fn blocks(&self, overlap: f64, take: &mut dyn FnMut(Log) -> Result<(), Error>) -> Result<(), Error> {
        let reach = (overlap / self.report.period).ceil() as usize;
        let mut before: Option<Log> = None;
        let mut current: Option<Log> = None;
        let mut block = |before: &Option<Log>, current: &Log, next: Option<&Log>| {
            let mut block = before.clone().unwrap_or_else(|| current.range(0..0));
            let end = next.map_or(f64::INFINITY, |next| next.t[0].next_down());
            block.window = Some(Window::Seconds(current.t[0], end));
            block.append(current, 0..current.len());
            if let Some(next) = next {
                block.append(next, 0..reach.min(next.len()));
            }
            // Parts were unwrapped by themselves: their ends may be turns apart.
            block.q.iter_mut().for_each(|q| {
                unwrap(q);
            });
            block.report = LogReport { duration: block.t[block.len() - 1] - block.t[0], ..self.report.clone() };
            take(block)
        };
        let rows = self.parts(self.block.max(4 * reach), &mut |next| {
            if next.is_empty() {
                return Ok(());
            }
            if let Some(current) = current.take() {
                block(&before, &current, Some(&next))?;
                before = Some(current.range(current.len().saturating_sub(reach)..current.len()));
            }
            current = Some(next);
            Ok(())
        })?;
        if rows != self.report.rows || FileState::of(&self.path)? != self.state {
            let message = "the file changes while it is read, or was replaced since; begin again";
            return Err(Error::at(&self.path.display().to_string(), 0, message));
        }
        current.map_or(Ok(()), |current| block(&before, &current, None))
    }
}
