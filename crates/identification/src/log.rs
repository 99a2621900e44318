//! A log of a robot: measured joint signals against time, cleaned, with an account of the cleaning.
//!
//! Rows that cannot be used (a number missing or infinite, a clock that does not advance) are left
//! out and counted; nothing is invented here. Filtering and differentiation are in `signal`.

use std::fmt;
use std::path::Path;

use serde::Serialize;

use crate::Error;
use crate::columns::{ColumnNames, Columns};
use crate::header::Quantity;
use crate::signal::Window;
use crate::table::Table;

/// What the effort columns of a log hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// N m (N for a prismatic joint).
    Torque,
    /// A; drive gains make torques of it.
    Current,
}

/// Measured signals of one run, SI, one series a coordinate in the order of the robot.
#[derive(Clone, Debug)]
pub struct Log {
    pub name: String,
    pub coordinates: Vec<String>,
    /// s, strictly increasing; row r of every series is at `t[r]`.
    pub t: Vec<f64>,
    /// rad (m).
    pub q: Vec<Vec<f64>>,
    /// rad/s, where measured.
    pub dq: Option<Vec<Vec<f64>>>,
    /// rad/s^2, where measured.
    pub ddq: Option<Vec<Vec<f64>>>,
    pub effort: Vec<Vec<f64>>,
    pub effort_is: Effort,
    /// The row of the file, from 1, behind each sample.
    pub rows: Vec<usize>,
    /// Use samples in this interval only, instead of that of the options.
    pub window: Option<Window>,
    pub report: LogReport,
}

/// What was found in a log and what was done about it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LogReport {
    /// Rows of the file and rows kept.
    pub rows: usize,
    pub kept: usize,
    /// Rows left out because a number is missing, NaN or infinite; the first such line.
    pub not_finite: usize,
    pub first_not_finite: Option<usize>,
    /// Rows left out because the clock stands still, or runs backwards.
    pub clock_repeated: usize,
    pub clock_backwards: usize,
    /// Rows with more or fewer cells than the header.
    pub ragged: usize,
    /// Kept rows in which every signal but the time is as in the row before.
    pub repeated: usize,
    /// s: first to last sample, median and largest step; `uniform` when no step is 1 % off the median.
    pub duration: f64,
    pub period: f64,
    pub longest_step: f64,
    pub uniform: bool,
    /// Steps longer than [`GAP`] periods.
    pub gaps: usize,
    /// s at rest before the first and after the last motion, and in all.
    pub rest_before: f64,
    pub rest_after: f64,
    pub rest: f64,
}

/// A step of the clock this many times the median is a gap: nothing is interpolated across it.
pub const GAP: f64 = 10.0;

/// A log runs backwards in more rows than this share: two runs in one file, not a clock's jitter.
const BACKWARDS: f64 = 0.01;

/// At rest: no joint is faster than this, rad/s, over [`REST_SPAN`] s.
const REST_SPEED: f64 = 1e-3;
const REST_SPAN: f64 = 0.05;

impl Log {
    /// Reads a file and finds the columns of the coordinates in it.
    pub fn read(path: &Path, coordinates: &[String], names: &ColumnNames) -> Result<(Log, Columns), Error> {
        let table = Table::read(path)?;
        let columns = Columns::find(&table, coordinates, names)?;
        Ok((Log::from_table(&table, &columns)?, columns))
    }

    /// Takes the signals out of a table.
    ///
    /// Fails when a used column holds text, when fewer than [`MIN_ROWS`] rows are usable, or when
    /// the clock is no clock.
    pub fn from_table(table: &Table, columns: &Columns) -> Result<Log, Error> {
        check_texts(table, columns)?;
        let mut report = LogReport { rows: table.rows(), ragged: table.ragged, ..LogReport::default() };
        let rows = usable_rows(table, columns, &mut report)?;
        let take = |s: &crate::columns::Source| rows.iter().map(|&r| s.factor * table.columns[s.column][r]).collect();
        let series = |sources: &[crate::columns::Source]| -> Vec<Vec<f64>> { sources.iter().map(take).collect() };
        let mut log = Log {
            name: table.file.clone(),
            coordinates: columns.coordinates.clone(),
            t: take(&columns.time),
            q: series(&columns.position),
            dq: columns.velocity.as_deref().map(series),
            ddq: columns.acceleration.as_deref().map(series),
            effort: series(&columns.effort),
            effort_is: if columns.effort_is == Quantity::Current { Effort::Current } else { Effort::Torque },
            rows: rows.iter().map(|r| r + 1).collect(),
            window: None,
            report,
        };
        log.describe(table)?;
        Ok(log)
    }

