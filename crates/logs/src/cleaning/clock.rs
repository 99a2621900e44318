//! Statistics of the clock of a log: its duration, period and gaps.
//!
//! A long log is read in blocks; each block has such statistics, and they are combined.

use crate::Error;

/// The clock of the used rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clock {
    /// Time from the first to the last sample, s.
    pub duration: f64,
    /// Median step between samples, s.
    pub period: f64,
    /// Longest step between samples, s.
    pub longest_step: f64,
    /// Whether every step is within 1 % of the median.
    pub uniform: bool,
    /// Number of steps longer than [`GAP_PERIODS`] periods.
    pub gaps: usize,
}

/// A step of more than this multiple of the median step is a gap. Signals are not interpolated across a gap.
pub const GAP_PERIODS: f64 = 10.0;

/// A clock without a unit in its header is assumed to be in s if its median step is at most this value, s.
pub(crate) const SLOWEST_CLOCK_STEP_S: f64 = 0.5;

/// The smallest possible median step (s), because no robot is sampled faster. A smaller step means a wrong unit.
const FASTEST_CLOCK_STEP_S: f64 = 1e-6;

/// Smallest number of samples for filtering and differentiation.
pub(crate) const MIN_ROWS: usize = 50;
/// A clock is uniform if no step differs from the median step by more than this fraction of the median.
const UNIFORM_STEP_TOLERANCE: f64 = 0.01;

impl Clock {
    /// The clock of samples at strictly increasing times `t`, s. `None` if there are fewer than two samples.
    pub(crate) fn of(t: &[f64]) -> Option<Clock> {
        let mut steps: Vec<f64> = t.windows(2).map(|w| w[1] - w[0]).collect();
        let duration = t.last()? - t.first()?;
        let longest_step = steps.iter().copied().reduce(f64::max)?;
        let middle = steps.len() / 2;
        let period = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
        let uniform = steps.iter().all(|&s| even(s, period));
        let gaps = steps.iter().filter(|&&s| s > GAP_PERIODS * period).count();
        Some(Clock { duration, period, longest_step, uniform, gaps })
    }

    /// Adds the clock of the next block of the same file, which starts `step` s after the end of this one. `next` is `None` if
    /// the block has only one sample.
    pub(crate) fn append(&mut self, next: Option<&Clock>, step: f64) {
        self.uniform &= even(step, self.period) && next.is_none_or(|n| n.uniform && even(n.period, self.period));
        self.longest_step = self.longest_step.max(step).max(next.map_or(0.0, |n| n.longest_step));
        self.gaps += usize::from(step > GAP_PERIODS * self.period) + next.map_or(0, |n| n.gaps);
        self.duration += step + next.map_or(0.0, |n| n.duration);
    }

    /// Fails if the median step is impossible in the unit of the header, or if the clock has too many gaps. `kept`: number of
    /// used rows.
    pub(crate) fn check(&self, file: &str, time: &str, kept: usize) -> Result<(), Error> {
        let refused = |message: String| Err(Error::at(file, 0, message));
        let Clock { duration, period, gaps, .. } = self;
        if !(period.is_finite() && duration.is_finite()) {
            return refused("the clock exceeds the range of floating-point numbers".into());
        }
        if *period < FASTEST_CLOCK_STEP_S {
            return refused(format!(
                "column `{time}` steps by {period:e} s, which no robot is sampled at; its unit is not the one of its name"
            ));
        }
        let said =
            ["_s", "(s)", "[s]", "sec", "secs", "seconds"].iter().any(|unit| time.to_lowercase().ends_with(unit));
        if *period > SLOWEST_CLOCK_STEP_S && !said {
            return refused(format!(
                "column `{time}` steps by {period} s: too slow to see dynamics; if it is in ms, name it `{time}_ms`, if in \
                 s, `{time}_s`"
            ));
        }
        // If there are so many gaps, the intervals between gaps have too few rows for filtering.
        if gaps * MIN_ROWS > kept {
            let mean = duration / (kept - 1) as f64;
            return refused(format!(
                "the clock steps by {period:.6} s in most rows, and by more than {GAP_PERIODS} times that in {gaps}: stamps of \
                 rows that arrived in bursts? Log the stamps of the sender; or, where rows are evenly spaced, number them \
                 and multiply by {mean:.6} s"
            ));
        }
        Ok(())
    }

    /// The duration of the clock and its steps, as text.
    pub(crate) fn in_words(&self) -> String {
        let evenness = if self.uniform { "uniform" } else { "not uniform" };
        let numbers = [(self.duration, 3), (self.period, 6), (self.longest_step, 6)];
        let [duration, period, longest] = numbers.map(|(x, decimals)| trimmed(x, decimals));
        format!("{duration} s, median step {period} s ({evenness}, longest {longest} s)")
    }
}

/// A number with at most this number of decimals, without trailing zeros.
fn trimmed(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    text.trim_end_matches('0').trim_end_matches('.').into()
}

/// Whether a step of the clock is within the tolerance of a uniform clock.
pub(crate) fn even(step: f64, period: f64) -> bool {
    (step - period).abs() <= UNIFORM_STEP_TOLERANCE * period
}
