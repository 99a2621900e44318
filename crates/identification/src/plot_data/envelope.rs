//! A line over time with the resolution of a plot. A span is a group of successive samples, of which only the smallest and the
//! largest value are stored.
//!
//! At first, each span contains one sample. When the number of spans reaches its limit m, neighbouring spans are merged in
//! pairs, and each span then contains up to twice as many samples. So a signal of any length fits, and no peak is lost.
//!
//! Two spans are not merged across a long gap of the log, so that the plot shows this gap. A gap is long if it exceeds 2 D / m,
//! where D is the duration of the line. The line has fewer than m / 2 long gaps, because their total length is less than D. So
//! each round of merging removes at least a quarter of the spans.
//!
//! A sample with a missing value (NaN) still belongs to a span. A span in which all values are missing is a gap of the plot. So
//! two lines with samples at the same times have spans at the same times, even if one of the lines lacks values.

/// Largest number of spans of a drawn line, about one per pixel. With enough samples, at least half of these spans are used.
pub const DRAWN_SPANS: usize = 720;

/// A line over time, stored as spans with smallest and largest values.
#[derive(Clone, Debug, PartialEq)]
pub struct Envelope {
    spans: Vec<Span>,
    /// Largest number of spans of this line.
    most: usize,
    /// Number of samples per span.
    length: usize,
    /// Number of samples in the last span.
    filled: usize,
    is_interrupted: bool,
}

/// A span: several successive samples of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Time of the first sample, s.
    pub t: f64,
    /// Time of the last sample, s.
    pub end: f64,
    /// The smallest value; NaN if no sample has a value.
    pub low: f64,
    /// The largest value; NaN if no sample has a value.
    pub high: f64,
    /// Whether the line is broken before this span.
    pub is_first: bool,
}

impl Default for Envelope {
    fn default() -> Envelope {
        Envelope::of_spans(DRAWN_SPANS)
    }
}

impl Envelope {
    /// An empty line of at most `most` spans (if `most` is below 4: four).
    pub fn of_spans(most: usize) -> Envelope {
        Envelope { spans: Vec::new(), most: most.max(4), length: 1, filled: 0, is_interrupted: true }
    }

    /// Breaks the line before the next sample.
    pub fn interrupt(&mut self) {
        self.is_interrupted = true;
    }

    /// Appends a sample with the time t, s, which must not decrease. NaN: the sample has no value.
    pub fn push(&mut self, t: f64, value: f64) {
        match self.spans.last_mut() {
            Some(last) if self.filled < self.length && !self.is_interrupted => {
                (last.end, last.low, last.high) = (t, last.low.min(value), last.high.max(value));
                self.filled += 1;
            }
            _ => {
                if self.spans.len() >= self.most {
                    self.halve();
                }
                self.spans.push(Span { t, end: t, low: value, high: value, is_first: self.is_interrupted });
                (self.filled, self.is_interrupted) = (1, false);
            }
        }
    }

    /// All spans in the order of time.
    pub fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// The segments of the line: successive spans with values and without a gap.
    pub fn pieces(&self) -> Vec<&[Span]> {
        let mut pieces = Vec::new();
        let mut from = 0;
        for (i, span) in self.spans.iter().enumerate() {
            if span.low.is_nan() || span.is_first {
                pieces.push(&self.spans[from..i]);
                from = i + usize::from(span.low.is_nan());
            }
        }
        pieces.push(&self.spans[from..]);
        pieces.retain(|piece| !piece.is_empty());
        pieces
    }

    /// A copy of this line with at most `most` spans (if `most` is below 4: four).
    pub fn thinned_to(&self, most: usize) -> Envelope {
        let mut thinned = Envelope { most: most.max(4), ..self.clone() };
        while thinned.spans.len() > thinned.most {
            thinned.halve();
        }
        thinned
    }

    /// Whether spans contain several samples.
    pub fn is_thinned(&self) -> bool {
        self.length > 1
    }

    /// Number of samples per span.
    pub fn samples_of_a_span(&self) -> usize {
        self.length
    }

