//! A line over time that takes no more room than its picture: the smallest and the largest value of each span of time.
//!
//! Spans begin as single samples. When there are more than `MAX_SPANS` of them, neighbours are put together and the
//! span becomes twice as long. So the length of a signal need not be known beforehand, and no peak is lost. A gap that
//! is longer than the spans beside it stays a gap.

/// Largest number of spans, about one per pixel. At least half of them are used once there are as many samples.
const MAX_SPANS: usize = 720;

/// More spans than this after neighbours are put together make room too seldom.
const MAX_SPANS_WITH_GAPS: usize = MAX_SPANS * 3 / 4;

/// A line over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Envelope {
    spans: Vec<Span>,
    /// Samples in a span.
    length: usize,
    /// Samples in the last span.
    filled: usize,
    is_interrupted: bool,
}

/// Some successive samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Time of the first, s.
    pub t: f64,
    /// Time of the last, s.
    pub end: f64,
    /// The smallest value.
    pub low: f64,
    /// The largest value.
    pub high: f64,
    /// Whether the line is broken before it.
    pub is_first: bool,
}

impl Default for Envelope {
    fn default() -> Envelope {
        Envelope { spans: Vec::new(), length: 1, filled: 0, is_interrupted: true }
    }
}

impl Envelope {
    /// Breaks the line.
    pub fn interrupt(&mut self) {
        self.is_interrupted = true;
    }

    /// Appends a sample at a time that is not before the last.
    pub fn push(&mut self, t: f64, value: f64) {
        match self.spans.last_mut() {
            Some(last) if self.filled < self.length && !self.is_interrupted => {
                (last.end, last.low, last.high) = (t, last.low.min(value), last.high.max(value));
                self.filled += 1;
            }
            _ => {
                if self.spans.len() == MAX_SPANS {
                    self.halve();
                }
                self.spans.push(Span { t, end: t, low: value, high: value, is_first: self.is_interrupted });
                (self.filled, self.is_interrupted) = (1, false);
            }
        }
    }

    /// The spans in the order of time.
    pub fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// Whether a span holds several samples.
    pub fn is_thinned(&self) -> bool {
        self.length > 1
    }

    /// Samples of a span.
    pub fn samples_of_a_span(&self) -> usize {
        self.length
    }

    fn halve(&mut self) {
        let together = |a: &Span, b: &Span| Span { end: b.end, low: a.low.min(b.low), high: a.high.max(b.high), ..*a };
        // A gap is seen where it is longer than what stands on both sides of it.
        let is_gap = |a: &Span, b: &Span| b.is_first && b.t - a.end > (a.end - a.t).max(b.end - b.t);
        let pairs = |keeps_gaps: bool| {
            let (mut spans, mut rest) = (Vec::new(), self.spans.as_slice());
            while let [a, behind @ ..] = rest {
                let partner = behind.first().filter(|b| !(keeps_gaps && is_gap(a, b)));
                spans.push(partner.map_or(*a, |b| together(a, b)));
                rest = &behind[usize::from(partner.is_some())..];
            }
            spans
        };
        let kept = pairs(true);
        // Where nearly every sample stands alone, gaps are lost rather than room.
        self.spans = if kept.len() <= MAX_SPANS_WITH_GAPS { kept } else { pairs(false) };
        self.length *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However long the signal, the room is the same and the peaks are there.
    #[test]
    fn a_million_samples_keep_their_peaks() {
        let mut line = Envelope::default();
        for i in 0..1_000_000 {
            let peak = if i == 123_456 { 9.0 } else { 0.0 };
            line.push(i as f64 * 1e-3, (i as f64 * 1e-3).sin() + peak);
        }
        let spans = line.spans();
        assert!(spans.len() <= MAX_SPANS && spans.len() > MAX_SPANS / 2, "{}", spans.len());
        assert!(spans.iter().any(|s| s.high > 8.0 && (s.t - 123.456).abs() < 3.0));
        assert!(spans.windows(2).all(|w| w[0].t < w[1].t && !w[1].is_first));
        assert!(line.is_thinned());
    }

    /// A second of samples, a second without, forty times: no span reaches over a gap, however much is put together.
    #[test]
    fn long_gaps_stay_gaps() {
        let mut line = Envelope::default();
        for i in 0..80_000 {
            match i / 1000 % 2 {
                0 => line.push(f64::from(i) * 1e-3, 1.0),
                _ => line.interrupt(),
            }
        }
        assert!(line.is_thinned() && line.spans().len() <= MAX_SPANS);
        for pair in line.spans().windows(2) {
            assert!(pair[0].end - pair[0].t < 1.0);
            assert_eq!(pair[1].is_first, pair[1].t - pair[0].end > 0.5, "{pair:?}");
        }
    }

    /// Samples that all stand alone take no more room than others.
    #[test]
    fn lonely_samples_take_no_more_room() {
        let mut line = Envelope::default();
        for i in 0..10_000 {
            line.interrupt();
            line.push(f64::from(i), 1.0);
        }
        assert!(line.spans().len() <= MAX_SPANS, "{}", line.spans().len());
    }

    #[test]
    fn breaks_stay_while_they_can_be_seen() {
        let mut line = Envelope::default();
        for (i, value) in [1.0, 2.0, 3.0, 4.0].into_iter().enumerate() {
            if i == 2 {
                line.interrupt();
            }
            line.push(i as f64, value);
        }
        let first: Vec<bool> = line.spans().iter().map(|s| s.is_first).collect();
        assert_eq!((first, line.is_thinned()), (vec![true, false, true, false], false));
    }
}
