//! The report on the cleaning of a log: which rows were used, and which faults were found or corrected.
//!
//! Signals are the columns with a meaning: time, positions, velocities, accelerations, efforts (torques, currents, or goals of
//! position servos). An episode is a part of the file with its own clock. A long log is read in blocks, and the reports on the
//! blocks are added.

use std::fmt;

use crate::Error;
use crate::cleaning::clock::{Clock, GAP_PERIODS, MIN_ROWS};
use crate::cleaning::goals::GoalSpan;
use crate::cleaning::refresh::Refresh;
use crate::cleaning::rest::RestTimes;
use crate::cleaning::suspects::Suspect;
use crate::cleaning::undriven::NoTorqueReason;

/// The report of the cleaning of a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogReport {
    /// Number of rows in the file.
    pub rows: usize,
    /// Number of rows that are used.
    pub kept: usize,
    /// The rows that are not used, with the reasons.
    pub left_out: LeftOutRows,
    /// The columns of the file that are used.
    pub columns: ReadColumns,
    /// For each coordinate, the reason why it has no torque; `None` if it has a torque.
    pub undriven: Vec<Option<NoTorqueReason>>,
    /// For each coordinate, the range of the goals. Empty unless the efforts are goals of position servos.
    pub goals: Vec<GoalSpan>,
    /// Number of rows with more or fewer cells than the header.
    pub ragged: usize,
    /// Number of used rows in which every signal except the time equals its value in the previous row.
    pub repeated: usize,
    /// Time between new values of the signals, s.
    pub refresh: Refresh,
    /// The clock of the used rows.
    pub clock: Clock,
    /// Number of jumps by a full turn in the positions. They were removed.
    pub wrapped: usize,
    /// For each coordinate, findings in its signals that no robot can produce.
    pub suspect: Vec<Suspect>,
    /// Durations at rest, s.
    pub rest: RestTimes,
}

/// Names of the columns that were read. Each list has one name per coordinate; a `-` before a name means that the sign of the
/// numbers was changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadColumns {
    /// Columns of the positions.
    pub position: Vec<String>,
    /// Columns of the velocities; `None` if there are none.
    pub velocity: Option<Vec<String>>,
    /// Columns of the accelerations; `None` if there are none.
    pub acceleration: Option<Vec<String>>,
    /// Columns of the torques, currents or goals. A coordinate without such a column has no entry.
    pub effort: Vec<String>,
}

/// Numbers of rows that are not used, and numbers of episodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LeftOutRows {
    /// Number of rows with a missing, NaN or infinite number.
    pub not_finite: usize,
    /// Line of the first row with such a number; `None` if there is none.
    pub first_not_finite: Option<usize>,
    /// Number of rows with the same time as the previous row.
    pub clock_repeated: usize,
    /// Number of rows with a time before the largest time of the earlier rows.
    pub clock_backwards: usize,
    /// Line of the first row with a time before the largest earlier time; `None` if there is none.
    pub first_backwards: Option<usize>,
    /// Number of rows with a time before the time of the previous row.
    pub clock_steps_back: usize,
    /// Number of new episodes that were found because the episode number changed.
    pub episodes_by_column: usize,
    /// Number of new episodes that were found because the clock restarted. The first row of each is not used.
    pub episodes_by_clock: usize,
}

/// If the clock runs backwards in a larger share of the rows, the cause is not jitter: the file contains two runs.
const LARGEST_BACKWARD_SHARE: f64 = 0.01;

/// If the clock steps back in this share of the rows, the rows of two sources with different clocks alternate. The source with
/// fewer rows causes the steps back, so the share is at most one half. A clock that counts down steps back in all rows.
const INTERLEAVED_BACKWARD_SHARES: std::ops::Range<f64> = 0.1..0.55;
/// If the time is repeated in a larger share of the rows, the column is not the time.
const MAX_REPEATED_SHARE: f64 = 0.5;

impl LogReport {
    /// A report on `rows` rows that are all used. `period`: time between rows, s.
    pub fn uniform(rows: usize, period: f64) -> LogReport {
        let duration = rows.saturating_sub(1) as f64 * period;
        let clock = Clock { duration, period, longest_step: period, uniform: true, gaps: 0 };
        LogReport { rows, kept: rows, clock, ..LogReport::default() }
    }

    /// Adds the report on the next block of the same file. The block starts `step` s after the end of this one.
    pub(crate) fn append(&mut self, next: &LogReport, step: f64) {
        if self.kept < 2 {
            let counts = std::mem::replace(self, next.clone());
            return self.count(&counts);
        }
        self.rest.append(self.clock.duration, &next.rest, next.clock.duration, step);
        self.clock.append((next.kept >= 2).then_some(&next.clock), step);
        self.count(next);
    }

    /// Adds the counts of another report; the clock is not changed.
    pub(crate) fn count(&mut self, other: &LogReport) {
        self.rows += other.rows;
        self.kept += other.kept;
        self.left_out.count(&other.left_out);
        self.ragged += other.ragged;
        self.repeated += other.repeated;
        self.refresh.append(&other.refresh);
        match self.goals.is_empty() {
            true => self.goals.clone_from(&other.goals),
            false => self.goals.iter_mut().zip(&other.goals).for_each(|(a, b)| a.append(b)),
        }
        self.wrapped += other.wrapped;
        if self.suspect.is_empty() {
            self.suspect.clone_from(&other.suspect);
        } else {
            self.suspect.iter_mut().zip(&other.suspect).for_each(|(a, b)| a.append(b));
        }
    }

