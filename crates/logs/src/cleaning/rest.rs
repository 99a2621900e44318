//! Finds how long the robot is at rest in a log.
//!
//! The robot is at rest in an interval if the mean speed of every joint is small. A long log is read in blocks, and the
//! durations of the blocks are combined.

/// Largest speed of a joint at rest, rad/s, averaged over [`REST_SPAN_S`].
const REST_SPEED_RAD_S: f64 = 1e-3;
/// Time over which the speed is averaged, s.
const REST_SPAN_S: f64 = 0.05;

/// Durations of rest, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RestTimes {
    /// Duration of rest at the start of the log.
    pub before: f64,
    /// Duration of rest at the end of the log.
    pub after: f64,
    /// Total duration of rest.
    pub total: f64,
}

impl RestTimes {
    /// Evaluates the positions `q` at the times `t` (s) in intervals of [`REST_SPAN_S`]. Samples after the last whole interval
    /// count as rest if this interval is at rest.
    pub(crate) fn of(t: &[f64], q: &[Vec<f64>]) -> RestTimes {
        let (mut before, mut after, mut total, mut r0) = (None, 0.0, 0.0, 0);
        for r in 1..t.len() {
            let span = t[r] - t[r0];
            if span < REST_SPAN_S {
                continue;
            }
            if q.iter().any(|q| (q[r] - q[r0]).abs() > REST_SPEED_RAD_S * span) {
                before.get_or_insert(t[r0] - t[0]);
                after = 0.0;
            } else {
                total += span;
                after += span;
            }
            r0 = r;
        }
        let behind = t[t.len() - 1] - t[r0];
        if after > 0.0 {
            (after, total) = (after + behind, total + behind);
        }
        let all = t[t.len() - 1] - t[0];
        match before {
            Some(before) => RestTimes { before, after, total },
            None if total > 0.0 => RestTimes { before: all, after: all, total: all },
            // The log is shorter than one interval, so rest is not determined.
            None => RestTimes::default(),
        }
    }

    /// Whether the whole log is at rest. `duration`: its length, s.
    fn is_throughout(&self, duration: f64) -> bool {
        self.total > 0.0 && self.before >= duration
    }

    /// Adds the times at rest in the next block of the same file. The block starts `step` s after the end of this one.
    /// Durations in s.
    pub(crate) fn append(&mut self, duration: f64, next: &RestTimes, next_duration: f64, step: f64) {
        // If the joints are at rest at the end of one block and at the start of the next, they are at rest between the blocks.
        let seam = if self.after > 0.0 && next.before > 0.0 { step } else { 0.0 };
        if self.is_throughout(duration) {
            self.before += seam + next.before;
        }
        self.after = next.after + if next.is_throughout(next_duration) { self.after + seam } else { 0.0 };
        self.total += seam + next.total;
    }

    /// The sentence of the report on rest, for a log of this duration, s; `None` if the robot is never at rest.
    pub(crate) fn sentence(&self, duration: f64) -> Option<String> {
        if self.is_throughout(duration) {
            return Some("at rest throughout".into());
        }
        let RestTimes { before, after, total } = self;
        let between = (total - before - after).max(0.0);
        let parts = format!("{before:.2} s at the start, {between:.2} s between, {after:.2} s at the end");
        (*total > 0.0).then(|| format!("at rest {:.2} s: {parts}", before + between + after))
    }
}
