//! A log of a robot: measured joint signals over time, cleaned, with a report on the cleaning.
//!
//! Unusable rows (a missing or infinite number, a clock that does not advance) are omitted and counted. No values are invented.
//! Filtering and differentiation are in `signal`.

use std::ops::Range;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::cleaning::account::{LeftOutRows, LogReport};
use crate::cleaning::clock::{Clock, GAP_PERIODS, MIN_ROWS, even};
use crate::cleaning::goals::GoalSpan;
use crate::cleaning::publishers::foreign_rows;
use crate::cleaning::refresh::Refresh;
use crate::cleaning::rest::RestTimes;
use crate::cleaning::suspects::Suspect;
use crate::columns::mapping::Columns;
use crate::columns::names::ColumnNames;
use crate::columns::source::{ColumnSource, NO_COLUMN};
use crate::effort::Effort;
use crate::parallel_series::in_parallel_series;
use crate::table::Table;
use crate::timeline::Timeline;

/// The measured signals of one run in SI units. Each signal has one series per coordinate, in the order of the robot.
#[derive(Clone, Debug)]
pub struct Log {
    /// Name of the file, as given by the user.
    pub name: String,
    /// Names of the coordinates, in the order of the series.
    pub coordinates: Vec<String>,
    /// Times, s, strictly increasing. Row r of every series was measured at `t[r]`.
    pub t: Vec<f64>,
    /// Positions, rad (m).
    pub q: Vec<Vec<f64>>,
    /// Velocities, rad/s (m/s); `None` if they were not measured.
    pub dq: Option<Vec<Vec<f64>>>,
    /// Accelerations, rad/s^2 (m/s^2); `None` if they were not measured.
    pub ddq: Option<Vec<Vec<f64>>>,
    /// Torques, N m (N), currents, A, or position errors, rad (m), depending on `effort_is`.
    pub effort: Vec<Vec<f64>>,
    /// The quantity in `effort`.
    pub effort_is: Effort,
    /// For each sample, the number of its row in the file, counted from 1.
    pub rows: Vec<usize>,
    /// The interval to which the used samples are restricted, in addition to the interval in the options. `None`: all samples.
    pub window: Option<Window>,
    /// The report on the cleaning.
    pub report: LogReport,
}

impl Log {
    /// Reads a file, and finds the columns for these coordinates.
    pub fn read(path: &Path, coordinates: &[String], names: &ColumnNames) -> Result<(Log, Columns), Error> {
        let table = Table::read(path)?;
        let columns = Columns::find(&table, coordinates, names)?;
        Ok((Log::from_table(&table, &columns)?, columns))
    }

    /// Extracts the signals from a table.
    ///
    /// Fails if a used column contains text, if fewer than `MIN_ROWS` rows are usable, or if the time column is not a clock.
    pub fn from_table(table: &Table, columns: &Columns) -> Result<Log, Error> {
        let mut log = Log::usable(table, columns, 0..table.rows(), &mut Timeline::default())?;
        log.describe();
        let empty = |s: &&ColumnSource| table.rows() > 0 && table.columns[s.column].iter().all(|x| !x.is_finite());
        if let Some(s) = columns.sources().find(empty) {
            let message = format!("column `{}` holds no number at all", s.header);
            return Err(Error::at(&table.file, 0, message));
        }
        log.report.check(&table.file, &columns.time.header)?;
        Ok(log)
    }

    /// The usable rows in a range of a table, without a report. `clock`: state of the clock after the earlier rows.
    ///
    /// Fails if a used column contains text.
    pub(crate) fn usable(
        table: &Table,
        columns: &Columns,
        range: Range<usize>,
        clock: &mut Timeline,
    ) -> Result<Log, Error> {
        let mut log = Log::without_samples(table, columns);
        log.append_usable(table, columns, range, clock)?;
        Ok(log)
    }