    fn halve(&mut self) {
        let duration = self.spans.first().zip(self.spans.last()).map_or(0.0, |(a, b)| b.end - a.t);
        let longest = 2.0 * duration / self.most as f64;
        let is_gap = |a: &Span, b: &Span| b.is_first && b.t - a.end > longest;
        let together = |a: &Span, b: &Span| Span { end: b.end, low: a.low.min(b.low), high: a.high.max(b.high), ..*a };
        let (mut spans, mut rest) = (Vec::with_capacity(self.most), self.spans.as_slice());
        while let [a, behind @ ..] = rest {
            let partner = behind.first().filter(|b| !is_gap(a, b));
            spans.push(partner.map_or(*a, |b| together(a, b)));
            rest = &behind[usize::from(partner.is_some())..];
        }
        self.spans = spans;
        self.length *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_samples_keep_their_peaks() {
        let mut line = Envelope::default();
        for i in 0..1_000_000 {
            let peak = if i == 123_456 { 9.0 } else { 0.0 };
            line.push(i as f64 * 1e-3, (i as f64 * 1e-3).sin() + peak);
        }
        let spans = line.spans();
        assert!(spans.len() <= DRAWN_SPANS && spans.len() > DRAWN_SPANS / 2, "{}", spans.len());
        assert!(spans.iter().any(|s| s.high > 8.0 && (s.t - 123.456).abs() < 3.0));
        assert!(spans.windows(2).all(|w| w[0].t < w[1].t && !w[1].is_first));
        assert!(line.is_thinned());
    }

    #[test]
    fn long_gaps_stay_gaps() {
        let mut line = Envelope::default();
        for i in 0..80_000 {
            match i / 1000 % 2 {
                0 => line.push(f64::from(i) * 1e-3, 1.0),
                _ => line.interrupt(),
            }
        }
        assert!(line.is_thinned() && line.spans().len() <= DRAWN_SPANS);
        for pair in line.spans().windows(2) {
            assert!(pair[0].end - pair[0].t < 1.0);
            assert_eq!(pair[1].is_first, pair[1].t - pair[0].end > 0.5, "{pair:?}");
        }
    }

    #[test]
    fn lonely_samples_take_no_more_room() {
        let mut line = Envelope::default();
        for i in 0..10_000 {
            line.interrupt();
            line.push(f64::from(i), 1.0);
        }
        assert!(line.spans().len() <= DRAWN_SPANS, "{}", line.spans().len());
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

    #[test]
    fn missing_values_are_gaps_on_the_same_spans() {
        let (mut whole, mut broken) = (Envelope::default(), Envelope::default());
        let rests = |t: f64| t % 0.5 > 0.3;
        for i in 0..20_000 {
            let t = f64::from(i) * 1e-3;
            whole.push(t, t.sin());
            broken.push(t, if rests(t) { f64::NAN } else { t.sin() });
        }
        let times = |e: &Envelope| e.spans().iter().map(|s| (s.t, s.end)).collect::<Vec<_>>();
        assert_eq!(times(&whole), times(&broken));
        // Twenty seconds contain forty intervals at rest. Each is a gap between two segments of the line.
        assert_eq!((whole.pieces().len(), broken.pieces().len()), (1, 40));
        for pair in broken.pieces().windows(2) {
            let gap = pair[1][0].t - pair[0].last().unwrap().end;
            // A rest takes 0.2 s. The gap is shorter by one span at both ends.
            assert!(gap > 0.1, "{gap}");
        }
    }

    #[test]
    fn a_thinner_line_is_around_the_finer_one() {
        let mut fine = Envelope::of_spans(4000);
        for i in 0..10_000 {
            if i == 5000 {
                fine.interrupt();
            }
            let t = f64::from(i) * 1e-3 + if i < 5000 { 0.0 } else { 1.0 };
            fine.push(t, (7.0 * t).sin());
        }
        let coarse = fine.thinned_to(DRAWN_SPANS);
        assert!(coarse.spans().len() <= DRAWN_SPANS && coarse.pieces().len() == 2);
        for span in fine.spans() {
            let around = coarse.spans().iter().find(|s| s.t <= span.t && span.end <= s.end);
            assert!(around.is_some_and(|s| s.low <= span.low && span.high <= s.high), "{span:?}");
        }
    }
}
