//! A line over time that takes no more room than its picture: the smallest and the largest value of each span of time.
//!
//! Spans begin as single samples. When there are more than `MAX_SPANS` of them, neighbours are put together and the
//! span becomes twice as long. So the length of a signal need not be known beforehand, and no peak is lost.

/// Largest number of spans, about one per pixel. At least half of them are used once there are as many samples.
const MAX_SPANS: usize = 720;

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
                (last.low, last.high) = (last.low.min(value), last.high.max(value));
                self.filled += 1;
            }
            _ => {
                if self.spans.len() == MAX_SPANS {
                    self.halve();
                }
                self.spans.push(Span { t, low: value, high: value, is_first: self.is_interrupted });
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
        let together = |pair: &[Span]| Span {
            low: pair.iter().fold(f64::INFINITY, |a, s| a.min(s.low)),
            high: pair.iter().fold(f64::NEG_INFINITY, |a, s| a.max(s.high)),
            ..pair[0]
        };
        self.spans = self.spans.chunks(2).map(together).collect();
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
