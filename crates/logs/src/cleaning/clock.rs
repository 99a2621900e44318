//! The steps of a log's clock.

use crate::Error;

/// The clock of the used rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clock {
    /// Time from the first to the last sample, s.
    pub duration: f64,
    /// Median step, s.
    pub period: f64,
    /// Longest step, s.
    pub longest_step: f64,
    /// Whether every step is within 1 % of the median.
    pub uniform: bool,
    /// Steps longer than [`GAP_PERIODS`] periods.
    pub gaps: usize,
}

/// A step of more than this multiple of the median is a gap: there is no interpolation across it.
pub const GAP_PERIODS: f64 = 10.0;

/// Largest step, s, of a clock that is taken to be in s without a unit in its header.
pub(crate) const SLOWEST_CLOCK_STEP_S: f64 = 0.5;

/// Smallest step, s, of a clock in the right unit: no robot is sampled faster.
const FASTEST_CLOCK_STEP_S: f64 = 1e-6;

/// Least number of samples for filtering and differentiation.
pub(crate) const MIN_ROWS: usize = 50;
/// Greatest deviation of a step of a uniform clock from the median, as a share of the median.
const UNIFORM_STEP_TOLERANCE: f64 = 0.01;

impl Clock {
    /// From samples at strictly increasing times, s; `None` where there is no step.
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

    /// Adds the next block of the same file, which starts `step` s after the end of this one. A block of one sample has no clock.
    pub(crate) fn append(&mut self, next: Option<&Clock>, step: f64) {
        self.uniform &= even(step, self.period) && next.is_none_or(|n| n.uniform && even(n.period, self.period));
        self.longest_step = self.longest_step.max(step).max(next.map_or(0.0, |n| n.longest_step));
        self.gaps += usize::from(step > GAP_PERIODS * self.period) + next.map_or(0, |n| n.gaps);
        self.duration += step + next.map_or(0.0, |n| n.duration);
    }

    /// Refuses a median step that is impossible in the unit of the header, and a clock with too many gaps; `kept`: number of used
    /// rows.
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
        // Between gaps there are fewer rows than can be filtered.
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

    /// Its duration and its steps, in words.
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
