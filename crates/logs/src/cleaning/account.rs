//! What was found in a log and what was done about it.

use std::fmt;

use serde::Serialize;

use crate::Error;
use crate::cleaning::goals::GoalSpan;
use crate::cleaning::refresh::Refresh;
use crate::cleaning::suspects::Suspect;
use crate::cleaning::undriven::Undriven;

/// The account of the cleaning of a log.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LogReport {
    /// Rows of the file.
    pub rows: usize,
    /// Rows that are used.
    pub kept: usize,
    /// Rows left out because a number is missing, NaN or infinite.
    pub not_finite: usize,
    /// Line of the first of them.
    pub first_not_finite: Option<usize>,
    /// Rows left out because the clock stands still.
    pub clock_repeated: usize,
    /// Rows left out because the clock runs backwards.
    pub clock_backwards: usize,
    /// The first line on which the clock runs backwards.
    pub first_backwards: Option<usize>,
    /// Rows whose clock is behind that of the row before.
    pub clock_steps_back: usize,
    /// Episodes that begin where a column changes that numbers them.
    #[serde(skip_serializing_if = "is_zero")]
    pub episodes_by_column: usize,
    /// Episodes that begin where the clock begins anew; the first row of each is left out.
    #[serde(skip_serializing_if = "is_zero")]
    pub episodes_by_clock: usize,
    /// One per coordinate: why there is no torque; `None`: there is one.
    #[serde(skip)]
    pub undriven: Vec<Option<Undriven>>,
    /// One per coordinate, where position servos are told goals: what the goals are.
    #[serde(skip)]
    pub goals: Vec<GoalSpan>,
    /// Rows with more or fewer cells than the header.
    pub ragged: usize,
    /// Kept rows in which every signal but the time is as in the row before.
    pub repeated: usize,
    /// How often new values come.
    pub refresh: Refresh,
    /// s, from the first to the last sample.
    pub duration: f64,
    /// s, the median step of the clock.
    pub period: f64,
    /// s, the longest step of the clock.
    pub longest_step: f64,
    /// Whether no step is 1 % off the median.
    pub uniform: bool,
    /// Steps longer than [`GAP_PERIODS`] periods.
    pub gaps: usize,
    /// Jumps by a turn in the positions, taken back.
    pub wrapped: usize,
    /// What each coordinate's signals hold that no robot does.
    pub suspect: Vec<Suspect>,
    /// s at rest at the start.
    pub rest_before: f64,
    /// s at rest at the end.
    pub rest_after: f64,
    /// s at rest in all.
    pub rest: f64,
}

/// A step of the clock this many times the median is a gap: nothing is interpolated across it.
pub const GAP_PERIODS: f64 = 10.0;

/// If the clock runs backwards in a larger share of the rows, that is no jitter: the file holds two runs.
const LARGEST_BACKWARD_SHARE: f64 = 0.01;

/// Shares of the rows at which the clock steps back where two clocks take turns: the share of the slower source, up to a
/// half. A clock that counts down steps back in all rows.
const INTERLEAVED_BACKWARD_SHARES: std::ops::Range<f64> = 0.1..0.55;

/// A clock with a larger step, s, is taken to be in another unit, unless its header says seconds.
pub(crate) const SLOWEST_CLOCK_STEP_S: f64 = 0.5;

/// A clock with a smaller step, s, is in another unit, because no robot is sampled that fast.
const FASTEST_CLOCK_STEP_S: f64 = 1e-6;

/// Fewer samples than this cannot be filtered and differentiated.
pub(crate) const MIN_ROWS: usize = 50;

impl LogReport {
    /// Adds the next part of the same file, which starts `step` s after the end of this.
    pub(crate) fn append(&mut self, next: &LogReport, step: f64) {
        if self.kept < 2 {
            let counts = std::mem::replace(self, next.clone());
            return self.count(&counts);
        }
        self.uniform &= even(step, self.period) && (next.kept < 2 || (next.uniform && even(next.period, self.period)));
        self.longest_step = self.longest_step.max(next.longest_step).max(step);
        self.gaps += next.gaps + usize::from(step > GAP_PERIODS * self.period);
        // At rest on both sides of the seam, the joints are at rest across it.
        let seam = if self.rest_after > 0.0 && next.rest_before > 0.0 { step } else { 0.0 };
        let resting = |r: &LogReport| r.rest > 0.0 && r.rest_before >= r.duration;
        if resting(self) {
            self.rest_before += seam + next.rest_before;
        }
        self.rest_after = next.rest_after + if resting(next) { self.rest_after + seam } else { 0.0 };
        self.rest += seam + next.rest;
        self.duration += step + next.duration;
        self.count(next);
    }