    /// A log of these columns without samples.
    pub(crate) fn without_samples(table: &Table, columns: &Columns) -> Log {
        let series = |sources: &[ColumnSource]| vec![Vec::new(); sources.len()];
        Log {
            name: table.file.clone(),
            coordinates: columns.coordinates.clone(),
            t: Vec::new(),
            q: series(&columns.position),
            dq: columns.velocity.as_deref().map(series),
            ddq: columns.acceleration.as_deref().map(series),
            effort: series(&columns.effort),
            effort_is: Effort::of(columns.effort_is),
            rows: Vec::new(),
            window: None,
            report: LogReport { columns: columns.read(), undriven: columns.undriven.clone(), ..LogReport::default() },
        }
    }

    /// Appends the usable rows in a range of a table. Fails if a used column contains text.
    pub(crate) fn append_usable(
        &mut self,
        table: &Table,
        columns: &Columns,
        range: Range<usize>,
        clock: &mut Timeline,
    ) -> Result<(), Error> {
        check_texts(table, columns)?;
        // A table with ragged rows is always read in one range, so its ragged rows are counted once.
        let ragged = if range.start == 0 { table.ragged } else { 0 };
        let Usable { rows, times, left_out } = usable_rows(table, columns, range.clone(), clock);
        let before = self.t.len();
        self.t.extend(times);
        for (x, s) in self.series_mut().zip(columns.sources()).skip(1) {
            let column = &table.columns[s.column];
            match rows.len() == range.len() {
                true => s.append_si(&column[range.clone()], x),
                false => x.extend(rows.iter().map(|&r| s.si(column[r]))),
            }
        }
        if self.effort_is == Effort::PositionError {
            self.report.goals.resize_with(columns.effort.len(), GoalSpan::default);
            let joints = columns.effort.iter().zip(&self.q).zip(&mut self.effort).zip(&mut self.report.goals);
            let driven = joints.filter(|(((s, _), _), _)| s.header != NO_COLUMN);
            driven.for_each(|(((s, q), goal), span)| span.take(&s.header, &q[before..], &mut goal[before..]));
        }
        self.rows.extend(rows.iter().map(|r| table.skipped + r + 1));
        self.report.count(&LogReport { rows: range.len(), ragged, left_out, ..LogReport::default() });
        Ok(())
    }

    /// Reserves memory for `samples` samples in total.
    pub(crate) fn reserve(&mut self, samples: usize) {
        let more = samples.saturating_sub(self.len());
        self.series_mut().for_each(|x| x.reserve_exact(more));
        self.rows.reserve_exact(more);
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// All series except the time.
    fn signals(&self) -> impl Iterator<Item = &Vec<f64>> {
        let optional = self.dq.iter().chain(&self.ddq).flatten();
        self.q.iter().chain(optional).chain(&self.effort)
    }

    /// All series, the time first.
    pub(crate) fn series_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        let optional = self.dq.iter_mut().chain(&mut self.ddq).flatten();
        std::iter::once(&mut self.t).chain(&mut self.q).chain(optional).chain(&mut self.effort)
    }

    /// The samples in a range, with the names and the report of the whole log.
    pub(crate) fn range(&self, range: Range<usize>) -> Log {
        let cut = |x: &Vec<f64>| x[range.clone()].to_vec();
        let all = |x: &Vec<Vec<f64>>| x.iter().map(cut).collect::<Vec<_>>();
        Log {
            name: self.name.clone(),
            coordinates: self.coordinates.clone(),
            t: cut(&self.t),
            q: all(&self.q),
            dq: self.dq.as_ref().map(all),
            ddq: self.ddq.as_ref().map(all),
            effort: all(&self.effort),
            effort_is: self.effort_is,
            rows: self.rows[range.clone()].to_vec(),
            window: self.window,
            report: self.report.clone(),
        }
    }