    /// Fails if the file is not a usable log. `time`: header of the clock column, for messages.
    pub(crate) fn check(&self, file: &str, time: &str) -> Result<(), Error> {
        if self.rows == 0 {
            return Err(Error::at(file, 1, "there is a header but no row of numbers below it"));
        }
        self.left_out.check(file, time, self.rows)?;
        self.check_rows(file)?;
        self.clock.check(file, time, self.kept)?;
        if self.repeated + 1 == self.kept {
            return Err(Error::at(file, 0, "every row holds the same values: nothing moves and nothing is measured"));
        }
        self.goals.iter().try_for_each(|goal| goal.check(file))
    }

    /// Fails if more than half of the rows have a wrong number of cells, or if fewer than [`MIN_ROWS`] rows are usable.
    fn check_rows(&self, file: &str) -> Result<(), Error> {
        let LogReport { rows, kept, ragged, left_out: LeftOutRows { not_finite, .. }, .. } = self;
        let message = if *ragged > rows / 2 {
            format!("{ragged} of {rows} rows have more or fewer cells than the header has names")
        } else if *kept < MIN_ROWS {
            format!(
                "{kept} usable rows of {rows} ({not_finite} with missing or infinite numbers); at least {MIN_ROWS} are needed"
            )
        } else {
            return Ok(());
        };
        Err(Error::at(file, 0, message))
    }
}

impl LeftOutRows {
    /// Adds the counts of another block of the log.
    fn count(&mut self, other: &LeftOutRows) {
        self.not_finite += other.not_finite;
        self.first_not_finite = self.first_not_finite.or(other.first_not_finite);
        self.clock_repeated += other.clock_repeated;
        self.clock_backwards += other.clock_backwards;
        self.first_backwards = self.first_backwards.or(other.first_backwards);
        self.clock_steps_back += other.clock_steps_back;
        self.episodes_by_column += other.episodes_by_column;
        self.episodes_by_clock += other.episodes_by_clock;
    }

    /// Fails if the clock runs backwards or repeats its time in many rows.
    fn check(&self, file: &str, time: &str, rows: usize) -> Result<(), Error> {
        let refused = |line: Option<usize>, message: String| Err(Error::at(file, line.unwrap_or(0), message));
        let LeftOutRows { clock_steps_back, clock_repeated, first_backwards, .. } = self;
        // If a file contains two runs, the clock steps back only once, but the times of all later rows are too small.
        if INTERLEAVED_BACKWARD_SHARES.contains(&(*clock_steps_back as f64 / rows as f64)) {
            let message = format!(
                "column `{time}` runs back and forth in {clock_steps_back} of {rows} rows, here first: two publishers on one \
                 topic, each with its own clock? Log one of them (in ROS `ros2 topic info -v TOPIC` names them), or leave \
                 out the rows of the other"
            );
            return refused(*first_backwards, message);
        }
        // The clock may run backwards in a few rows because of jitter. The first rows of each episode were also counted, before
        // the episode was recognised, so they are subtracted.
        let slips = self.clock_backwards.saturating_sub(self.episodes_by_clock);
        if slips as f64 > LARGEST_BACKWARD_SHARE * rows as f64 {
            let message = format!(
                "column `{time}` runs backwards in {slips} rows, here first: two runs in one file, or not the time; split the file",
            );
            return refused(*first_backwards, message);
        }
        if *clock_repeated as f64 > MAX_REPEATED_SHARE * rows as f64 {
            let message = format!(
                "column `{time}` stands still in {clock_repeated} of {rows} rows; it is not the time: if the rows are equally spaced, say the rows per second, [rate=HZ]"
            );
            return refused(None, message);
        }
        Ok(())
    }
}

impl fmt::Display for LogReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let left_out = &self.left_out;
        // Each count is a number of new episodes; the first episode of the file is not counted.
        writeln!(f, "{} rows, {} used; {}", self.rows, self.kept, self.clock.in_words())?;
        for (begun, why) in [
            (left_out.episodes_by_column, "the column that numbers them changes"),
            (left_out.episodes_by_clock, "the clock begins anew"),
        ] {
            if begun > 0 {
                let all = begun + 1;
                writeln!(f, "{all} episodes: {why}; each is filtered by itself, and a pause stands between them")?;
            }
        }
        let of_gaps =
            format!("in the clock longer than {GAP_PERIODS} steps (the parts between are filtered by themselves)");
        let episodes = left_out.episodes_by_column + left_out.episodes_by_clock;
        let line = left_out.first_not_finite.map_or(String::new(), |l| format!(", first in line {l}"));
        // Writes one line for each count above zero.
        for (count, one, more, what) in [
            (left_out.not_finite, "row", "rows", format!("left out: a number is missing or infinite{line}")),
            (left_out.clock_repeated, "row", "rows", "left out: the clock repeats".into()),
            (left_out.clock_backwards, "row", "rows", "left out: the clock runs backwards".into()),
            (self.ragged, "row", "rows", "with more or fewer cells than the header".into()),
            (self.wrapped, "jump", "jumps", "by a turn in the positions, taken back".into()),
            (self.repeated, "row repeats", "rows repeat", "the row before (kept)".into()),
            (self.clock.gaps.saturating_sub(episodes), "gap", "gaps", of_gaps),
        ] {
            if count > 0 {
                writeln!(f, "{count} {} {what}", if count == 1 { one } else { more })?;
            }
        }
        // Writes the sentences on slow signals, on suspicious signals and on rest.
        self.refresh.sentence(self.clock.period).iter().try_for_each(|s| writeln!(f, "{s}"))?;
        self.suspect.iter().try_for_each(|s| write!(f, "{s}"))?;
        self.rest.sentence(self.clock.duration).iter().try_for_each(|s| writeln!(f, "{s}"))
    }
}