    pub fn len(&self) -> usize {
        self.t.len()
    }

    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// All series but the time.
    fn signals(&self) -> impl Iterator<Item = &Vec<f64>> {
        let optional = self.dq.iter().chain(&self.ddq).flatten();
        self.q.iter().chain(optional).chain(&self.effort)
    }

    fn describe(&mut self, table: &Table) -> Result<(), Error> {
        let mut steps: Vec<f64> = self.t.windows(2).map(|w| w[1] - w[0]).collect();
        let longest = steps.iter().copied().fold(0.0, f64::max);
        steps.sort_by(f64::total_cmp);
        let period = steps[steps.len() / 2];
        let duration = self.t[self.len() - 1] - self.t[0];
        if !(period.is_finite() && duration.is_finite()) {
            return Err(Error::at(&table.file, 0, "the clock leaves the range of numbers"));
        }
        let repeated = (1..self.len()).filter(|&r| self.signals().all(|s| s[r] == s[r - 1])).count();
        if repeated + 1 == self.len() {
            return Err(Error::at(
                &table.file,
                0,
                "every row holds the same values: nothing moves and nothing is measured",
            ));
        }
        let (before, after, rest) = self.rest();
        self.report = LogReport {
            kept: self.len(),
            repeated,
            duration,
            period,
            longest_step: longest,
            uniform: steps.iter().all(|s| (s - period).abs() <= 0.01 * period),
            gaps: steps.iter().filter(|&&s| s > GAP * period).count(),
            rest_before: before,
            rest_after: after,
            rest,
            ..self.report.clone()
        };
        Ok(())
    }

    /// s at rest at the start, at the end, and in all.
    fn rest(&self) -> (f64, f64, f64) {
        let (mut before, mut total, mut last_motion, mut r0) = (None, 0.0, self.t[0], 0);
        for r in 1..self.len() {
            if self.t[r] - self.t[r0] < REST_SPAN {
                continue;
            }
            let span = self.t[r] - self.t[r0];
            if self.q.iter().any(|q| (q[r] - q[r0]).abs() > REST_SPEED * span) {
                before.get_or_insert(self.t[r0] - self.t[0]);
                last_motion = self.t[r];
            } else {
                total += span;
            }
            r0 = r;
        }
        let end = self.t[self.len() - 1];
        (before.unwrap_or(end - self.t[0]), end - last_motion, total)
    }
}

/// Fewer samples than this cannot be filtered and differentiated.
pub const MIN_ROWS: usize = 50;

fn check_texts(table: &Table, columns: &Columns) -> Result<(), Error> {
    for source in columns.sources() {
        if let Some((line, text)) = &table.texts[source.column] {
            let hint = if text.contains(',') { " (decimal commas are not read)" } else { "" };
            let message = format!("column `{}`: `{}` is not a number{hint}", source.header, text);
            return Err(Error::at(&table.file, *line, message));
        }
    }
    Ok(())
}

