//! How long a robot rests in a log.

/// At rest: no joint is faster than this, rad/s, over [`REST_SPAN_S`].
const REST_SPEED_RAD_S: f64 = 1e-3;
/// Span over which the speed at rest is taken, s.
const REST_SPAN_S: f64 = 0.05;

/// How long a robot rests, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rest {
    /// At the start.
    pub before: f64,
    /// At the end.
    pub after: f64,
    /// In all.
    pub total: f64,
}

impl Rest {
    /// Measured in spans of [`REST_SPAN_S`]. The remainder behind the last span counts as a continuation of it.
    pub(crate) fn of(t: &[f64], q: &[Vec<f64>]) -> Rest {
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
            Some(before) => Rest { before, after, total },
            None if total > 0.0 => Rest { before: all, after: all, total: all },
            // Shorter than a span: nothing is known.
            None => Rest::default(),
        }
    }

    /// Whether a log of so many seconds is at rest throughout.
    fn is_throughout(&self, duration: f64) -> bool {
        self.total > 0.0 && self.before >= duration
    }

    /// Adds that of the next part of the same file, which starts `step` s after the end of this; durations in s.
    pub(crate) fn append(&mut self, duration: f64, next: &Rest, next_duration: f64, step: f64) {
        // At rest on both sides of the seam, the joints are at rest across it.
        let seam = if self.after > 0.0 && next.before > 0.0 { step } else { 0.0 };
        if self.is_throughout(duration) {
            self.before += seam + next.before;
        }
        self.after = next.after + if next.is_throughout(next_duration) { self.after + seam } else { 0.0 };
        self.total += seam + next.total;
    }

    /// For a log of so many seconds; `None` where it never rests.
    pub(crate) fn sentence(&self, duration: f64) -> Option<String> {
        if self.is_throughout(duration) {
            return Some("at rest throughout".into());
        }
        let Rest { before, after, total } = self;
        let between = (total - before - after).max(0.0);
        let parts = format!("{before:.2} s at the start, {between:.2} s between, {after:.2} s at the end");
        (*total > 0.0).then(|| format!("at rest {:.2} s: {parts}", before + between + after))
    }
}