    /// Adds the counts of another part, but nothing of its clock.
    pub(crate) fn count(&mut self, other: &LogReport) {
        self.rows += other.rows;
        self.kept += other.kept;
        self.not_finite += other.not_finite;
        self.first_not_finite = self.first_not_finite.or(other.first_not_finite);
        self.clock_repeated += other.clock_repeated;
        self.clock_backwards += other.clock_backwards;
        self.first_backwards = self.first_backwards.or(other.first_backwards);
        self.clock_steps_back += other.clock_steps_back;
        self.episodes_by_column += other.episodes_by_column;
        self.episodes_by_clock += other.episodes_by_clock;
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

    /// Refuses a whole file that is no log; `time` is the header of its clock.
    pub(crate) fn check(&self, file: &str, time: &str) -> Result<(), Error> {
        if self.rows == 0 {
            return Err(Error::at(file, 1, "there is a header but no row of numbers below it"));
        }
        self.check_order(file, time)?;
        self.check_rows(file)?;
        self.check_steps(file, time)?;
        if self.repeated + 1 == self.kept {
            return Err(Error::at(file, 0, "every row holds the same values: nothing moves and nothing is measured"));
        }
        self.goals.iter().try_for_each(|goal| goal.check(file))
    }

    /// Refuses a clock that runs backwards or stands still in many rows.
    fn check_order(&self, file: &str, time: &str) -> Result<(), Error> {
        let at = |line: usize, message: String| Err(Error::at(file, line, message));
        // Two runs in one file step back once, and all that follows is behind.
        let backwards = self.clock_steps_back as f64 / self.rows as f64;
        if INTERLEAVED_BACKWARD_SHARES.contains(&backwards) {
            let message = format!(
                "column `{time}` runs back and forth in {} of {} rows, here first: two publishers on one topic, each with its \
                 own clock? Log one of them (in ROS `ros2 topic info -v TOPIC` names them), or leave out the rows of \
                 the other",
                self.clock_steps_back, self.rows
            );
            return at(self.first_backwards.unwrap_or(0), message);
        }
        // A clock may stumble in some rows; one that does so in many is not the time.
        // A row of each episode was behind before it showed that an episode begins.
        let slips = self.clock_backwards.saturating_sub(self.episodes_by_clock);
        if slips as f64 > LARGEST_BACKWARD_SHARE * self.rows as f64 {
            let message = format!(
                "column `{time}` runs backwards in {slips} rows, here first: two runs in one file, or not the time; split the file",
            );
            return at(self.first_backwards.unwrap_or(0), message);
        }
        if self.clock_repeated as f64 > 0.5 * self.rows as f64 {
            let message = format!(
                "column `{time}` stands still in {} of {} rows; it is not the time",
                self.clock_repeated, self.rows
            );
            return at(0, message);
        }
        Ok(())
    }

    /// Most rows must be whole, and enough must be left.
    fn check_rows(&self, file: &str) -> Result<(), Error> {
        let at = |line: usize, message: String| Err(Error::at(file, line, message));
        if self.ragged > self.rows / 2 {
            let message =
                format!("{} of {} rows have more or fewer cells than the header has names", self.ragged, self.rows);
            return at(0, message);
        }
        if self.kept < MIN_ROWS {
            let message = format!(
                "{} usable rows of {} ({} with missing or infinite numbers); at least {MIN_ROWS} are needed",
                self.kept, self.rows, self.not_finite
            );
            return at(0, message);
        }
        Ok(())
    }

    /// Refuses steps that are none in the unit that the header seems to say, and a clock in pieces.
    fn check_steps(&self, file: &str, time: &str) -> Result<(), Error> {
        let at = |line: usize, message: String| Err(Error::at(file, line, message));
        if !(self.period.is_finite() && self.duration.is_finite()) {
            return at(0, "the clock leaves the range of numbers".into());
        }
        if self.period < FASTEST_CLOCK_STEP_S {
            let message = format!(
                "column `{time}` steps by {:e} s, which no robot is sampled at; its unit is not the one of its name",
                self.period
            );
            return at(0, message);
        }
        let said =
            ["_s", "(s)", "[s]", "sec", "secs", "seconds"].iter().any(|unit| time.to_lowercase().ends_with(unit));
        if self.period > SLOWEST_CLOCK_STEP_S && !said {
            let message = format!(
                "column `{time}` steps by {} s: too slow to see dynamics; if it is in ms, name it `{time}_ms`, if in s, \
                 `{time}_s`",
                self.period
            );
            return at(0, message);
        }
        // Between gaps fewer rows are left than can be filtered.
        if self.gaps * MIN_ROWS > self.kept {
            let message = format!(
                "the clock steps by {:.6} s in most rows, and by more than {GAP_PERIODS} times that in {}: stamps of rows that \
                 arrived in bursts? Log the stamps of the sender; or, where rows are evenly spaced, number them and \
                 multiply by {:.6} s",
                self.period,
                self.gaps,
                self.duration / (self.kept - 1) as f64
            );
            return at(0, message);
        }
        Ok(())
    }
}

impl fmt::Display for LogReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let clock = if self.uniform { "uniform" } else { "not uniform" };
        writeln!(
            f,
            "{} rows, {} used; {} s, median step {} s ({clock}, longest {} s)",
            self.rows,
            self.kept,
            trimmed(self.duration, 3),
            trimmed(self.period, 6),
            trimmed(self.longest_step, 6)
        )?;
        for (begun, why) in [
            (self.episodes_by_column, "the column that numbers them changes"),
            (self.episodes_by_clock, "the clock begins anew"),
        ] {
            if begun > 0 {
                writeln!(
                    f,
                    "{} episodes: {why}; each is filtered by itself, and a pause stands between them",
                    begun + 1
                )?;
            }
        }
        let episodes = self.episodes_by_column + self.episodes_by_clock;
        let line = self.first_not_finite.map_or(String::new(), |l| format!(", first in line {l}"));
        for (count, one, more, what) in [
            (self.not_finite, "row", "rows", format!("left out: a number is missing or infinite{line}")),
            (self.clock_repeated, "row", "rows", "left out: the clock repeats".into()),
            (self.clock_backwards, "row", "rows", "left out: the clock runs backwards".into()),
            (self.ragged, "row", "rows", "with more or fewer cells than the header".into()),
            (self.wrapped, "jump", "jumps", "by a turn in the positions, taken back".into()),
            (self.repeated, "row repeats", "rows repeat", "the row before (kept)".into()),
            (
                self.gaps.saturating_sub(episodes),
                "gap",
                "gaps",
                format!("in the clock longer than {GAP_PERIODS} steps (the parts between are filtered by themselves)"),
            ),
        ] {
            if count > 0 {
                writeln!(f, "{count} {} {what}", if count == 1 { one } else { more })?;
            }
        }
        if let Some(sentence) = self.refresh.sentence(self.period) {
            writeln!(f, "{sentence}")?;
        }
        self.suspect.iter().try_for_each(|s| write!(f, "{s}"))?;
        if self.rest > 0.0 && self.rest_before >= self.duration {
            writeln!(f, "at rest throughout")?;
        } else if self.rest > 0.0 {
            let (before, after) = (self.rest_before, self.rest_after);
            let between = (self.rest - before - after).max(0.0);
            let parts = format!("{before:.2} s at the start, {between:.2} s between, {after:.2} s at the end");
            writeln!(f, "at rest {:.2} s: {parts}", before + between + after)?;
        }
        Ok(())
    }
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// A number with at most so many decimals, and no zeros behind them.
fn trimmed(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    text.trim_end_matches('0').trim_end_matches('.').into()
}

/// Whether a step of the clock is that of a uniform clock.
pub(crate) fn even(step: f64, period: f64) -> bool {
    (step - period).abs() <= 0.01 * period
}