/// The rows with finite numbers and an advancing clock.
fn usable_rows(table: &Table, columns: &Columns, report: &mut LogReport) -> Result<Vec<usize>, Error> {
    if table.rows() == 0 {
        return Err(Error::at(&table.file, 1, "there is a header but no row of numbers below it"));
    }
    let clock = &table.columns[columns.time.column];
    let mut rows: Vec<usize> = Vec::with_capacity(table.rows());
    let mut backwards_at = 0;
    for r in 0..table.rows() {
        if columns.sources().any(|s| !table.columns[s.column][r].is_finite()) {
            report.not_finite += 1;
            report.first_not_finite.get_or_insert(table.line(r));
            continue;
        }
        match rows.last().map(|&last| clock[r].total_cmp(&clock[last])) {
            Some(std::cmp::Ordering::Equal) => report.clock_repeated += 1,
            Some(std::cmp::Ordering::Less) => {
                if report.clock_backwards == 0 {
                    backwards_at = r;
                }
                report.clock_backwards += 1;
            }
            _ => rows.push(r),
        }
    }
    let time = &columns.time.header;
    if report.clock_backwards as f64 > BACKWARDS * table.rows() as f64 {
        let message = format!(
            "column `{time}` runs backwards in {} rows, here first: two runs in one file, or not the time; split the file",
            report.clock_backwards
        );
        return Err(Error::at(&table.file, table.line(backwards_at), message));
    }
    if report.clock_repeated as f64 > 0.5 * table.rows() as f64 {
        let message = format!(
            "column `{time}` stands still in {} of {} rows; it is not the time",
            report.clock_repeated,
            table.rows()
        );
        return Err(Error::at(&table.file, 0, message));
    }
    if let Some(s) = columns.sources().find(|s| table.columns[s.column].iter().all(|x| !x.is_finite())) {
        let message = format!("column `{}` holds no number at all", s.header);
        return Err(Error::at(&table.file, 0, message));
    }
    if rows.len() < MIN_ROWS {
        let message = format!(
            "{} usable rows of {} ({} with missing or infinite numbers); at least {MIN_ROWS} are needed",
            rows.len(),
            table.rows(),
            report.not_finite
        );
        return Err(Error::at(&table.file, 0, message));
    }
    Ok(rows)
}

impl fmt::Display for LogReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let clock = if self.uniform { "uniform" } else { "not uniform" };
        writeln!(
            f,
            "{} rows, {} used; {:.3} s, median step {:.6} s ({clock}, longest {:.6} s)",
            self.rows, self.kept, self.duration, self.period, self.longest_step
        )?;
        let line = self.first_not_finite.map_or(String::new(), |l| format!(", first in line {l}"));
        for (count, what) in [
            (self.not_finite, format!("rows left out: a number is missing or infinite{line}")),
            (self.clock_repeated, "rows left out: the clock repeats".into()),
            (self.clock_backwards, "rows left out: the clock runs backwards".into()),
            (self.ragged, "rows with more or fewer cells than the header".into()),
            (self.repeated, "rows repeat the row before (kept)".into()),
            (self.gaps, format!("gaps in the clock longer than {GAP} steps (samples within are not used)")),
        ] {
            if count > 0 {
                writeln!(f, "{count} {what}")?;
            }
        }
        if self.rest > 0.0 {
            let (before, after) = (self.rest_before, self.rest_after);
            writeln!(f, "at rest {:.2} s ({before:.2} s at the start, {after:.2} s at the end)", self.rest)?;
        }
        Ok(())
    }
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
        let r = &log.report;
        assert_eq!((r.rows, r.kept, r.not_finite, r.clock_repeated, r.clock_backwards), (200, 195, 3, 1, 1));
        assert_eq!(r.first_not_finite, Some(12));
        assert!(!r.uniform);
    }

    #[test]
    fn rest_is_measured() {
        let text = rows(1000, |i| {
            let t = i as f64 * 0.01;
            format!("{t},{},1.0\n", if (2.0..7.0).contains(&t) { (t - 2.0).sin() } else { 0.0 })
        });
        let r = read(&text).unwrap().report;
        assert!(r.uniform);
        assert!((r.rest_before - 2.0).abs() < 0.1 && (r.rest_after - 3.0).abs() < 0.1, "{r:?}");
    }

    #[test]
    fn refusals_say_where() {
        for (text, expected) in [
            ("t,q1,tau1\n".to_string(), "log.csv:1: there is a header but no row"),
            (rows(60, |i| format!("{i},x,1\n")), "log.csv:2: column `q1`: `x` is not a number"),
            (rows(60, |i| format!("{i},nan,1\n")), "column `q1` holds no number at all"),
            (rows(9, |i| format!("{i},{i},1\n")), "9 usable rows of 9"),
            (rows(60, |i| format!("{},{i},1\n", 60 - i)), "log.csv:3: column `t` runs backwards in 59 rows"),
            (rows(60, |i| format!("1,{i},1\n")), "column `t` stands still in 59 of 60 rows"),
            (rows(60, |i| format!("{i},1,1\n")), "every row holds the same values"),
        ] {
            let message = read(&text).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