    /// The segments of the log between gaps of the clock. Segments that are too short for filtering are omitted.
    pub fn segments(&self) -> Vec<Log> {
        let period = self.report.clock.period;
        let gap = GAP_PERIODS * period;
        let mut segments = Vec::new();
        let mut first = 0;
        for end in 1..=self.len() {
            if end == self.len() || self.t[end] - self.t[end - 1] > gap {
                if end - first >= MIN_ROWS {
                    let mut segment = self.range(first..end);
                    segment.report.clock.uniform = segment.t.windows(2).all(|w| even(w[1] - w[0], period));
                    segment.report.clock.duration = segment.t[segment.len() - 1] - segment.t[0];
                    segments.push(segment);
                }
                first = end;
            }
        }
        segments
    }

    /// Appends the samples in a range of a later block of the same file.
    pub(crate) fn append(&mut self, next: &Log, range: Range<usize>) {
        for (x, y) in self.series_mut().zip(std::iter::once(&next.t).chain(next.signals())) {
            x.extend_from_slice(&y[range.clone()]);
        }
        self.rows.extend_from_slice(&next.rows[range]);
    }

    pub(crate) fn describe(&mut self) {
        self.report.kept = self.len();
        let Some(clock) = Clock::of(&self.t) else { return };
        let refresh = self.refresh(clock.period);
        let (suspect, wrapped) = self.suspects();
        self.report = LogReport {
            wrapped,
            suspect,
            refresh,
            repeated: (1..self.len()).filter(|&r| self.signals().all(|s| s[r] == s[r - 1])).count(),
            clock,
            rest: RestTimes::of(&self.t, &self.q),
            ..self.report.clone()
        };
    }

    /// The time between new values of the signals. `period`: time between rows, s.
    fn refresh(&self, period: f64) -> Refresh {
        let motion: Vec<&[f64]> =
            self.q.iter().chain(self.dq.iter().chain(&self.ddq).flatten()).map(Vec::as_slice).collect();
        let effort: Vec<&[f64]> = self.effort.iter().map(Vec::as_slice).collect();
        Refresh::of(&motion, &effort, period)
    }

    /// Finds suspicious signals of each coordinate, in parallel, and removes jumps by a turn. Also returns the number of these
    /// jumps.
    fn suspects(&mut self) -> (Vec<Suspect>, usize) {
        let (foreign_rows, foreign_are_zero) = foreign_rows(self.dq.as_deref(), &self.effort);
        let velocities: Vec<Option<&[f64]>> = match &self.dq {
            Some(dq) => dq.iter().map(|dq| Some(dq.as_slice())).collect(),
            None => vec![None; self.q.len()],
        };
        let series = self.coordinates.iter().zip(&mut self.q).zip(velocities).zip(&self.effort).collect();
        type Coordinate<'a> = (((&'a String, &'a mut Vec<f64>), Option<&'a [f64]>), &'a Vec<f64>);
        let found = in_parallel_series(self.t.len(), series, |(((name, q), velocity), effort): Coordinate| {
            let (suspect, wrapped) = Suspect::of(name, &self.t, q, velocity, effort);
            // If a second source writes zero torques, these zeros are not a limit of the torque.
            let saturated = suspect.saturated.filter(|_| foreign_rows == 0);
            (Suspect { foreign_rows, foreign_are_zero, saturated, ..suspect }, wrapped)
        });
        let wrapped = found.iter().map(|(_, wrapped)| wrapped).sum();
        let undriven = self.report.undriven.iter().copied().chain(std::iter::repeat(None));
        let suspects = found.into_iter().zip(undriven).map(|((suspect, _), undriven)| suspect.undriven(undriven));
        (suspects.collect(), wrapped)
    }
}

fn check_texts(table: &Table, columns: &Columns) -> Result<(), Error> {
    for source in columns.sources().chain(&columns.time_fraction).chain(&columns.episode) {
        if let Some((line, text)) = &table.texts[source.column] {
            let message = format!("column `{}`: `{}` is not a number", source.header, text);
            return Err(Error::at(&table.file, *line, message));
        }
    }
    Ok(())
}

/// The usable rows, with their times.
struct Usable {
    rows: Vec<usize>,
    times: Vec<f64>,
    left_out: LeftOutRows,
}

