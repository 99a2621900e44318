//! A log too long to be held: read block by block, and again at every pass over it.
//!
//! A block is the rows of its own and, before and behind them, rows of its neighbours, as many as the
//! filter takes to forget where the signal began: the states made of a block's own rows are those of
//! the whole log.

use std::path::{Path, PathBuf};

use crate::Error;
use crate::columns::{ColumnNames, Columns};
use crate::header::Quantity;
use crate::log::{Effort, Log};
use crate::log_report::LogReport;
use crate::signal::Window;
use crate::suspect::unwrap;
use crate::table::Table;
use crate::table_reader::TableReader;

/// Rows up to which a log is held.
const HELD: usize = 1 << 18;

/// Rows of a block.
const BLOCK: usize = 1 << 16;

/// A log in memory, or one too long for that.
pub enum LogSource {
    Held(Log),
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

    fn open_within(
        path: &Path,
        coordinates: &[String],
        names: &ColumnNames,
        held: usize,
        block: usize,
    ) -> Result<(LogSource, Columns), Error> {
        let table = match TableReader::open(path) {
            Ok(mut reader) => reader.rows(held + 1)?,
            // No text: a container that is read as a whole, or not at all.
            Err(_) => Table::read(path)?,
        };
        let columns = Columns::find(&table, coordinates, names)?;
        if table.lines.len() <= held {
            return Ok((LogSource::Held(Log::from_table(&table, &columns)?), columns));
        }
        let (path, report) = (path.into(), LogReport::default());
        let mut stream = LogStream { path, columns: columns.clone(), report, block };
        stream.describe()?;
        Ok((LogSource::Streamed(stream), columns))
    }

    pub fn report(&self) -> &LogReport {
        match self {
            LogSource::Held(log) => &log.report,
            LogSource::Streamed(stream) => &stream.report,
        }
    }

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
    columns: Columns,
    report: LogReport,
    block: usize,
}

impl LogStream {
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
        if rows != self.report.rows {
            let message =
                format!("{rows} rows where there were {}: the file changes while it is read", self.report.rows);
            return Err(Error::at(&self.path.display().to_string(), 0, message));
        }
        current.map_or(Ok(()), |current| block(&before, &current, None))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::FrictionTerm;
    use crate::identify::{Fit, Options, Weights};
    use crate::random::Random;
    use crate::records::SourceRecords;
    use crate::test_arm::Pendulum;

    /// A pendulum's log of `rows` rows, each as `row` makes it of t, q and tau.
    fn write(name: &str, rows: usize, row: impl Fn(usize, [f64; 3]) -> String) -> PathBuf {
        let states = Pendulum::new().states(rows);
        let mut random = Random::new(5);
        let mut text = "t,q1,tau1\n".to_string();
        for r in 0..rows {
            text += &row(r, [states.t[r], states.q[r], states.tau[r] + 0.05 * random.normal()]);
        }
        let path = std::env::temp_dir().join(format!("rist-stream-{}-{name}.csv", std::process::id()));
        std::fs::write(&path, text).unwrap();
        path
    }

    fn open(path: &Path, held: usize) -> LogSource {
        LogSource::open_within(path, &["q1".into()], &ColumnNames::default(), held, 2000).unwrap().0
    }

    fn fit(path: &Path, held: usize, options: &Options) -> Fit {
        let arm = Pendulum::new();
        let logs = [open(path, held)];
        assert_eq!(matches!(logs[0], LogSource::Streamed(_)), held < 20_000);
        let records = SourceRecords::new(&arm, &logs, options).unwrap();
        Fit::of_records(&arm, &records, vec![logs[0].name()], options).unwrap()
    }

    fn plain(_: usize, [t, q, tau]: [f64; 3]) -> String {
        format!("{t},{q},{tau}\n")
    }

    /// The rows of a streamed log are those of the held one: the same estimate, residual and row count.
    #[test]
    fn streamed_is_held() {
        let path = write("plain", 20_000, plain);
        let mut options = Options { friction: vec![FrictionTerm::Viscous], ..Options::default() };
        options.signal.decimate = Some(1);
        for cutoff in [Some(3.0), None] {
            options.signal.cutoff = cutoff;
            let held = fit(&path, 20_000, &options).estimate;
            // The rule looks at each block: a cut-off found so is given to the other.
            let streamed = fit(&path, 1000, &options).estimate;
            options.signal.cutoff = Some(streamed.cutoff);
            let held = if cutoff.is_some() { held } else { fit(&path, 20_000, &options).estimate };
            assert_eq!(streamed.rows, held.rows);
            for (a, b) in streamed.parameters.iter().zip(&held.parameters) {
                // The filter has forgotten its start to a part in 1e12.
                assert!((a.value.unwrap() - b.value.unwrap()).abs() < 1e-9 * b.value.unwrap().abs(), "{a:?} {b:?}");
                assert!((a.sigma.unwrap() / b.sigma.unwrap() - 1.0).abs() < 1e-9);
            }
            assert!((streamed.total / held.total - 1.0).abs() < 1e-9);
        }
        options.weights = Weights::Huber;
        let (a, b) = (fit(&path, 1000, &options).estimate, fit(&path, 20_000, &options).estimate);
        for (a, b) in a.parameters.iter().zip(&b.parameters) {
            // The iterations end when nothing moves by a thousandth of a sigma.
            assert!((a.value.unwrap() - b.value.unwrap()).abs() < 2e-3 * b.sigma.unwrap());
        }
        std::fs::remove_file(path).unwrap();
    }

    /// What is wrong with a file is counted alike, wherever the blocks end.
    #[test]
    fn the_account_is_that_of_the_whole() {
        let path = write("broken", 20_000, |r, [t, q, tau]| match r {
            1999 | 2000 | 7777 => "nan,,1\n".into(),
            4000 => format!("{},{q},{tau}\n", t - 0.05),
            5999 => format!("{t},{q}\n"),
            8000..8100 => String::new(),
            12_000..14_500 => format!("{t},0.5,0.5\n"),
            _ => plain(r, [t, q, tau]),
        });
        let (held, streamed) = (open(&path, 20_000), open(&path, 1000));
        let (held, streamed) = (held.report(), streamed.report());
        // Rest is looked for in steps of 0.05 s, from the start of each block.
        let close = |a: f64, b: f64| (a - b).abs() < 0.1;
        assert!(close(streamed.rest, held.rest) && close(streamed.rest_after, held.rest_after), "{streamed}{held}");
        assert!(close(streamed.duration, held.duration) && close(streamed.rest_before, held.rest_before));
        // A repeat across the end of a block is not seen: at most one for each of the ten blocks.
        assert!((0..10).contains(&(held.repeated - streamed.repeated)));
        let (period, rest_before, rest_after) = (held.period, held.rest_before, held.rest_after);
        let (rest, duration, repeated) = (held.rest, held.duration, held.repeated);
        let counts = LogReport { period, rest_before, rest_after, rest, duration, repeated, ..streamed.clone() };
        assert_eq!(counts, *held);
        assert_eq!((streamed.gaps, streamed.clock_backwards, streamed.not_finite), (1, 1, 4));
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn a_file_that_changes_is_refused() {
        let path = write("changing", 20_000, plain);
        let logs = [open(&path, 1000)];
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, &text[..text.len() / 2]).unwrap();
        let (arm, options) = (Pendulum::new(), Options::default());
        let failed = SourceRecords::new(&arm, &logs, &options).err().unwrap().to_string();
        assert!(failed.contains("changes while it is read"), "{failed}");
        std::fs::remove_file(path).unwrap();
    }
}