/// The rows in a range that have finite numbers and a clock that advances. All other rows are counted.
fn usable_rows(table: &Table, columns: &Columns, range: Range<usize>, clock: &mut Timeline) -> Usable {
    let mut left_out = LeftOutRows::default();
    let mut finite = vec![true; range.len()];
    for source in columns.sources() {
        let column = &table.columns[source.column][range.clone()];
        finite.iter_mut().zip(column).for_each(|(finite, x)| *finite &= x.is_finite());
    }
    let (mut rows, mut times) = (Vec::with_capacity(range.len()), Vec::with_capacity(range.len()));
    for (r, finite) in range.zip(finite) {
        if !finite {
            left_out.not_finite += 1;
            left_out.first_not_finite.get_or_insert(table.line(r));
        } else if let Some(time) = clock.time(table, columns, r, &mut left_out) {
            rows.push(r);
            times.push(time);
        }
    }
    Usable { rows, times, left_out }
}

/// An interval of a log, including its ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Window {
    /// Time interval, s: start and end.
    Seconds(f64, f64),
    /// First and last row of the file, counted from 1.
    Rows(usize, usize),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Log, Error> {
        let table = Table::from_bytes("log.csv", text.as_bytes())?;
        let columns = Columns::find(&table, &["q1".into()], &ColumnNames::default())?;
        Log::from_table(&table, &columns)
    }

    fn rows(n: usize, row: impl Fn(usize) -> String) -> String {
        std::iter::once("t,q1,tau1\n".to_string()).chain((0..n).map(row)).collect()
    }

    #[test]
    fn bad_rows_are_left_out_and_counted() {
        let text = rows(200, |i| match i {
            10 => "0.10,nan,1\n".into(),
            11 => "0.11,,1\n".into(),
            12 => "0.12,inf,1\n".into(),
            20 => "0.19,0,1\n".into(),
            30 => "0.05,0,1\n".into(),
            _ => format!("{},{},1\n", i as f64 * 0.01, (i as f64 * 0.1).sin()),
        });
        let log = read(&text).unwrap();
        let (r, out) = (&log.report, &log.report.left_out);
        assert_eq!((r.rows, r.kept), (200, 195));
        assert_eq!((out.not_finite, out.clock_repeated, out.clock_backwards), (3, 1, 1));
        assert_eq!(out.first_not_finite, Some(12));
        assert!(!r.clock.uniform);
    }

    #[test]
    fn rest_is_measured() {
        let text = rows(1000, |i| {
            let t = i as f64 * 0.01;
            format!("{t},{},1.0\n", if (2.0..7.0).contains(&t) { (t - 2.0).sin() } else { 0.0 })
        });
        let r = read(&text).unwrap().report;
        assert!(r.clock.uniform);
        assert!((r.rest.before - 2.0).abs() < 0.1 && (r.rest.after - 3.0).abs() < 0.1, "{r:?}");
        let said = "at rest 4.97 s: 1.99 s at the start, 0.00 s between, 2.98 s at the end";
        assert!(r.to_string().contains(said), "{r}");
        // The durations add up for different lengths of the last, incomplete interval.
        for end in [6.97, 6.99, 7.02] {
            let text = rows(703, |i| {
                let t = i as f64 * 0.01;
                format!("{t},{},1.0\n", if (2.0..end).contains(&t) { (t - 2.0).sin() } else { 0.0 })
            });
            let r = read(&text).unwrap().report;
            // Allowance for the rounding of sums of durations.
            assert!(r.rest.before + r.rest.after <= r.rest.total + 1e-9, "{r:?}");
        }
        let still = rows(200, |i| format!("{},0,{}\n", i as f64 * 0.01, i % 7));
        assert!(read(&still).unwrap().report.to_string().contains("at rest throughout"));
    }

    #[test]
    fn a_clock_that_hardly_steps_is_refused() {
        let message = read(&rows(60, |i| format!("{i}e-14,{i},1\n"))).unwrap_err().to_string();
        assert!(message.contains("column `t` steps by 1.0000000000000"), "{message}");
    }
}
